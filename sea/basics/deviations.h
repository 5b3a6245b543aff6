// SPDX-License-Identifier: Apache-2.0
// Of what is missed by chance: how many standard deviations of it count as a bound.
#pragma once

namespace seaway::sea {

/// Of every stated bound on a height.
inline constexpr double bound_sigmas = 5.0;
/// Of what is missed of displacements and strains where folds are told apart (sea/surface/sheets.h): a
/// fold that is overlooked gives an answer that no bound covers.
inline constexpr double fold_sigmas = 6.0;
/// Where it is asked whether two are the same: what is further off is another. Five would tell one sea in 75 000 from itself, for good.
inline constexpr double same_sigmas = 8.0;

} // namespace seaway::sea
