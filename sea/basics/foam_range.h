// SPDX-License-Identifier: Apache-2.0
// How much foam there may be: of the law that makes it and of the message that carries it.
#pragma once

namespace seaway::sea {

/// Mean coverage at which whatever has broken at all is white, for ratios are 0 or not below 1e-6: a
/// sea that would have more has this much, and looks the same. Also the most that goes over the wire.
inline constexpr double foam_mean_max = 1e6;

} // namespace seaway::sea
