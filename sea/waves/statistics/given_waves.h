// SPDX-License-Identifier: Apache-2.0
// Waves that are drawn from no spectrum, as statistics see them. Pure; thread-safe.
#pragma once

#include <functional>

#include "sea/waves/sea_state.h"

namespace seaway::sea {

struct GivenWave {
    double tile_m; ///< side of the tile that they repeat on
    double energy_m2;
    double omega_radps;
    double k_radpm;
    double towards_rad;
    bool still;  ///< it moves nothing sideways
    bool phased; ///< it meets others of its wavenumber with a phase; an octave of noise has none
};

/// Each explicit wave, of which rows of one wave are one, since they add up with their phases; and each stylised one: a harmonic of
/// a sharp one, an octave of noise with the variance that is expected of it, whatever the seed.
void each_given_wave(const SeaState& sea, const std::function<void(const GivenWave&)>& tell);

} // namespace seaway::sea
