// SPDX-License-Identifier: Apache-2.0
#include "client/sea_motion.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "client/local_surface.h"
#include "sea/basics/constants.h"
#include "sea/basics/deviations.h"

namespace seaway::client {

namespace {

/// Of what carries waves along, and of what squeezes them. Of long-crested gales and wind seas, ten minutes each, what was found between
/// moments came to half of what is stated at most; with 1.5 deviations to 1.7 times as much.
constexpr double sigmas_carried = 2.5;
/// Water that is squeezed more is about to fold.
constexpr double squeezed_most = 4.0;
/// What is not known may be so much of what the water moves typically.
constexpr double unknown_share = 0.25;

/// How far the parabola through three heights goes beyond the middle one and its neighbours; seen from `from_m`.
double bulge_m(double before_m, double height_m, double after_m, double from_m) {
    const double half_slope = 0.25 * (after_m - before_m);
    const double bend = 0.5 * (after_m + before_m) - height_m;
    if (std::abs(half_slope) >= std::abs(bend)) // it has no crest between them
        return 0;
    return std::abs(height_m - half_slope * half_slope / bend - from_m);
}

} // namespace

double SeaMotion::between_m(double apart_s) const {
    return third_rate_mps3 * apart_s * apart_s * apart_s / (9 * std::numbers::sqrt3);
}

SeaMotion SeaMotion::with(const SeaMotion& other) const {
    return {std::max(rate_mps, other.rate_mps), std::max(third_rate_mps3, other.third_rate_mps3),
            std::max(highest_m, other.highest_m)};
}

sea::WaveLaw fastest_law(std::span<const SeaStatePtr> states) {
    const SeaState* fastest = nullptr;
    for (const SeaStatePtr& state : states)
        if (state->wave_law &&
            (fastest == nullptr ||
             state->wave_law->dispersion.gravity_mps2 > fastest->wave_law->dispersion.gravity_mps2))
            fastest = state.get();
    return fastest != nullptr ? *fastest->wave_law : sea::WaveLaw{};
}

SeaMotion motion_of(const SeaState& state, sea::TimeUs time_us, const sea::WaveLaw& otherwise) {
    const double shortest_radpm = shortest_wave_radpm(state);
    const sea::WaveLaw law = state.wave_law.value_or(otherwise);
    const double gravity_mps2 = law.dispersion.gravity_mps2 + law.dispersion.surface_tension_m3ps2 *
                                                                  shortest_radpm * shortest_radpm;
    const double loops_radps =
        law.loop_period_us > 0 ? sea::two_pi / sea::seconds_from_us(law.loop_period_us) : 0;
    const double rms_m = state.highest_hs_m(time_us) / 4;
    const double rms_bend_per_m = told_curvature_per_m(state) / sea::bound_sigmas;
    const double sideways = largest_choppiness(state).largest();

    // Powers 1/6 of mean sixth powers: of frequencies, and of wavenumbers, which are at most the shortest wave's.
    const double turning =
        std::sqrt(gravity_mps2) * std::pow(state.rms_slope * rms_bend_per_m, 1.0 / 6) +
        loops_radps * std::cbrt(rms_m);
    const double packed = std::cbrt(shortest_radpm * rms_bend_per_m);
    // Of a server that tells none it is that of deep water.
    const double rms_strain = std::max(state.rms_strain, state.rms_slope);
    // What moves water sideways is g k / w times the height, so its rate has at most these, in any depth.
    const double carried_mps =
        sigmas_carried * sideways * std::sqrt(gravity_mps2 * rms_m * rms_strain);
    const double squeezed =
        1 / std::max(1 - sigmas_carried * sideways * rms_strain, 1 / squeezed_most);
    const double passing = turning + squeezed * carried_mps * packed;
    return {.rate_mps = std::sqrt(gravity_mps2 * rms_m * state.rms_slope),
            .third_rate_mps3 = sea::bound_sigmas * passing * passing * passing,
            .highest_m = sea::bound_sigmas * rms_m * (1 + sideways * state.rms_slope)};
}

int looks_each_way(const SeaMotion& motion, double off_s) {
    int looks = 1;
    while (looks < looks_each_way_max &&
           motion.between_m(off_s / looks) > unknown_share * motion.rate_mps * off_s)
        looks *= 2;
    return looks;
}

double furthest_m(std::span<const double> heights_m, double apart_s, const SeaMotion& motion,
                  bool folded) {
    const double from_m = heights_m[heights_m.size() / 2];
    const double ever_m = std::abs(from_m) + motion.highest_m;
    if (folded && heights_m.size() > 3)
        return ever_m;
    double furthest = 0;
    for (const double height_m : heights_m)
        furthest = std::max(furthest, std::abs(height_m - from_m));
    for (std::size_t i = 1; i + 1 < heights_m.size(); ++i)
        furthest =
            std::max(furthest, bulge_m(heights_m[i - 1], heights_m[i], heights_m[i + 1], from_m));
    return std::max(furthest, std::min(furthest + motion.between_m(apart_s), ever_m));
}

} // namespace seaway::client
