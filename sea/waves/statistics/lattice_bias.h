// SPDX-License-Identifier: Apache-2.0
// What the lattice makes of a sea whatever the seed: the part of summarize() that comes from expected
// variances (sea/waves/mode_variances.h).
#pragma once

#include "sea/waves/statistics/moments.h"

namespace seaway::sea {

/// Fills expected_m2 and expected_scatter of each cascade, which must be there with what spectra put into it, adds to both what waves given
/// one by one do, and fills `lattice`.
void add_expected(const SeaState& sea, const Realization& realization, SeaSummary& summary);

} // namespace seaway::sea
