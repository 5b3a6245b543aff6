// SPDX-License-Identifier: Apache-2.0
#include "client/local_surface.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "client/link/failure.h"
#include "sea/surface/budget/error_budget.h"

namespace seaway::client {

using sea::Field;

namespace {

/// Adds what coding costs this field of a pair: the larger of the two keyframes', and of several fields' where two components
/// move a point.
void add_rounding(sea::MapLoss& loss, const KeyframePair& pair, Field value, Field rate) {
    const auto larger = [&](Field field) {
        return std::max(pair.before->coded_rms(field), pair.after->coded_rms(field));
    };
    loss.value_m = std::max(loss.value_m, larger(value));
    loss.rate_mps = std::max(loss.rate_mps, larger(rate));
    if (pair.before->compact() || pair.after->compact())
        loss.coded_relief = 0;
}

/// Adds what the coarser one of a pair misses.
void add_coarser(sea::CascadeLoss& loss, const KeyframePair& pair, sea::TimeUs interval_us) {
    const bool far_apart =
        pair.after->keyframe().time_us - pair.before->keyframe().time_us > interval_us;
    const auto take_larger = [](double& largest, double value) {
        largest = std::max(largest, value);
    };
    for (const HeldKeyframePtr& keyframe : {pair.before, pair.after}) {
        const sea::CoarserLoss& coarser = keyframe->coarser();
        take_larger(loss.height.cut_m, coarser.cut_m);
        take_larger(loss.displacement.cut_m, coarser.displacement_cut_m);
        if (!far_apart)
            continue;
        take_larger(loss.height.time_m, coarser.time_m);
        take_larger(loss.displacement.time_m, coarser.displacement_time_m);
    }
}

/// Noise of a displacement that follows from heights lies along its waves: kx^4/k^2 has a mean of 3/16 of the largest k^2,
/// half as much again as half of kx^2's.
constexpr double follows_steeper = 1.5;

/// What coding costs the gradient of D, by the keyframe of the two that it costs more.
double coded_strain_variance(const sea::MapLoss& loss, const KeyframePair& pair,
                             double interval_s) {
    const auto of = [&](const HeldKeyframe& keyframe) {
        const double variance = sea::coded_strain_variance(
            loss, interval_s, keyframe.coded_spacing_m(), keyframe.compact());
        return keyframe.follows(Field::displacement_x) ? follows_steeper * variance : variance;
    };
    return std::max(of(*pair.before), of(*pair.after));
}

sea::FoldSearch folds_of(const SeaState& state) {
    return sea::fold_search(state.displacement_reach_m, largest_choppiness(state),
                            state.rms_strain);
}

} // namespace

sea::Choppiness largest_choppiness(const SeaState& state) {
    sea::Choppiness largest{state.choppiness_x, state.choppiness_y};
    if (state.glide)
        largest = {std::max(largest.x, state.glide->choppiness_x),
                   std::max(largest.y, state.glide->choppiness_y)};
    return largest;
}

double shortest_wave_radpm(const SeaState& state) {
    double shortest_radpm = 0;
    for (const protocol::CascadeInfo& cascade : state.cascades)
        shortest_radpm = std::max(shortest_radpm, cascade.k_hi_radpm);
    return shortest_radpm;
}

double told_curvature_per_m(const SeaState& state) {
    return state.curvature_per_m > 0
               ? state.curvature_per_m
               : sea::bound_sigmas * state.rms_slope * shortest_wave_radpm(state);
}

void add_codec(sea::CascadeLoss& loss, const KeyframePair& pair) {
    add_rounding(loss.height, pair, Field::height, Field::height_rate);
    add_rounding(loss.displacement, pair, Field::displacement_x, Field::displacement_x_rate);
    add_rounding(loss.displacement, pair, Field::displacement_y, Field::displacement_y_rate);
    const sea::CodedNoise &first = pair.before->noise(), &then = pair.after->noise();
    // By its number: of its time there may be another one, of a stream that was coded otherwise; by its time, as well: of another server
    // that number is another's.
    if (first.at_m > 0 && then.between_m > 0 && then.before == first.number &&
        then.before_us == pair.before->keyframe().time_us) {
        loss.height.value_m = std::max(first.at_m, then.at_m);
        loss.height.between_m = then.between_m;
        loss.height.coded_relief = 0;
    }
}

sea::MapError local_map_error(const SeaState& state, std::span<const KeyframePair> pairs) {
    // A server that does not say what its interpolation errors are made of has them everywhere.
    const bool told = state.losses.size() == state.cascades.size();
    sea::MapError error{.cascades = {},
                        .height_bound_m =
                            told ? state.single_precision_m : state.interpolation_error_m,
                        .displacement_bound_m = told ? state.single_precision_displacement_m
                                                     : state.interpolation_displacement_m,
                        .strain_bound = state.interpolation_strain,
                        .rms_slope = state.rms_slope,
                        .curvature_per_m = told_curvature_per_m(state)};
    double coded_strain2 = 0, coarser_strain2 = 0;
    bool compact = false;
    for (const KeyframePair& pair : pairs) {
        const sea::Keyframe& map = pair.before->keyframe();
        const auto cascade = static_cast<std::size_t>(map.cascade);
        const sea::TimeUs interval_us = state.cascades[cascade].interval_us;
        sea::CascadeLoss& loss =
            error.cascades.emplace_back(told ? state.losses[cascade] : sea::CascadeLoss{});
        add_codec(loss, pair);
        add_coarser(loss, pair, interval_us);
        const double coarser_strain =
            std::max(pair.before->coarser().strain, pair.after->coarser().strain);
        coarser_strain2 += coarser_strain * coarser_strain;
        const sea::TimeUs apart_us = pair.after->keyframe().time_us - map.time_us;
        coded_strain2 += coded_strain_variance(
            loss.displacement, pair, sea::seconds_from_us(std::max(interval_us, apart_us)));
        compact = compact || pair.before->compact() || pair.after->compact();
    }
    if (compact) { // the way to the smaller grids and back
        error.height_bound_m += sea::regrid_over_single * state.single_precision_m;
        error.displacement_bound_m +=
            sea::regrid_over_single * state.single_precision_displacement_m;
    }
    if (coarser_strain2 > 0)
        error.strain_bound = std::hypot(error.strain_bound, std::sqrt(coarser_strain2));
    error.codec_strain_bound = sea::coded_strain_bound(largest_choppiness(state), coded_strain2);
    return error;
}

Result<void> check_time(sea::TimeUs time_us) {
    if (sea::in_time_range(time_us))
        return {};
    return failed(Failure::bad_argument, fmt::format("time_us is {}: it must be {} to {}", time_us,
                                                     -sea::time_us_max, sea::time_us_max));
}

Result<void> check_point(const sea::QueryPoint& point) {
    for (const double place_m : {point.x_m, point.y_m})
        if (std::isfinite(place_m) && std::abs(place_m) > sea::position_max_m)
            return failed(Failure::bad_argument,
                          fmt::format("a coordinate is {} m: it must be {:g} to {:g}", place_m,
                                      -sea::position_max_m, sea::position_max_m));
    return check_time(point.time_us);
}

Result<HeldPairs> held_pairs(const SeaState& state, const KeyframeRing& ring, sea::TimeUs time_us,
                             sea::FieldSet fields, std::uint32_t cascades) {
    HeldPairs held{.pairs = {}, .covers = true};
    for (std::size_t c = 0; c < state.cascades.size(); ++c) {
        if (!(cascades >> c & 1u))
            continue;
        std::optional<KeyframePair> pair = ring.around(static_cast<int>(c), state.epoch, time_us,
                                                       state.cascades[c].interval_us, fields);
        if (!pair || !pair->before->can_be_sampled() || !pair->after->can_be_sampled())
            return failed(Failure::not_held,
                          fmt::format("no keyframe of cascade {} is held that heights can be "
                                      "sampled from: subscribe, or fetch around the time",
                                      c));
        pair->before->spline();
        pair->after->spline();
        held.covers = held.covers && pair->covers;
        held.pairs.push_back(std::move(*pair));
    }
    return held;
}

sea::Surface surface_of(const SeaState& state, sea::TimeUs time_us, const HeldPairs& held) {
    ShortList<sea::SplinePair, sea::surface_pairs_max> splines;
    for (const KeyframePair& pair : held.pairs)
        splines.push_back({pair.before->spline(), pair.after->spline()});
    return {{splines.data(), splines.size()},
            {state.choppiness_x_at(time_us), state.choppiness_y_at(time_us)},
            folds_of(state),
            local_map_error(state, {held.pairs.data(), held.pairs.size()}),
            sea::inverse_tolerance_m(state.height_error_m)};
}

Result<LocalSurface> local_surface(const SeaState& state, const KeyframeRing& ring,
                                   sea::TimeUs time_us, sea::FieldSet fields,
                                   std::uint32_t cascades) {
    SEAWAY_TRY_LET(const HeldPairs held, held_pairs(state, ring, time_us, fields, cascades));
    return LocalSurface{surface_of(state, time_us, held), held.covers};
}

bool covers(const SeaState& state, const KeyframeRing& ring, sea::TimeUs time_us,
            sea::FieldSet fields) {
    for (std::size_t c = 0; c < state.cascades.size(); ++c) {
        const std::optional<KeyframePair> pair = ring.around(
            static_cast<int>(c), state.epoch, time_us, state.cascades[c].interval_us, fields);
        if (!pair || !pair->covers || pair->before == pair->after)
            return false;
    }
    return true;
}

bool glides_choppiness(const SeaState& state) {
    return state.glide && (state.glide->choppiness_x != state.choppiness_x ||
                           state.glide->choppiness_y != state.choppiness_y);
}

TimeCell time_cell(const SeaState& state, sea::TimeUs time_us) {
    TimeCell cell;
    for (const protocol::CascadeInfo& cascade : state.cascades) {
        const sea::TimeUs rest = time_us % cascade.interval_us;
        cell.push_back((time_us - rest) / cascade.interval_us - (rest < 0 ? 1 : 0));
    }
    return cell;
}

} // namespace seaway::client
