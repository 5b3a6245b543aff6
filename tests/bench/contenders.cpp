// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/contenders.h"

#include <algorithm>
#include <cmath>
#include <ctime>

#include "base/check.h"
#include "tests/sea/native/random_modes.h"

namespace seaway::bench {

namespace {

double milliseconds_of(clockid_t clock) {
    timespec now{};
    clock_gettime(clock, &now);
    return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

} // namespace

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
    const double wall = milliseconds_of(CLOCK_MONOTONIC);
    const double cpu = cpu_milliseconds();
    contender.run(time_us);
    contender.cpu_ms.push_back(cpu_milliseconds() - cpu);
    contender.wall_ms.push_back(milliseconds_of(CLOCK_MONOTONIC) - wall);
}

double cpu_milliseconds() {
    return milliseconds_of(CLOCK_PROCESS_CPUTIME_ID);
}

double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
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
