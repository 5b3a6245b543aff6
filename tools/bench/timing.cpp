// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/timing.h"

#include <algorithm>
#include <chrono>

#include "base/elapsed.h"

namespace seaway::bench {

double Variant::median_s() const {
    std::vector<double> sorted = seconds;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    return sorted.empty() ? 0.0 : *middle;
}

double Variant::least_s() const {
    return seconds.empty() ? 0.0 : *std::min_element(seconds.begin(), seconds.end());
}

void interleave(std::vector<Variant>& variants, int rounds) {
    for (int round = -1; round < rounds; ++round)
        for (Variant& variant : variants) {
            variant.run(); // into this variant's own buffers and caches
            const auto start = std::chrono::steady_clock::now();
            variant.run();
            const double spent_s = seconds_since(start);
            if (round >= 0)
                variant.seconds.push_back(spent_s);
        }
}

} // namespace seaway::bench
