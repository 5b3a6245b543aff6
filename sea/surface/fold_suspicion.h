// SPDX-License-Identifier: Apache-2.0
// Where more sheets than one are looked for. By itself: kernels of every instruction set read it.
#pragma once

namespace seaway::sea {

/// Below this Jacobian on Newton's way, others are searched too.
inline constexpr double fold_suspected_below = 0.4;

} // namespace seaway::sea
