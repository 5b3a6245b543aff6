// SPDX-License-Identifier: Apache-2.0
// `seaway-bench spectrum`: what the waves of a scene are as a rung of their own: bytes, what is missed with each chunk,
// and how far answers of a client that sums them are from the server's exact ones. docs/performance/line.md shows it.
#pragma once

#include <string>

#include "base/result.h"
#include "tools/bench/usual_scene.h"

namespace seaway::bench {

struct SpectrumOptions {
    std::string scene = usual_scene();
    double error_m = 0.01; ///< what the client asks for
    double slope_error = 0.005;
    int times = 1000; ///< over 24 h
    int places = 20;  ///< at each
};

/// Prints the curve of bytes and what is missed, and the largest errors found: of answers above world points, of
/// heights and slopes of the undisplaced sea, and of whole maps of all cascades, which is a bound on any place.
Result<void> run_spectrum(const SpectrumOptions& options);

} // namespace seaway::bench
