// SPDX-License-Identifier: Apache-2.0
// Energy and phase octave by octave of wavenumber: what a configuration shows of each wave, sampled on a
// grid twice as fine as its maps and transformed, against the wave itself.
//
// Pure but for the sea's own state; about 0.3 s for three cascades of 256.
#pragma once

#include <vector>

#include "tools/bench/accuracy/seas/configured_sea.h"

namespace seaway::bench {

struct Octave {
    double k_radpm = 0;          ///< its lower end, a power of two
    double variance_m2 = 0;      ///< of the waves that the truth has there at this time
    double energy_error_pct = 0; ///< of what is shown, against it
    double phase_error_rad = 0;  ///< of what is shown: root mean square by energy
};

/// At the time that the sea has gone to. Empty for a sea without maps.
std::vector<Octave> octaves(const ConfiguredSea& sea);

} // namespace seaway::bench
