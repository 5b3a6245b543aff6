// SPDX-License-Identifier: Apache-2.0
// Small seas of known modes, and their keyframes by direct sum: the ground under tests.
#pragma once

#include <cmath>
#include <complex>
#include <memory>
#include <random>

#include "sea/basics/constants.h"
#include "sea/surface/maps/keyframe.h"
#include "sea/waves/realization.h"
#include "sea/waves/reference.h"

namespace seaway::tests {

/// A cascade without waves; deep-water frequencies for all of its lattice.
inline sea::CascadeModes calm_cascade(double length_m, int size) {
    const sea::CascadeSpec spec{length_m, size};
    sea::CascadeModes modes;
    modes.spec = spec;
    modes.band = {0.5 * spec.wavenumber_step_radpm(), 0.9 * spec.nyquist_radpm()};
    const auto count = static_cast<std::size_t>(size) * static_cast<std::size_t>(size);
    modes.h0.assign(count, {});
    modes.rate.assign(count, 0);
    for (int iy = 0; iy < size; ++iy)
        for (int ix = 0; ix < size; ++ix) {
            const double k = spec.wavenumber_step_radpm() *
                             std::hypot(sea::signed_index(ix, size), sea::signed_index(iy, size));
            modes.rate[static_cast<std::size_t>(iy * size + ix)] =
                sea::rate_from_omega(std::sqrt(sea::gravity_default_mps2 * k));
        }
    return modes;
}

/// Adds eta = amplitude cos(k.X - w t + phase), k = 2 pi (nx, ny) / length.
inline void add_wave(sea::CascadeModes& modes, int nx, int ny, double amplitude_m,
                     double phase_rad) {
    const int size = modes.spec.size;
    const auto index = static_cast<std::size_t>(((ny + size) % size) * size + (nx + size) % size);
    modes.h0[index] += std::polar(0.5 * amplitude_m, phase_rad);
}

/// `count` random waves with |n| up to n_max, steepness k a of each about `steepness`.
inline sea::CascadeModes random_cascade(double length_m, int size, int n_max, int count,
                                        double steepness, unsigned seed) {
    sea::CascadeModes modes = calm_cascade(length_m, size);
    std::mt19937 random(seed);
    std::uniform_int_distribution<int> index(-n_max, n_max);
    std::uniform_real_distribution<double> phase(0.0, sea::two_pi);
    for (int i = 0; i < count;) {
        const int nx = index(random);
        const int ny = index(random);
        const double n = std::hypot(nx, ny);
        if (n == 0 || n > n_max)
            continue;
        add_wave(modes, nx, ny, steepness / (n * modes.spec.wavenumber_step_radpm()),
                 phase(random));
        ++i;
    }
    return modes;
}

inline sea::RealizationPtr make_sea(std::vector<sea::CascadeModes> cascades,
                                    sea::Choppiness choppiness = {}) {
    return std::make_shared<const sea::Realization>(
        sea::Realization{std::move(cascades), choppiness, 0});
}

/// Random waves in a tile of 300 m and in one of 41 m.
inline sea::RealizationPtr two_cascades() {
    return make_sea({random_cascade(300.0, 64, 12, 300, 0.004, 11),
                     random_cascade(41.0, 64, 15, 300, 0.004, 12)});
}

/// The surface fields of one cascade at one time, by direct sum in double precision.
inline sea::KeyframePtr exact_keyframe(const sea::RealizationPtr& sea, int cascade,
                                       sea::TimeUs time_us) {
    const sea::CascadeModes& modes = sea->cascades[static_cast<std::size_t>(cascade)];
    const sea::DirectSum sum(make_sea({modes}, sea->choppiness));
    const sea::DirectSum::Moment moment = sum.at_time(time_us);
    auto keyframe = std::make_shared<sea::Keyframe>();
    keyframe->cascade = cascade;
    keyframe->time_us = time_us;
    keyframe->size = modes.spec.size;
    keyframe->length_m = modes.spec.length_m;
    keyframe->fields = sea::surface_fields;
    keyframe->values.resize(keyframe->plane_size() * 6);
    std::size_t i = 0;
    for (int y = 0; y < keyframe->size; ++y)
        for (int x = 0; x < keyframe->size; ++x, ++i) {
            const sea::LagrangianPoint p =
                moment.at(x * modes.spec.spacing_m(), y * modes.spec.spacing_m());
            for (const sea::Field field : keyframe->fields)
                keyframe->plane(field)[i] = static_cast<float>(sea::value_of(p, field));
        }
    return keyframe;
}

} // namespace seaway::tests
