// SPDX-License-Identifier: Apache-2.0
// The worst of some errors. For std::max a NaN beside a number is nothing at all.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace seaway {

/// The larger one; infinite where one is no number, so that no bound holds it.
inline double worse(double a, double b) {
    return std::isnan(a) || std::isnan(b) ? std::numeric_limits<double>::infinity()
                                          : std::max(a, b);
}

} // namespace seaway
