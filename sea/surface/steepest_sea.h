// SPDX-License-Identifier: Apache-2.0
// The steepest seas that are run and told: beyond them maps would say nothing. A server refuses them by name, and a client takes who
// tells of one for broken.
#pragma once

namespace seaway::sea {

inline constexpr double told_error_m_max = 1e6;  ///< between keyframes and grid points, of heights
inline constexpr double told_slope_max = 1e6;    ///< rms
inline constexpr double told_sideways_max = 1e9; ///< of displacements, m, and of strains
inline constexpr double told_curvature_per_m_max = 1e15;

} // namespace seaway::sea
