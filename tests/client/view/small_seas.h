// SPDX-License-Identifier: Apache-2.0
// Seas of few waves whose truth is plain.
#pragma once

#include <cmath>
#include <complex>

#include "client/view/sea_frame.h"
#include "sea/waves/realize.h"

namespace seaway::client {

/// amplitude cos(k x - w t) along east in a tile of `length_m`, `steps` waves on it.
inline sea::Realization one_wave(double amplitude_m, double length_m, int steps) {
    constexpr int size = 64;
    sea::CascadeModes modes;
    modes.spec = {length_m, size};
    modes.band = {0, modes.spec.nyquist_radpm()};
    modes.h0.resize(size * size);
    modes.rate.resize(modes.h0.size());
    const double k_radpm = steps * modes.spec.wavenumber_step_radpm();
    modes.h0[static_cast<std::size_t>(steps)] = 0.5 * amplitude_m;
    const sea::Rate rate = sea::rate_from_omega(std::sqrt(9.81 * k_radpm));
    modes.rate[static_cast<std::size_t>(steps)] = rate;
    modes.rate[static_cast<std::size_t>(size - steps)] = rate;
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
