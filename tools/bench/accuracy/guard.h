// SPDX-License-Identifier: Apache-2.0
// `seaway-bench guard`: are errors what they were? A few configurations, few points, always the same ones,
// against figures that are kept in a file. Errors alone: nothing is timed, so a busy machine does not matter.
//
// Presets guard what a budget delivers; configurations with their own intervals and codec bounds guard the
// kernels, the splines, the codec and the inverse, whatever the budget says. 15 s of CPU; the same figures
// every time but for the rounding of maps by instruction set (1e-7 of them).
#pragma once

#include <span>
#include <string>
#include <vector>

#include "base/result.h"

namespace seaway::bench {

/// An error grown by more than this share of itself fails; fallen by more, it is told.
inline constexpr double guard_share_max = 0.20;

struct GuardOptions {
    std::string baseline = "tests/data/accuracy_baseline.csv";
    bool renew = false; ///< writes the file instead of comparing with it
};

struct GuardedFigure {
    std::string state;         ///< of sea_states.h
    std::string configuration; ///< "balanced", "codec 0.02 m"
    std::string metric;        ///< of measure.h
    double value = 0;          ///< never negative
};

/// Measures all.
Result<std::vector<GuardedFigure>> guarded_figures();

/// Rows "state,configuration,metric,value" below notes that say whence they are. Errors name the line.
std::string guard_csv(std::span<const GuardedFigure> figures);
Result<std::vector<GuardedFigure>> parse_guard_csv(const std::string& text,
                                                   const std::string& name);

/// One line each, with configuration, figure, old and new.
struct GuardFindings {
    std::vector<std::string> failures; ///< grown, or in one of the two lists only
    std::vector<std::string> told;     ///< fallen: the file is to be renewed
};
GuardFindings compare_with_baseline(std::span<const GuardedFigure> baseline,
                                    std::span<const GuardedFigure> measured);

/// True: no failure. Prints findings and a last line.
Result<bool> run_guard(const GuardOptions& options);

} // namespace seaway::bench
