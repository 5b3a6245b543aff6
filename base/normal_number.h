// SPDX-License-Identifier: Apache-2.0
// Numbers as readers of files hand them on. Pure.
#pragma once

#include <cmath>

namespace seaway {

/// -0 and what is smaller than the smallest normal number are 0: nothing behind a reader meets them (hard case A21).
inline double normal_or_zero(double value) {
    return std::isnormal(value) || !std::isfinite(value) ? value : 0.0;
}

} // namespace seaway
