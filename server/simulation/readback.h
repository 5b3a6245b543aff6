// SPDX-License-Identifier: Apache-2.0
// Readback: what maps may lose on their way from a device whose memory the CPU cannot read, and what that costs of a height.
// Pure functions; thread-safe.
#pragma once

#include <cstdint>
#include <vector>

#include "sea/surface/budget/error_budget.h"

namespace seaway::server {

enum class Readback : std::uint8_t {
    exact,   ///< nothing
    rounded, ///< half of their bytes, where 16 bits are enough (KeyframeRequest::rounding)
};

/// Share of what tiles of the finest quality may be off that maps are rounded by: what is left to the codec costs a third of
/// a bit a sample more, and 16 bits reach to 12 m of a tile whose heights are sent to within 0.94 mm, a gale's at 1 cm.
inline constexpr double rounding_share = 0.2;

/// How far maps may be off, a bound a field, so that they can be encoded at every quality (server/host/quality.h), that of
/// fewest keyframes included. Empty: they are exact.
std::vector<float> rounding_bounds(const sea::ErrorBudget& budget, sea::FieldSet fields,
                                   int cascade, Readback readback);

/// What that costs of heights answered from these maps, as sea::map_error() takes it.
inline double rounding_error_m(const sea::ErrorBudget& budget, Readback readback) {
    return readback == Readback::rounded ? rounding_share * budget.codec_error_m : 0.0;
}

} // namespace seaway::server
