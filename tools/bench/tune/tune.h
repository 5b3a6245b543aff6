// SPDX-License-Identifier: Apache-2.0
// `seaway-bench tune`: a scene in, the cheapest configuration that keeps a target out, with a certificate
// of what was measured. docs/accuracy.md shows a run.
#pragma once

#include <cstdint>
#include <string>

#include "base/result.h"

namespace seaway::bench {

struct TuneCommand {
    std::string scene;
    double height_error_m = 0.05;
    double percentile = 99;
    double slope_error = 0; ///< 0: not asked
    double budget_ms = 0;   ///< 0: no limit
    double bytes_per_s = 0; ///< 0: no limit
    double envelope_pct = 10;
    std::string device = "native";
    std::string out; ///< scene to be written; empty: beside none, NAME.tuned.toml here
    std::string work = "out/bench/tune"; ///< prices and truths
    std::uint64_t seed = 1;
    int check_seeds = 0; ///< measured afterwards, on seeds that the search did not see
    std::string words;   ///< the command line, for the certificate
};

inline constexpr int tune_reached = 0;
inline constexpr int tune_not_reached = 1;

/// Writes OUT.toml and OUT.certificate.json and says what they are; or says what can be had instead and
/// what it would take, and writes nothing. Gives one of the two above.
Result<int> run_tune(const TuneCommand& command);

} // namespace seaway::bench
