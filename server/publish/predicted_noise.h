// SPDX-License-Identifier: Apache-2.0
// What rounding leaves of heights that are predicted. It runs along with the waves, from keyframe to keyframe, so that no law says how
// large it is at a time between two of them: it is measured, and told to those who state bounds (protocol: Tile.noise).
//
// Pure; 0.2 ms for two maps of 81 x 81.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sea/surface/map_error.h"
#include "sea/surface/maps/keyframe.h"
#include "sea/surface/maps/regrid.h"

namespace seaway::server {

/// By how much a keyframe's heights and rates are off where they are received. [y][x]
struct PredictedNoise {
    std::vector<float> height_m;
    std::vector<float> rate_mps;
    /// Rms of what the device had rounded before, which is not in those.
    double rounded_m = 0;
    double rounded_mps = 0;
};

/// Of maps that come to these. `same`: of their grid to itself, where receivers bring them to another one, which leaves of it what
/// lies within the grid's disc; null: they do not.
PredictedNoise noise_of(const sea::Keyframe& sent, std::span<const float> height_decoded,
                        std::span<const float> rate_decoded, const sea::Regrid* same);

/// The keyframe that one follows.
struct NoiseBefore {
    const PredictedNoise* noise = nullptr; ///< null: it follows none
    std::uint64_t number = 0;
    sea::TimeUs time_us = 0;
};

/// What is told of it, of a keyframe at `time_us`.
sea::CodedNoise told_of(const PredictedNoise& noise, sea::TimeUs time_us,
                        const NoiseBefore& before);

} // namespace seaway::server
