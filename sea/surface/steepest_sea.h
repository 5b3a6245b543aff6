// SPDX-License-Identifier: Apache-2.0
// The steepest seas that are run and told: beyond them maps would say nothing. A server refuses them by name, and a client takes who
// tells of one for broken. While one sea glides to another both are there: what is refused is a share of what can be told, so that
// every glide between two that run can be told, too.
#pragma once

namespace seaway::sea {

inline constexpr double told_error_m_max = 1e6;  ///< between keyframes and grid points, of heights
inline constexpr double told_slope_max = 1e6;    ///< rms
inline constexpr double told_sideways_max = 1e9; ///< of displacements, m, and of strains
inline constexpr double told_curvature_per_m_max = 1e15;
inline constexpr double steady_share_of_told = 0.25;

} // namespace seaway::sea
