// SPDX-License-Identifier: Apache-2.0
// From a sea state to its waves: draws h0(k) for every mode of every cascade.
//
//     h0(k) = (xr + i xi)/2 sqrt(variance of k's cell, sea/waves/mode_variances.h), summed over the
//     wave systems, each with its own numbers
//
// The same scene gives the same bits on every IEEE machine with the same libm, at -O0 and -O2, for
// every grid size (a mode keeps its numbers when N changes). Pure; thread-safe. Three cascades of
// 256 x 256 take about 30 ms a wave system on one core.
#pragma once

#include <optional>
#include <span>

#include "sea/basics/cascade.h"
#include "sea/basics/dispersion.h"
#include "sea/waves/realization.h"
#include "sea/waves/sea_state.h"

namespace seaway::sea {

/// Explicit and stylised waves go to the cascade of their tile's length; if there is none, one is
/// added (its place is by length, so the realised sea may have more cascades than were asked for).
/// Errors: cascades that leave a gap or stand in the wrong order (assign_bands), explicit waves
/// that their tile cannot hold.
Result<Realization> realize(const SeaState& sea, std::span<const CascadeSpec> cascades);

/// By what law its keyframes follow from each other; none where some waves are no modes.
std::optional<WaveLaw> wave_law(const SeaState& sea, const Realization& realization);

/// The same without amplitudes (h0 is empty): tiles, frequencies and phases. About 2 ms.
Result<Realization> realize_clocks(const SeaState& sea, std::span<const CascadeSpec> cascades);

/// The frequencies of all waves from the tile's longest one to the end of its band, whether there is one or not: in a transition a wave that comes or goes turns by
/// the law of the sea that it comes to, and who knows no more than which waves are large (spectrum_builder.h) turns it alike.
/// The band's waves are no faster than a rate holds.
void fill_rates(CascadeModes& modes, const Dispersion& dispersion, TimeUs loop_period_us);

/// The stored frequency of a wave: omega(k), or with a loop the nearest whole number of turns a
/// period, at least one (hard case B7: rounding down would freeze long swell).
Rate mode_rate(double omega_radps, TimeUs loop_period_us);

/// The tile on which a system's waves given one by one stand, m; 0 for a spectrum. Two lengths within
/// 1e-9 are the same tile.
double explicit_length_m(const WaveSystem& system);
bool same_tile_length(double held_m, double wanted_m);

/// Size of a tile that is added for explicit waves up to this lattice index: the power of two, at
/// least 64, that keeps them below band_end_share_of_nyquist.
int explicit_tile_size(int steps);
inline constexpr int explicit_steps_max = 300; ///< so that no added tile is above 1024

} // namespace seaway::sea
