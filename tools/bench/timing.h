// SPDX-License-Identifier: Apache-2.0
// Fair timings: every variant once a round, rounds repeated, medians. What slows the machine for a
// while slows all variants alike, so ratios within one run can be trusted.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace seaway::bench {

struct Variant {
    std::string name;
    std::function<void()> run;
    std::vector<double> seconds = {}; ///< one a round

    double median_s() const;
    double least_s() const;
};

/// One round that is not counted, then `rounds` counted ones. Each variant runs twice in a row, the
/// second run counts: what the one before it left in caches and spare buffers is not its own.
void interleave(std::vector<Variant>& variants, int rounds);

} // namespace seaway::bench
