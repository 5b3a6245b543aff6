// SPDX-License-Identifier: Apache-2.0
// The reference: the direct sum of every wave in double precision at the sample points, the inverse
// displacement solved to a nanometre. It states its own error, from a sum in long double with phases of
// its own at some points.
//
// Kept in a file below the output folder, under a name that says of which sea, points and version it is.
// Cost: about 0.04 ms a point and core for three cascades of 256, in two threads.
#pragma once

#include <string>
#include <vector>

#include "base/result.h"
#include "sea/surface/answer.h"
#include "tools/bench/accuracy/seas/waves.h"
#include "tools/bench/accuracy/truth/points.h"

namespace seaway::bench {

/// Residual |X + lambda D(X) - x| that the reference solves to.
inline constexpr double truth_tolerance_m = 1e-9;

/// Heights over a second at 60 Hz at a few points: what flicker is measured against.
struct Movie {
    static constexpr int points = 12;
    static constexpr int frames = 61;
    sea::TimeUs start_us = 0;
    std::vector<sea::QueryPoint> at;      ///< time_us is not used
    std::vector<double> heights_m;        ///< [point][frame]
    sea::TimeUs time_us(int frame) const; ///< of a frame
};

struct Truth {
    std::vector<SamplePoint> points;
    std::vector<sea::Answer> answers; ///< one a point
    Movie movie;
    double sum_error_m = 0; ///< largest difference of the two sums
};

/// Summed now.
Truth summed_truth(const Waves& waves, const Sampling& sampling, std::uint64_t seed);

/// Read from `folder` where it is kept, else made and kept there. An error: the file cannot be written.
Result<Truth> reference_truth(const Waves& waves, const Sampling& sampling, std::uint64_t seed,
                              const std::string& folder);

/// Height at an undisplaced point, summed in long double over the whole plane of wavenumbers.
double height_in_long_double(const sea::Realization& sea, double x_m, double y_m,
                             sea::TimeUs time_us);

} // namespace seaway::bench
