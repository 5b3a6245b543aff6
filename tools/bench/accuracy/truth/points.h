// SPDX-License-Identifier: Apache-2.0
// Where and when errors are measured: half of the points anywhere, a quarter on crests (the highest
// percent of the surface), a quarter where it is squeezed most (the smallest percent of Jacobians).
// Times lie around 0, an hour, days and years, and at all places within a keyframe interval.
//
// Pure; thread-safe. Some milliseconds a time.
#pragma once

#include <cstdint>
#include <vector>

#include "sea/surface/answer.h"
#include "sea/waves/realization.h"

namespace seaway::bench {

enum class PointKind : std::uint8_t { anywhere, crest, steep };

struct SamplePoint {
    sea::QueryPoint at;
    PointKind kind;
    int time; ///< index of its time
};

/// How many points a time, and how many times.
struct Sampling {
    int points = 512; ///< a time; at least 4
    int times = 8;
    bool film = true; ///< and heights over a second at 60 Hz; a third of the work at 128 points
    /// Only the times first_time, first_time + time_step, ... of those: seeds share them.
    int first_time = 0;
    int time_step = 1;
};

/// Seconds since the epoch around which times lie; time number i is around the i-th, and round again.
inline constexpr double time_bases_s[] = {0.0, 3600.0, 1e6, 1e9, 60.0, 86'400.0, 1e7, 1e8};

/// Time number `index`: so many steps after its base, by which times are evenly spread over each of the keyframe
/// intervals (sea/surface/budget/spending.h); number 0 is 0 itself.
sea::TimeUs sample_time_us(int index);

/// Points of all times, in order of time. World positions within a few kilometres of the origin.
std::vector<SamplePoint> sample_points(const sea::RealizationPtr& sea, const Sampling& sampling,
                                       std::uint64_t seed);

} // namespace seaway::bench
