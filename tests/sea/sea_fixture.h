// SPDX-License-Identifier: Apache-2.0
// Seas that tests of realisation and reference share.
#pragma once

#include <cmath>
#include <memory>
#include <vector>

#include "sea/waves/realize.h"
#include "sea/waves/reference.h"

namespace seaway::testing {

inline sea::SeaState windy_sea(std::uint64_t seed = 42) {
    sea::SeaState state;
    state.seed = seed;
    state.depth_m = 60.0;
    sea::WindSea wind;
    wind.wind_speed_10m_mps = 10.0;
    wind.fetch_m = 150e3;
    wind.towards_rad = 0.4;
    wind.spreading.kind = sea::SpreadingKind::hasselmann;
    state.systems.emplace_back(wind);
    return state;
}

inline sea::SeaState swell_sea(double height_m, double period_s, double towards_rad = 0.0,
                               double exponent = 10.0) {
    sea::SeaState state;
    state.seed = 1;
    sea::Swell swell;
    swell.significant_height_m = height_m;
    swell.peak_period_s = period_s;
    swell.towards_rad = towards_rad;
    swell.spreading.exponent = exponent;
    state.systems.emplace_back(swell);
    return state;
}

inline const std::vector<sea::CascadeSpec> three_cascades{{512.0, 64}, {97.0, 64}, {19.0, 64}};

inline sea::RealizationPtr realized(const sea::SeaState& state,
                                    const std::vector<sea::CascadeSpec>& cascades) {
    return std::make_shared<const sea::Realization>(*sea::realize(state, cascades));
}

/// A sea of one wave: h0 at (nx, ny) so that eta = amplitude cos(k.X - w t + phase).
inline sea::RealizationPtr one_wave(double length_m, int size, int nx, int ny, double amplitude_m,
                                    double phase_rad = 0.0, double depth_m = sea::deep_water_m) {
    auto realization = std::make_shared<sea::Realization>();
    sea::CascadeModes modes;
    modes.spec = {length_m, size};
    const auto points = static_cast<std::size_t>(size) * static_cast<std::size_t>(size);
    modes.h0.resize(points);
    modes.rate.resize(points);
    const double k = modes.spec.wavenumber_step_radpm() * std::hypot(nx, ny);
    const sea::Rate rate = sea::rate_from_omega(sea::Dispersion{9.81, 7.4e-5, depth_m}.omega(k));
    const auto index = [size](int x, int y) {
        return static_cast<std::size_t>((y + size) % size * size + (x + size) % size);
    };
    modes.h0[index(nx, ny)] = std::polar(0.5 * amplitude_m, phase_rad);
    modes.rate[index(nx, ny)] = rate;
    modes.rate[index(-nx, -ny)] = rate;
    modes.band = {0.5 * k, 2.0 * k};
    modes.depth_m = depth_m;
    realization->cascades.push_back(std::move(modes));
    return realization;
}

inline double energy_of(const sea::CascadeModes& modes) {
    double sum = 0.0;
    for (const auto& h0 : modes.h0)
        sum += 2.0 * std::norm(h0);
    return sum;
}

/// Significant height of the realised sea, 4 sqrt(m0).
inline double hs_of(const sea::RealizationPtr& sea) {
    double sum = 0.0;
    for (const sea::CascadeModes& modes : sea->cascades)
        sum += energy_of(modes);
    return 4.0 * std::sqrt(sum);
}

} // namespace seaway::testing
