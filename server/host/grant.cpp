// SPDX-License-Identifier: Apache-2.0
#include "server/host/grant.h"

#include <algorithm>
#include <string>

#include <fmt/format.h>

#include "base/bound_to_float.h"

namespace seaway::server {

namespace {

using sea::CascadeBudget;
using sea::ErrorBudget;
using sea::FieldSet;
using Budgets = std::span<const ErrorBudget* const>;

/// Where smaller maps or fewer keyframes miss more than coding does, coding may add so much to the bound.
constexpr double codec_over_coarser = 1.1;
/// So that a rate that is met exactly is met.
constexpr double rate_slack = 1.0 + 1e-6;

void say(std::string& why, const std::string& reason) {
    why += (why.empty() ? "" : "; ") + reason;
}

std::string names(FieldSet fields) {
    std::string list;
    for (const sea::Field field : fields)
        list += (list.empty() ? "" : ", ") + std::string(sea::info(field).name);
    return list;
}

double rate_hz(const CascadeBudget& cascade) {
    return 1.0 / sea::seconds_from_us(cascade.interval_us);
}

double error_m(Budgets budgets, const Rung& rung, std::uint32_t cascades) {
    double largest = 0;
    for (const ErrorBudget* budget : budgets)
        largest = std::max(largest, height_error_m(*budget, number_of(rung), cascades));
    return largest;
}

/// Calls `what` with each cascade that is wanted, of each sea.
template <class What>
void for_each(Budgets budgets, const Demand& wish, const What& what) {
    for (const ErrorBudget* budget : budgets)
        for (std::size_t c = 0; c < budget->cascades.size(); ++c)
            if (wish.wants(static_cast<int>(c)))
                what(static_cast<int>(c), budget->cascades[c]);
}

/// The largest rung that is no more than was wished for; 0 where all there is is no more.
template <class Rungs>
std::size_t rung_within(const Rungs& rungs, double most, bool all_fit) {
    std::size_t rung = 0;
    while (!all_fit && (rung == 0 || rungs[rung] > most * rate_slack) && rung + 1 < rungs.size())
        ++rung;
    return rung;
}

/// Why maps of at most `size_max` points a side, at most `rate_hz_max` keyframes a second, cannot be had.
std::string cannot_be(Budgets budgets, const Demand& wish, const Rung& rung) {
    std::string why;
    for_each(budgets, wish, [&](int c, const CascadeBudget& cascade) {
        if (!why.empty())
            return;
        const int size = sent_size(cascade, rung);
        const double slowest_hz = rate_hz(cascade) / cascade.every_max;
        if (wish.size_max > 0 && size > wish.size_max)
            why = fmt::format("size_max is {}: cascade {} has waves that cannot be cut, its maps "
                              "have {} points a side",
                              wish.size_max, c, size);
        else if (wish.rate_hz_max > 0 && slowest_hz > wish.rate_hz_max * rate_slack)
            why = fmt::format("rate_hz_max is {:g}: cascade {} takes {:.3g} keyframes a second at "
                              "least, fewer say nothing of its waves",
                              wish.rate_hz_max, c, slowest_hz);
    });
    return why;
}

/// The cheapest codec rung that keeps the wish. Where none does, or none was wished for: the best; of coarser maps the
/// cheapest that adds little to what they miss.
std::size_t codec_for(Budgets budgets, const Demand& wish, Rung rung) {
    const auto cheapest_within = [&](double bound_m) {
        std::size_t cheapest = 0;
        for (rung.codec = 0; rung.codec < codec_rungs.size(); ++rung.codec)
            if (error_m(budgets, rung, wish.cascades) <= bound_m)
                cheapest = rung.codec;
        return cheapest;
    };
    rung.codec = 0;
    const double best_m = error_m(budgets, rung, wish.cascades);
    const auto wished_m = static_cast<double>(wish.error_m);
    if (is_coarser(number_of(rung)) && wished_m < best_m)
        return cheapest_within(codec_over_coarser * best_m);
    return cheapest_within(wished_m);
}

/// A rung that others have and that is no more than this one, the one with the smallest error; none: the same one. Of the same rate,
/// which a stream keeps when its grant is renewed.
Quality shared_instead(Budgets budgets, const Rung& wished, std::uint32_t cascades,
                       const std::bitset<quality_rungs>& in_use) {
    Quality best = number_of(wished);
    double best_m = 0;
    for (std::size_t n = whole_rungs; n < in_use.size(); ++n) {
        const Rung rung = rung_of(static_cast<Quality>(n));
        const bool alike = rung.compact == wished.compact && rung.predicted == wished.predicted &&
                           (rung.size == 0) == (wished.size == 0) && rung.rate == wished.rate;
        if (!in_use[n] || !alike || rung.size < wished.size)
            continue;
        if (const double bound_m = error_m(budgets, rung, cascades);
            best_m == 0 || bound_m < best_m) {
            best = static_cast<Quality>(n);
            best_m = bound_m;
        }
    }
    return best;
}

bool full(const std::bitset<quality_rungs>& in_use) {
    std::size_t coarser = 0;
    for (std::size_t n = whole_rungs; n < in_use.size(); ++n)
        coarser += in_use[n] ? 1u : 0u;
    return coarser >= coarser_rungs_max;
}

/// Cascades and fields that there are, of those that can be had at this size and rate.
void grant_maps(Demand& granted, const Demand& wish, Budgets budgets, FieldSet offered,
                const Rung& rung) {
    granted.cascades = wish.cascades & ((1u << budgets.front()->cascades.size()) - 1u);
    if (wish.cascades != sea::all_cascades && granted.cascades != wish.cascades)
        say(granted.why, fmt::format("this sea has {} cascades", budgets.front()->cascades.size()));
    granted.fields = wish.fields & offered;
    if (const FieldSet missing = wish.fields.without(granted.fields); !missing.empty())
        say(granted.why, fmt::format("this sea streams no {}", names(missing)));
    FieldSet whole;
    for (const sea::Field field : granted.fields)
        if (!sea::is_linear(field))
            whole.insert(field);
    bool too_large = false;
    for_each(budgets, granted, [&](int, const CascadeBudget& cascade) {
        too_large = too_large || (wish.size_max > 0 && cascade.size > wish.size_max);
    });
    if (too_large && !whole.empty()) {
        say(granted.why, fmt::format("{}: no sum of waves, only on whole grids", names(whole)));
        granted.fields = granted.fields.without(whole);
    }
    if (rung.rate != 0 && granted.fields.contains(sea::Field::foam)) {
        say(granted.why, "foam is a history: only with every keyframe");
        granted.fields = granted.fields.without({sea::Field::foam});
    }
}

/// What a client is told of a coarser rung.
void state_coarser(Demand& granted, const Demand& wish, Budgets budgets, const Rung& rung) {
    for_each(budgets, granted, [&](int, const CascadeBudget& cascade) {
        const int every = sea::every_for(cascade, rate_rungs_hz[rung.rate]);
        if (rung.size != 0)
            granted.size_max = std::max(granted.size_max, sent_size(cascade, rung));
        if (rung.rate != 0)
            granted.rate_hz_max =
                std::max(granted.rate_hz_max, static_cast<float>(rate_hz(cascade) / every));
    });
    if (rung.size != 0 && size_rungs[rung.size] < wish.size_max)
        say(granted.why, fmt::format("maps have at most {} points a side: the next below {}",
                                     size_rungs[rung.size], wish.size_max));
    if (rung.rate != 0 && rate_rungs_hz[rung.rate] * rate_slack < wish.rate_hz_max)
        say(granted.why, fmt::format("at most {:g} keyframes a second: the next below {:g}",
                                     rate_rungs_hz[rung.rate], wish.rate_hz_max));
}

/// Noise of predicted heights is less than what is stated of it (docs/performance/line.md), though not even: a little more of it lies in
/// long waves, which shallow water moves far sideways.
constexpr double predicted_gain_max = 0.6;

bool noise_is_even_enough(const ErrorBudget& budget, const CascadeBudget& cascade, int size) {
    if (!budget.displacement_follows)
        return true;
    for (std::size_t n = 0; n < sea::smaller_grids.size(); ++n)
        if (sea::smaller_grids[n] == size && size < cascade.compact_size)
            return cascade.cuts[n].follows_gain <= predicted_gain_max;
    return cascade.follows_gain <= predicted_gain_max;
}

} // namespace

RungMaps maps_of(const ErrorBudget& budget, int cascade, FieldSet fields, Quality quality) {
    const CascadeBudget& own = budget.cascades[static_cast<std::size_t>(cascade)];
    const Rung rung = rung_of(quality);
    const sea::CoarserMaps maps = coarser_maps(own, rung);
    const int size = sent_size(own, rung);
    return {sea::codec_bounds(budget, fields, cascade, codec_error_m(budget, quality), size,
                              maps.every),
            rung.compact || size < own.size ? size : 0, sea::coarser_loss(budget, cascade, maps),
            maps.every, rung.predicted && noise_is_even_enough(budget, own, size)};
}

FieldSet follows_of(const ErrorBudget& budget, FieldSet offered, Quality quality) {
    const Rung rung = rung_of(quality);
    if (!rung.compact || !budget.displacement_follows)
        return {};
    for (const CascadeBudget& cascade : budget.cascades)
        for (std::size_t n = 0; n < sea::smaller_grids.size(); ++n)
            if (sea::smaller_grids[n] == coarser_maps(cascade, rung).size &&
                cascade.cuts[n].follows_gain > sea::follows_gain_max)
                return {};
    return sea::following(offered) & offered;
}

Demand grant_of(const Demand& wish, Budgets budgets, FieldSet offered,
                const std::bitset<quality_rungs>& in_use) {
    Rung rung{.compact = wish.compact, .predicted = wish.compact && wish.predicted};
    bool small_enough = wish.size_max == 0, slow_enough = !(wish.rate_hz_max > 0);
    if (!small_enough) {
        small_enough = true;
        for_each(budgets, wish, [&](int, const CascadeBudget& cascade) {
            small_enough = small_enough && sent_size(cascade, rung) <= wish.size_max;
        });
    }
    if (!slow_enough) {
        slow_enough = true;
        for_each(budgets, wish, [&](int, const CascadeBudget& cascade) {
            slow_enough = slow_enough && rate_hz(cascade) <= wish.rate_hz_max * rate_slack;
        });
    }
    rung.size = rung_within(size_rungs, wish.size_max, small_enough);
    rung.rate = wish.renewed ? rung_of(wish.quality).rate
                             : rung_within(rate_rungs_hz, wish.rate_hz_max, slow_enough);
    Demand granted;
    grant_maps(granted, wish, budgets, offered, rung);
    if (granted.empty())
        return {.why = granted.why};
    if (const std::string why = cannot_be(budgets, granted.limited_as(wish), rung); !why.empty()) {
        if (!wish.renewed)
            return {.why = why};
        say(granted.why, why);
    }
    rung.codec = codec_for(budgets, wish, rung);
    granted.quality = number_of(rung);
    if (is_coarser(granted.quality) && !in_use[granted.quality] &&
        (wish.shared_only || full(in_use))) {
        granted.quality = shared_instead(budgets, rung, wish.cascades, in_use);
        const std::string why =
            wish.shared_only
                ? fmt::format("{} kinds of coarser maps are in use by others of this address",
                              coarser_rungs_of_address_max)
                : fmt::format("{} kinds of coarser maps are in use by others", coarser_rungs_max);
        if (!in_use[granted.quality])
            return {.why = why, .busy = true};
        rung = rung_of(granted.quality);
        granted.crowded = true;
        say(granted.why, why);
    }
    if (is_coarser(granted.quality))
        state_coarser(granted, wish, budgets, rung);
    const double bound_m = error_m(budgets, rung, wish.cascades);
    granted.error_m = bound_to_float(bound_m);
    if (wish.error_m > 0 && static_cast<float>(bound_m) > wish.error_m) // 0.01 is as fine as 0.01
        say(granted.why,
            fmt::format("heights within {:.3g} m are the finest of {}", granted.error_m,
                        is_coarser(granted.quality) ? "such maps" : "this sea"));
    granted.compact = wish.compact;
    granted.follows = granted.fields & sea::following(granted.fields);
    for (const ErrorBudget* budget : budgets)
        granted.follows = granted.follows & follows_of(*budget, offered, granted.quality);
    granted.fields = granted.fields.without(granted.follows);
    return granted;
}

} // namespace seaway::server
