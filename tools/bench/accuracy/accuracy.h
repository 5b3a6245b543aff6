// SPDX-License-Identifier: Apache-2.0
// `seaway-bench accuracy`: what every knob costs in accuracy, time, bytes and memory, against a sum of
// all waves in double precision. docs/accuracy.md shows it; tools/accuracy_page.py writes that page.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/result.h"
#include "tools/bench/accuracy/truth/points.h"

namespace seaway::bench {

struct AccuracyOptions {
    bool quick = false;              ///< 384 points a time, 8 times; knobs on one sea state
    bool full = false;               ///< 4096 points a time, 32 times; knobs on all six
    std::vector<std::string> knobs;  ///< empty: all
    std::vector<std::string> states; ///< empty: all that the extent says
    std::string device = "native";
    std::string out = "out/bench/accuracy";
    std::uint64_t seed = 1;
    int seeds = 3; ///< named configurations are measured on seed, seed + 1, ...
    std::string
        server; ///< URL of a running one, for batches over a socket; empty: those are left out. Its figures are its own
    int points = 0; ///< a time; 0: as the extent says
    int times = 0;
};

/// Writes accuracy.csv into `out`, trial by trial, error_map.csv, and what truth it has summed; goes on where a run
/// that was stopped left off. Prints one line. An error before anything is measured: options that cannot be, a server that no
/// knob asks.
Result<void> run_accuracy(const AccuracyOptions& options);

} // namespace seaway::bench
