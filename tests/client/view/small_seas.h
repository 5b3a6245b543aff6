// SPDX-License-Identifier: Apache-2.0
// Seas of few waves whose truth is plain.
#pragma once

#include <cmath>
#include <complex>

#include "client/view/sea/sea_frame.h"
#include "sea/waves/realize.h"

namespace seaway::client {

/// amplitude cos(k.x - w t) in a tile of `length_m`, `steps` waves on it along east and `north_steps`
/// along north.
inline sea::Realization one_wave(double amplitude_m, double length_m, int steps,
                                 int north_steps = 0, int size = 64) {
    sea::CascadeModes modes;
    modes.spec = {length_m, size};
    modes.band = {0, modes.spec.nyquist_radpm()};
    modes.h0.resize(static_cast<std::size_t>(size * size));
    modes.rate.resize(modes.h0.size());
    const double k_radpm = std::hypot(steps, north_steps) * modes.spec.wavenumber_step_radpm();
    const auto at = [size](int nx, int ny) {
        return static_cast<std::size_t>((ny + size) % size * size + (nx + size) % size);
    };
    modes.h0[at(steps, north_steps)] = 0.5 * amplitude_m;
    const sea::Rate rate = sea::rate_from_omega(std::sqrt(9.81 * k_radpm));
    modes.rate[at(steps, north_steps)] = rate;
    modes.rate[at(-steps, -north_steps)] = rate;
    sea::Realization sea;
    sea.cascades.push_back(std::move(modes));
    return sea;
}

/// No waves at all.
inline SeaFrame flat_sea() {
    sea::Keyframe keyframe;
    keyframe.size = 64;
    keyframe.length_m = 100;
    keyframe.fields = sea::surface_fields;
    keyframe.values.assign(keyframe.plane_size() * 6, 0.0f);
    const auto map = std::make_shared<const sea::SplineMap>(keyframe);
    SeaFrame frame;
    frame.cascades.push_back({{100, 64}, {0, 1}, {map, map}});
    return frame;
}

} // namespace seaway::client
