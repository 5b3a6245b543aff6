// SPDX-License-Identifier: Apache-2.0
// Probes of a sea: heights and displacements at places and times that follow from its tiles and from when
// it begins. Another seed, a mode that is missing, a sign of D, a phase in single precision: each moves
// some of them by more than probe_error_m.
//
// Pure; thread-safe. Cost: probe_count times of the exact sum (sea/waves/reference.h).
#pragma once

#include <span>
#include <vector>

#include "sea/basics/probe.h"
#include "sea/waves/reference.h"

namespace seaway::sea {

/// Over the loop of the sea from `from_us` on, or over a day where it has none; over a square of eight of its
/// longest tiles around the origin. Spread evenly along each (Kronecker's sequence).
std::vector<Probe> make_probes(const DirectSum& sea, TimeUs from_us);

/// How far a sea is from probes, m: of all of them the largest difference of a height and of a component of
/// D. NaN where a sea or a probe is not a number.
struct ProbeDifference {
    double height_m = 0;
    double displacement_m = 0;

    /// The same sea, where the one that is held against the probes may be off by these.
    bool within(double bound_m, double displacement_bound_m) const {
        return height_m <= bound_m && displacement_m <= displacement_bound_m;
    }
};
ProbeDifference compare(const DirectSum& sea, std::span<const Probe> probes);

} // namespace seaway::sea
