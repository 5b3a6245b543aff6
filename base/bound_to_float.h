// SPDX-License-Identifier: Apache-2.0
// A bound may be widened on its way into a float, never narrowed.
#pragma once

#include <cmath>
#include <limits>

namespace seaway {

inline float bound_to_float(double bound) {
    const auto nearest = static_cast<float>(bound);
    return static_cast<double>(nearest) < bound
               ? std::nextafter(nearest, std::numeric_limits<float>::infinity())
               : nearest;
}

} // namespace seaway
