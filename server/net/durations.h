// SPDX-License-Identifier: Apache-2.0
// Durations: how long something took, as a histogram of Prometheus.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace seaway::server {

struct Durations {
    /// Up to so many seconds each; what lasts longer is in `count` alone.
    static constexpr std::array<double, 12> bounds_s{0.0001, 0.0002, 0.0005, 0.001, 0.002, 0.005,
                                                     0.01,   0.02,   0.05,   0.1,   0.2,   1};
    std::array<std::uint64_t, bounds_s.size()> within{}; ///< of each bound, and of none before it
    std::uint64_t count = 0;
    double sum_s = 0;

    void add(double seconds) {
        const auto bound = std::ranges::lower_bound(bounds_s, seconds);
        if (bound != bounds_s.end())
            ++within[static_cast<std::size_t>(bound - bounds_s.begin())];
        ++count;
        sum_s += seconds;
    }
};

} // namespace seaway::server
