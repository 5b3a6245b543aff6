// SPDX-License-Identifier: Apache-2.0
#include "sea/foam/foam.h"

#include <algorithm>
#include <cmath>

#include "base/check.h"
#include "sea/foam/foam_kernel.h"

namespace seaway::sea {

namespace {

/// Mean coverage below this on a calm sea is gone.
constexpr double calm_mean_min = 1e-4;

FoamTick make_tick(const FoamLaw& law, const FoamLaw::Cascade& cascade, double remains) {
    const OthersShape& o = cascade.others;
    const auto f = [](double x) { return static_cast<float>(x); };
    // Without others J has no width; a thousandth of a percent stands in for none.
    constexpr double width_min = 1e-5;
    return {f(law.model.threshold),
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
            f((1 - remains) / cascade.mean_shortfall)};
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

double relax_foam_mean(double mean, const FoamLaw& law, double dt_s) {
    const double remains = foam_remains(dt_s, law.model.decay_s);
    const double next = mean * remains + law.mean_coverage * (1.0 - remains);
    return law.calm() && next < calm_mean_min ? 0.0 : next;
}

double foam_coverage(double mean, std::span<const float> ratios) {
    double together = 2.0;
    for (const float ratio : ratios)
        together *= 0.5 * (1.0 + static_cast<double>(ratio));
    return std::clamp(mean * (together - 1.0), 0.0, 1.0);
}

FoamHistory::FoamHistory(FoamLawPtr law, int cascade, int size, Instructions instructions)
    : cascade_(cascade), kernel_(&foam_kernel(instructions)),
      ratios_(static_cast<std::size_t>(size) * static_cast<std::size_t>(size), 1.0f) {
    change_law(std::move(law));
}

void FoamHistory::change_law(FoamLawPtr law) {
    law_ = std::move(law);
    SEAWAY_CHECK(law_ && cascade_ >= 0 &&
                     static_cast<std::size_t>(cascade_) < law_->cascades.size(),
                 "a foam history belongs to a cascade of its law");
}

void FoamHistory::restart() {
    std::fill(ratios_.begin(), ratios_.end(), 1.0f);
    started_ = false;
}

void FoamHistory::advance(const Keyframe& strains, double dt_s) {
    SEAWAY_CHECK(dt_s >= 0, "foam does not run backwards");
    time_us_ = strains.time_us;
    started_ = true;
    if (law_->calm())
        return;
    SEAWAY_CHECK(strains.fields.contains(foam_inputs) && strains.plane_size() == ratios_.size() &&
                     strains.cascade == cascade_,
                 "foam needs the strains of its cascade");
    kernel_->advance(make_tick(*law_, law_->cascades[static_cast<std::size_t>(cascade_)],
                               foam_remains(dt_s, law_->model.decay_s)),
                     strains.plane(Field::strain_xx).data(), strains.plane(Field::strain_yy).data(),
                     strains.plane(Field::strain_xy).data(), ratios_.data(), ratios_.size());
}

Result<void> FoamHistory::advance_to(TimeUs time_us, TimeUs interval_us,
                                     const StrainsAt& strains_at) {
    SEAWAY_CHECK(interval_us > 0, "keyframes have an interval");
    if (law_->calm() || (started_ && time_us == time_us_))
        return {};
    // No memory: one tick with the strains of this moment is all there is.
    const TimeUs memory_us = std::max(
        interval_us, us_from_seconds(std::min(foam_memory_decays * law_->model.decay_s, 1e7)));
    if (!started_ || time_us < time_us_ || time_us - time_us_ > memory_us) {
        restart();
        time_us_ = time_us - memory_us;
    }
    const TimeUs intervals = std::max<TimeUs>((time_us - time_us_) / interval_us, 1);
    const TimeUs stride = (intervals + foam_warm_up_ticks_max - 1) / foam_warm_up_ticks_max;
    const TimeUs ticks = std::max<TimeUs>(intervals / stride, 1);
    TimeUs from_us = time_us_;
    for (TimeUs left = ticks; left-- > 0;) {
        const TimeUs tick_us = time_us - left * stride * interval_us;
        Result<KeyframePtr> strains = strains_at(tick_us);
        if (!strains) {
            started_ = false; // what is half-way is no history: the next call starts anew
            return strains.error();
        }
        advance(**strains, seconds_from_us(tick_us - from_us));
        from_us = tick_us;
    }
    return {};
}

void FoamHistory::fill(std::span<float> plane) const {
    SEAWAY_CHECK(plane.size() == ratios_.size(), "a foam map has the size of its cascade");
    std::copy(ratios_.begin(), ratios_.end(), plane.begin());
}

} // namespace seaway::sea
