// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/map_difference.h"

#include <cmath>
#include <limits>

#include "base/worse.h"

namespace seaway::bench {

MapDifference largest_difference(const sea::Keyframe& a, const sea::Keyframe& b) {
    MapDifference largest;
    for (const sea::Field field : a.fields) {
        const auto p = a.plane(field), q = b.plane(field);
        double squares_p = 0, squares_q = 0, worst = 0;
        for (std::size_t i = 0; i < p.size(); ++i) {
            const auto in_a = static_cast<double>(p[i]), in_b = static_cast<double>(q[i]);
            squares_p += in_a * in_a;
            squares_q += in_b * in_b;
            worst = worse(worst, std::abs(in_a - in_b));
        }
        if (worst == 0)
            continue;
        const double scale =
            4 * std::sqrt(std::max(squares_p, squares_q) / static_cast<double>(p.size()));
        const double share =
            std::isfinite(worst) ? worst / scale : std::numeric_limits<double>::infinity();
        if (share > largest.share)
            largest = {share, sea::info(field).name};
    }
    return largest;
}

} // namespace seaway::bench
