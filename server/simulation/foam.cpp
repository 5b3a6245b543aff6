// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/foam.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "base/check.h"

namespace seaway::server {

using sea::Field;
using sea::TimeUs;

namespace {

/// Ratios below this are nothing; keeps denormal numbers out (hard case E4).
constexpr float ratio_min = 1e-6f;
/// Mean coverage below this on a calm sea is gone.
constexpr double calm_mean_min = 1e-4;

/// Beyond this many deviations phi is below 1e-34.
constexpr float deviations_max = 12.5f;

/// phi(t), 0 <= t <= deviations_max; relative error 4e-6. 2^n by exponent bits, 2^f by a
/// polynomial.
inline float normal_density(float t) {
    constexpr float log2_e = 1.44269504f;
    constexpr float round = 12582912.0f; // 1.5 * 2^23: adding it rounds to a whole number
    const float power = t * t * (-0.5f * log2_e);
    const float shifted = power + round;
    const float f = power - (shifted - round);
    const float mantissa =
        1.0f + f * (0.69314718f +
                    f * (0.24022651f + f * (0.05550411f + f * (0.00961813f + f * 0.00133336f))));
    const auto exponent = std::bit_cast<std::int32_t>(shifted) - std::bit_cast<std::int32_t>(round);
    return 0.39894228f * std::bit_cast<float>((exponent + 127) << 23) * mantissa;
}

/// 1 - t M(t) and its companion t (1 - t M) + M, M being Mills' ratio Phi(-t)/phi(t), 0 <= t <=
/// deviations_max; polynomials in 1/(1 + 0.3 t) fitted for relative error: 1e-6 and 6e-6.
struct MillsTerms {
    float linear;
    float square;
};

inline MillsTerms mills_terms(float t) {
    const float k = 1.0f / (1.0f + 0.3f * t);
    const float linear =
        0.089911076f +
        k * (0.18241227f +
             k * (0.22002899f +
                  k * (0.40581092f +
                       k * (-0.24083353f +
                            k * (0.97683328f + k * (-0.85622522f + k * 0.22206299f))))));
    const float square =
        0.60501906f +
        k * (0.51664481f +
             k * (1.05656121f +
                  k * (-1.7316443f + k * (3.97410573f + k * (-4.41947001f + k * 1.25209079f)))));
    return {linear * k * k, square * k};
}

/// What one tick needs, in single precision; the terms are those of conditional_shortfall().
struct Tick {
    float threshold, choppiness_x, choppiness_y, choppiness_xy;
    float variance, difference, shear, curvature;
    float difference_rest, shear_rest, cross_rest, constant_rest;
    float remains, source; ///< ratio = ratio * remains + shortfall * source
};

Tick make_tick(const FoamLaw& law, const FoamLaw::Cascade& cascade, double remains) {
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

inline float shortfall(const Tick& tick, float strain_xx, float strain_yy, float strain_xy) {
    const float a = tick.choppiness_x * strain_xx;
    const float b = tick.choppiness_y * strain_yy;
    const float c = tick.choppiness_xy * strain_xy;
    const float difference = a - b;
    const float mean = tick.threshold - (1.0f + a) * (1.0f + b) + c * c;
    const float slope = 0.5f * (2.0f + a + b - tick.difference * difference - tick.shear * c);
    const float rest = difference * difference * tick.difference_rest + c * c * tick.shear_rest +
                       difference * c * tick.cross_rest + tick.constant_rest;
    const float width = std::sqrt(std::max(slope * slope * tick.variance + rest, 0.0f));
    const float top = mean + tick.curvature;
    const float discriminant = width * width + 4.0f * tick.curvature * top;
    const float root = 2.0f * top / (width + std::sqrt(std::max(discriminant, 0.0f)));
    const float t = std::min(std::abs(root), deviations_max);
    const MillsTerms mills = mills_terms(t);
    const float side = root > 0.0f ? 1.0f : -1.0f;
    const float tail =
        normal_density(t) * (width * mills.linear + side * tick.curvature * mills.square);
    const float excess = tail + (root > 0.0f ? mean : 0.0f);
    return discriminant > 0.0f ? std::max(excess, 0.0f) : 0.0f;
}

} // namespace

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

FoamHistory::FoamHistory(FoamLawPtr law, int cascade, int size)
    : cascade_(cascade),
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

void FoamHistory::advance(const sea::Keyframe& strains, double dt_s) {
    SEAWAY_CHECK(dt_s >= 0, "foam does not run backwards");
    time_us_ = strains.time_us;
    started_ = true;
    if (law_->calm())
        return;
    SEAWAY_CHECK(strains.fields.contains(foam_inputs) && strains.plane_size() == ratios_.size() &&
                     strains.cascade == cascade_,
                 "foam needs the strains of its cascade");
    const Tick tick = make_tick(*law_, law_->cascades[static_cast<std::size_t>(cascade_)],
                                foam_remains(dt_s, law_->model.decay_s));
    const float* xx = strains.plane(Field::strain_xx).data();
    const float* yy = strains.plane(Field::strain_yy).data();
    const float* xy = strains.plane(Field::strain_xy).data();
    float* ratio = ratios_.data();
    const std::size_t count = ratios_.size();
    for (std::size_t i = 0; i < count; ++i) {
        const float next =
            ratio[i] * tick.remains + shortfall(tick, xx[i], yy[i], xy[i]) * tick.source;
        ratio[i] = next >= ratio_min ? next : 0.0f;
    }
}

Result<void> FoamHistory::advance_to(TimeUs time_us, TimeUs interval_us,
                                     const StrainsAt& strains_at) {
    SEAWAY_CHECK(interval_us > 0, "keyframes have an interval");
    if (law_->calm() || (started_ && time_us == time_us_))
        return {};
    // No memory: one tick with the strains of this moment is all there is.
    const TimeUs memory_us = std::max(
        interval_us, sea::us_from_seconds(std::min(foam_memory_decays * law_->model.decay_s, 1e7)));
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
        Result<sea::KeyframePtr> strains = strains_at(tick_us);
        if (!strains) {
            started_ = false; // what is half-way is no history: the next call starts anew
            return strains.error();
        }
        advance(**strains, sea::seconds_from_us(tick_us - from_us));
        from_us = tick_us;
    }
    return {};
}

void FoamHistory::fill(std::span<float> plane) const {
    SEAWAY_CHECK(plane.size() == ratios_.size(), "a foam map has the size of its cascade");
    std::copy(ratios_.begin(), ratios_.end(), plane.begin());
}

} // namespace seaway::server
