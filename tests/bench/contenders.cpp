// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/contenders.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "base/check.h"
#include "base/elapsed.h"
#include "tests/sea/native/random_modes.h"

namespace seaway::bench {

std::vector<sea::CascadeModes> three_cascades(int size, double reach) {
    std::vector<sea::CascadeModes> modes;
    for (int seed = 0; seed < cascade_count; ++seed) {
        modes.push_back(sea::random_modes(size, reach * size / 2, static_cast<std::uint64_t>(seed),
                                          50.0 * std::pow(5, seed)));
        modes.back().depth_m = sea::deep_water_m;
    }
    return modes;
}

void run_timed(Contender& contender, sea::TimeUs time_us) {
    const auto start = std::chrono::steady_clock::now();
    const double cpu_s = process_cpu_seconds();
    contender.run(time_us);
    contender.cpu_ms.push_back(1e3 * (process_cpu_seconds() - cpu_s));
    contender.wall_ms.push_back(1e3 * seconds_since(start));
}

double fastest(const std::vector<double>& values) {
    return *std::min_element(values.begin(), values.end());
}

void check_same(std::span<const float> a, std::span<const float> b) {
    SEAWAY_CHECK(a.size() == b.size(), "two programs make maps of different sizes");
    double worst = 0, sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        worst = std::max(worst, std::abs(double{a[i]} - double{b[i]}));
        sum += double{a[i]} * double{a[i]};
    }
    SEAWAY_CHECK(worst < 1e-4 * std::sqrt(sum / static_cast<double>(a.size())),
                 "two programs make different seas");
}

} // namespace seaway::bench
