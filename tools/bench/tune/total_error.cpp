// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/tune/total_error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "base/worse.h"

namespace seaway::bench {

namespace {

/// P(|e + sigma z| <= x).
double share_below(double e, double sigma, double x) {
    const double scale = 1.0 / (sigma * std::numbers::sqrt2);
    return 0.5 * (std::erf((x - e) * scale) + std::erf((x + e) * scale));
}

} // namespace

double percentile_with_normal(std::span<const double> errors, double sigma, double percent) {
    if (errors.empty())
        return sigma * normal_percentile(percent);
    const double wanted = 0.01 * percent;
    double largest = 0;
    for (const double e : errors)
        largest = worse(largest, std::abs(e));
    if (!std::isfinite(largest) || !std::isfinite(sigma))
        return std::numeric_limits<double>::infinity();
    // Narrower than this against the errors is none at all, and divides by nothing.
    if (!(sigma > 1e-9 * largest)) {
        std::vector<double> sizes;
        for (const double e : errors)
            sizes.push_back(std::abs(e));
        std::sort(sizes.begin(), sizes.end());
        const double rank = wanted * static_cast<double>(sizes.size());
        return sizes[std::min(static_cast<std::size_t>(rank), sizes.size() - 1)];
    }
    double low = 0, high = largest + 10.0 * sigma;
    while (high - low > 1e-9 * high) {
        const double x = 0.5 * (low + high);
        double below = 0;
        for (const double e : errors)
            below += share_below(e, sigma, x);
        (below < wanted * static_cast<double>(errors.size()) ? low : high) = x;
    }
    return high;
}

double normal_percentile(double percent) {
    double low = 0, high = 10;
    while (high - low > 1e-12) {
        const double x = 0.5 * (low + high);
        (share_below(0.0, 1.0, x) < 0.01 * percent ? low : high) = x;
    }
    return high;
}

} // namespace seaway::bench
