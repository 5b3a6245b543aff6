// SPDX-License-Identifier: Apache-2.0
#include "sea/foam/foam.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/check.h"
#include "sea/foam/foam_kernel.h"

namespace seaway::sea {

namespace {

/// A cascade whose own waves hardly make anything break more often than this says nothing about where;
/// single precision ends at 1e-38.
constexpr double mean_breaking_min = 1e-30;

FoamTick make_tick(const FoamLaw& law, const FoamLaw::Cascade& cascade, double remains,
                   double weight) {
    const OthersShape& o = cascade.others;
    const auto f = [](double x) { return static_cast<float>(x); };
    // Without others J has no width; a thousandth of a percent stands in for none.
    constexpr double width_min = 1e-5;
    return {f(law.threshold),
            f(law.model.bias),
            f(law.choppiness.x),
            f(law.choppiness.y),
            f(std::sqrt(law.choppiness.x * law.choppiness.y)),
            f(o.variance),
            f(o.difference),
            f(4 * o.shear),
            f(0.25 * (1 - o.difference * o.difference - 4 * o.shear * o.shear) * o.variance),
            f(0.25 * o.difference_rest),
            f(4 * o.shear_rest),
            f(2 * o.cross_rest),
            f(0.125 * o.difference_rest * o.difference_rest + 2 * o.shear_rest * o.shear_rest +
              o.cross_rest * o.cross_rest + width_min * width_min),
            f(remains),
            f(weight * (1 - remains) / cascade.mean_breaking)};
}

} // namespace

const FoamKernel& foam_kernel(Instructions instructions) {
#if defined(SEAWAY_X86)
    if (instructions != Instructions::portable)
        return foam_kernel_avx2();
#else
    SEAWAY_CHECK(instructions == Instructions::portable, "no other kernel is built");
#endif
    return foam_kernel_portable();
}

double foam_remains(double dt_s, double decay_s) {
    if (decay_s <= 0)
        return 0.0;
    return dt_s > 0 ? std::exp(-dt_s / decay_s) : 1.0;
}

double foam_coverage(double mean, std::span<const float> ratios) {
    double together = 2.0;
    for (const float ratio : ratios)
        together *= 0.5 * (1.0 + static_cast<double>(ratio));
    return std::clamp(mean * (together - 1.0), 0.0, 1.0);
}

FoamHistory::FoamHistory(FoamLawPtr law, int cascade, int size, TimeUs interval_us,
                         Instructions instructions)
    : cascade_(cascade), interval_us_(interval_us), kernel_(&foam_kernel(instructions)),
      state_(static_cast<std::size_t>(size) * static_cast<std::size_t>(size), 1.0f) {
    law_ = std::move(law);
    SEAWAY_CHECK(law_ && cascade_ >= 0 &&
                     static_cast<std::size_t>(cascade_) < law_->cascades.size(),
                 "a foam history belongs to a cascade of its law");
    ticks_ = foam_ticks(law_->model.decay_s, interval_us_, law_->loop_period_us);
}

bool FoamHistory::idle(const FoamLaw& law) const {
    return law.calm() ||
           !(law.cascades[static_cast<std::size_t>(cascade_)].mean_breaking > mean_breaking_min);
}

void FoamHistory::step(const FoamLaw& law, std::vector<float>& state, const Keyframe& strains,
                       double dt_s, double decay_s, double weight) const {
    SEAWAY_CHECK(dt_s >= 0, "foam does not run backwards");
    SEAWAY_CHECK(strains.fields.contains(foam_inputs) && strains.plane_size() == state.size() &&
                     strains.cascade == cascade_,
                 "foam needs the strains of its cascade");
    kernel_->advance(make_tick(law, law.cascades[static_cast<std::size_t>(cascade_)],
                               foam_remains(dt_s, decay_s), weight),
                     strains.plane(Field::strain_xx).data(), strains.plane(Field::strain_yy).data(),
                     strains.plane(Field::strain_xy).data(), state.data(), state.size());
}

void FoamHistory::forget(double dt_s, double weight) {
    const double remains = foam_remains(dt_s, ticks_.decay_s);
    const auto kept = static_cast<float>(remains);
    const auto average = static_cast<float>(weight * (1.0 - remains));
    for (float& ratio : state_)
        ratio = ratio * kept + average;
}

void FoamHistory::advance(const Keyframe& strains, double dt_s) {
    started_ = false; // on no tick: the next advance_to() starts anew
    shown_.clear();
    if (!idle(*law_))
        step(*law_, state_, strains, dt_s, law_->model.decay_s);
}

bool FoamHistory::has_no_history() const {
    // Without memory there is nothing to walk through.
    return ticks_.decay_s == 0 || (!law_at_ && idle(*law_));
}

bool FoamHistory::goes_on_to(TimeUs tick_us) const {
    const TimeUs held_us = std::max(tick_us_, start_end_us_);
    return started_ && held_us <= tick_us && tick_us - held_us <= ticks_.memory_us;
}

void FoamHistory::start_for(TimeUs tick_us) {
    // The periodic solution is what one loop leaves behind on clean water, and that of the loops
    // before it: a geometric series.
    start_weight_ = ticks_.periodic
                        ? 1.0 / -std::expm1(-seconds_from_us(ticks_.loop_us) / ticks_.decay_s)
                        : 1.0;
    std::fill(state_.begin(), state_.end(), ticks_.periodic ? 0.0f : 1.0f);
    tick_us_ = ticks_.start_for(tick_us);
    start_end_us_ = tick_us;
    started_ = true;
}

int FoamHistory::ticks_to(TimeUs time_us) const {
    if (has_no_history())
        return 0;
    const TimeUs end_us = ticks_.at_or_before(time_us);
    int ticks = 0;
    for (TimeUs at_us = goes_on_to(end_us) ? tick_us_ : ticks_.start_for(end_us); at_us < end_us;
         at_us = ticks_.after(at_us))
        ++ticks;
    return ticks;
}

Result<bool> FoamHistory::walk_towards(TimeUs time_us, int ticks_max, const StrainsAt& strains_at) {
    SEAWAY_CHECK(ticks_max >= 1, "every slice goes some way");
    if (has_no_history())
        return true;
    const TimeUs end_us = ticks_.at_or_before(time_us);
    if (!goes_on_to(end_us))
        start_for(end_us);
    for (int walked = 0; tick_us_ < end_us; ++walked) {
        if (walked == ticks_max)
            return false;
        const TimeUs next_us = ticks_.after(tick_us_);
        const double dt_s = seconds_from_us(next_us - tick_us_);
        const double weight = tick_us_ < start_end_us_ ? start_weight_ : 1.0;
        if (const FoamLawPtr law = law_at(next_us); idle(*law)) {
            forget(dt_s, weight);
        } else {
            Result<KeyframePtr> strains = strains_at(next_us);
            if (!strains) {
                started_ = false; // the next call starts anew
                return strains.error();
            }
            step(*law, state_, **strains, dt_s, ticks_.decay_s, weight);
        }
        tick_us_ = next_us;
    }
    return true;
}

Result<void> FoamHistory::advance_to(TimeUs time_us, const StrainsAt& strains_at) {
    const FoamLawPtr law = law_at(time_us);
    if (!law_at_ && idle(*law))
        return {};
    SEAWAY_TRY(walk_towards(time_us, std::numeric_limits<int>::max(), strains_at));
    const TimeUs tick_us = ticks_.at_or_before(time_us);
    shown_.clear();
    const bool between = !idle(*law) && (ticks_.decay_s == 0 || time_us > tick_us);
    if (!between && ticks_.departure == 1.0)
        return {};
    std::vector<float> shown = state_;
    if (between) {
        Result<KeyframePtr> strains = strains_at(time_us);
        if (!strains)
            return strains.error();
        step(*law, shown, **strains, seconds_from_us(time_us - tick_us), ticks_.decay_s);
    }
    const auto departure = static_cast<float>(ticks_.departure);
    if (departure != 1.0f)
        for (float& ratio : shown)
            ratio = 1.0f + departure * (ratio - 1.0f);
    shown_ = std::move(shown);
    return {};
}

void FoamHistory::fill(std::span<float> plane) const {
    SEAWAY_CHECK(plane.size() == state_.size(), "a foam map has the size of its cascade");
    const std::span<const float> shown = ratios();
    std::copy(shown.begin(), shown.end(), plane.begin());
}

} // namespace seaway::sea
