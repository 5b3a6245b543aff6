// SPDX-License-Identifier: Apache-2.0
// Keyframes of free waves, for whoever predicts one from another.
#pragma once

#include <cmath>

#include "sea/basics/constants.h"
#include "sea/basics/dispersion.h"
#include "sea/surface/maps/keyframe.h"

namespace seaway::server {

inline constexpr double predicted_length_m = 100;
inline constexpr sea::TimeUs predicted_interval_us = 250'000;
inline constexpr sea::WaveLaw predicted_law{};

/// Three waves of metres, two of them against each other, which a grid of 20 holds: keyframe `n` of a cascade.
inline sea::Keyframe running_keyframe(int n, int size = 20, int cascade = 0,
                                      sea::FieldSet fields = {sea::Field::height,
                                                              sea::Field::height_rate}) {
    struct Wave {
        int nx, ny;
        double amplitude_m;
    };
    sea::Keyframe made;
    made.epoch = 1;
    made.cascade = cascade;
    made.time_us = n * predicted_interval_us;
    made.size = size;
    made.length_m = predicted_length_m;
    made.fields = fields;
    made.values.resize(made.plane_size() * static_cast<std::size_t>(fields.size()));
    const double t_s = sea::seconds_from_us(made.time_us);
    for (const Wave& wave : {Wave{3, -2, 2.0}, {-3, 2, 1.0}, {5, 4, 0.5}}) {
        const double w = predicted_law.dispersion.omega(sea::two_pi * std::hypot(wave.nx, wave.ny) /
                                                        predicted_length_m);
        for (std::size_t i = 0; i < made.plane_size(); ++i) {
            const auto x = static_cast<int>(i) % size, y = static_cast<int>(i) / size;
            const double angle =
                sea::two_pi * (wave.nx * x + wave.ny * y) / size - w * t_s + cascade;
            for (const sea::Field field : fields)
                made.plane(field)[i] += static_cast<float>(
                    wave.amplitude_m *
                    (field == sea::Field::height_rate ? w * std::sin(angle) : std::cos(angle)));
        }
    }
    return made;
}

} // namespace seaway::server
