// SPDX-License-Identifier: Apache-2.0
#include "sea/foam/foam_walk.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/check.h"

namespace seaway::sea {

namespace {

/// A cascade whose own waves hardly make anything break more often than this says nothing about where;
/// single precision ends at 1e-38.
constexpr double mean_breaking_min = 1e-30;

} // namespace

double foam_remains(double dt_s, double decay_s) {
    if (decay_s <= 0)
        return 0.0;
    return dt_s > 0 ? std::exp(-dt_s / decay_s) : 1.0;
}

FoamTick foam_tick(const FoamLaw& law, int cascade, double remains, double weight) {
    const FoamLaw::Cascade& own = law.cascades[static_cast<std::size_t>(cascade)];
    const OthersShape& o = own.others;
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
            f(weight * (1 - remains) / own.mean_breaking),
            0.0f};
}

bool foam_idle(const FoamLaw& law, int cascade) {
    return law.calm() ||
           !(law.cascades[static_cast<std::size_t>(cascade)].mean_breaking > mean_breaking_min);
}

FoamWalk::FoamWalk(FoamLawPtr law, int cascade, TimeUs interval_us)
    : law_(std::move(law)), cascade_(cascade) {
    SEAWAY_CHECK(law_ && cascade_ >= 0 &&
                     static_cast<std::size_t>(cascade_) < law_->cascades.size(),
                 "a foam history belongs to a cascade of its law");
    ticks_ = foam_ticks(law_->model.decay_s, interval_us, law_->loop_period_us);
}

bool FoamWalk::has_no_history() const {
    // Without memory there is nothing to walk through.
    return ticks_.decay_s == 0 || (!follows() && foam_idle(*law_, cascade_));
}

bool FoamWalk::goes_on_to(TimeUs tick_us) const {
    const TimeUs held_us = std::max(tick_us_, start_end_us_);
    return started_ && held_us <= tick_us && tick_us - held_us <= ticks_.memory_us;
}

void FoamWalk::start_for(TimeUs tick_us) {
    // The periodic solution is what one loop leaves behind on clean water, and that of the loops
    // before it: a geometric series.
    start_weight_ = ticks_.periodic
                        ? 1.0 / -std::expm1(-seconds_from_us(ticks_.loop_us) / ticks_.decay_s)
                        : 1.0;
    tick_us_ = ticks_.start_for(tick_us);
    start_end_us_ = tick_us;
    started_ = true;
    fresh_ = true;
}

int FoamWalk::pass_calm(TimeUs time_us, int most) {
    if (has_no_history())
        return 0;
    const TimeUs end_us = ticks_.at_or_before(time_us);
    if (!goes_on_to(end_us))
        start_for(end_us);
    if (!fresh_ || ticks_.periodic) // a loop begins with clean water
        return 0;
    int passed = 0;
    for (; passed < most && tick_us_ < end_us; ++passed) {
        const TimeUs next_us = ticks_.after(tick_us_);
        if (!foam_idle(*law_at(next_us), cascade_))
            break;
        tick_us_ = next_us;
    }
    return passed;
}

int FoamWalk::ticks_to(TimeUs time_us) const {
    if (has_no_history())
        return 0;
    const TimeUs end_us = ticks_.at_or_before(time_us);
    int ticks = 0;
    for (TimeUs at_us = goes_on_to(end_us) ? tick_us_ : ticks_.start_for(end_us); at_us < end_us;
         at_us = ticks_.after(at_us))
        ++ticks;
    return ticks;
}

std::optional<TimeUs> FoamWalk::next_us(TimeUs time_us) const {
    if (has_no_history())
        return std::nullopt;
    const TimeUs end_us = ticks_.at_or_before(time_us);
    const TimeUs at_us = goes_on_to(end_us) ? tick_us_ : ticks_.start_for(end_us);
    return at_us < end_us ? std::optional(ticks_.after(at_us)) : std::nullopt;
}

std::optional<FoamStep> FoamWalk::next(TimeUs time_us) {
    if (has_no_history())
        return std::nullopt;
    const TimeUs end_us = ticks_.at_or_before(time_us);
    if (!goes_on_to(end_us))
        start_for(end_us);
    if (tick_us_ >= end_us)
        return std::nullopt;
    const TimeUs next_us = ticks_.after(tick_us_);
    const double remains = foam_remains(seconds_from_us(next_us - tick_us_), ticks_.decay_s);
    const double weight = tick_us_ < start_end_us_ ? start_weight_ : 1.0;
    const FoamLawPtr law = law_at(next_us);
    FoamTick tick = foam_idle(*law, cascade_)
                        ? FoamTick::without_strains(static_cast<float>(remains),
                                                    static_cast<float>(weight * (1.0 - remains)))
                        : foam_tick(*law, cascade_, remains, weight);
    if (std::exchange(fresh_, false))
        forget_before(tick);
    tick_us_ = next_us;
    return FoamStep{next_us, tick};
}

/// Whatever the map was, it starts from the average, a loop from clean water.
void FoamWalk::forget_before(FoamTick& tick) const {
    tick.added += ticks_.periodic ? 0.0f : tick.remains;
    tick.remains = 0.0f;
}

FoamView FoamWalk::at(TimeUs time_us) const {
    FoamView view{FoamTick::without_strains(1.0f, 0.0f)};
    const FoamLawPtr law = law_at(time_us);
    if (!follows() && foam_idle(*law, cascade_))
        return view;
    const TimeUs tick_us = ticks_.at_or_before(time_us);
    if (!foam_idle(*law, cascade_) && (ticks_.decay_s == 0 || time_us > tick_us))
        view.tick = foam_tick(*law, cascade_,
                              foam_remains(seconds_from_us(time_us - tick_us), ticks_.decay_s));
    if (started_ && fresh_) // there was no step
        forget_before(view.tick);
    view.departure = static_cast<float>(ticks_.departure);
    return view;
}

} // namespace seaway::sea
