// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/timing.h"

#include <algorithm>
#include <chrono>

#include "base/elapsed.h"
#include "base/quantile.h"

namespace seaway::bench {

double Variant::median_s() const {
    return median(seconds);
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
