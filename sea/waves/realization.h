// SPDX-License-Identifier: Apache-2.0
// One realised sea: the complex amplitudes h0(k) and the frequencies that everything else -
// transforms, exact sums, tiles - is made from. Immutable once built; share it by pointer.
//
//     eta(X,t) = sum_k h(k,t) exp(i k.X)
//     h(k,t)   = h0(k) exp(-i w t) + conj(h0(-k)) exp(+i w t)          waves travel along +k
//     h0(k)    = (xr + i xi)/2 sqrt(Psi(k) dkx dky)                    E[eta^2] = sum Psi dk^2
//     D(X,t)   = sum_k i (k/|k|) coth(|k| d) h(k,t) exp(i k.X)         so water moves on depth d
//
// Source: Tessendorf 2001 with the amplitude of physics.md section 0 (docs/physics.md).
#pragma once

#include <algorithm>
#include <complex>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "base/result.h"
#include "sea/basics/cascade.h"
#include "sea/basics/constants.h"
#include "sea/basics/dispersion.h"
#include "sea/basics/time.h"
#include "sea/waves/sine_waves.h"

namespace seaway::sea {

/// The realised modes of one cascade. Arrays are [iy][ix], index iy * size + ix, in transform order
/// (array index i stands for lattice index signed_index(i)); zero outside the band.
struct CascadeModes {
    CascadeSpec spec;
    Band band;                            ///< of the spectra; explicit modes may lie outside
    std::vector<std::complex<double>> h0; ///< m
    std::vector<Rate> rate;               ///< frequency, turns/us 0.64; the same for k and -k
    /// Phase that a change of frequency on the way has left in h0, turns 0.64 (sea/waves/transition.h);
    /// empty: none.
    std::vector<std::uint64_t> phase_offset_turns;
    /// Not 0: a wave whose phase a scene gives, so that it may agree with others'; empty: there is none.
    std::vector<std::uint8_t> given;
    /// False: added for explicit waves alone; the spectra's bands do not know it.
    bool carries_spectra = true;
    /// Stylised waves that are no modes, on this tile (sea/waves/sine_waves.h); mostly empty.
    std::vector<SineField> sines;
    /// Waves given by hand are no longer than this says, rad/m; infinity: there are none.
    double placed_from_radpm = std::numeric_limits<double>::infinity();
    double depth_m = deep_water_m;

    /// All of its waves are at least as short, whatever raised them.
    double longest_radpm() const { return std::min(band.k_lo_radpm, placed_from_radpm); }

    /// A sea that is given to a device may lack cascades that nobody asks for: of those there are no waves, and the rest is said.
    bool is_there() const { return !h0.empty(); }

    bool is_given(std::size_t mode) const { return !given.empty() && given[mode] != 0; }

    /// coth(k d)/k: what h(k) and a wavenumber are multiplied by in D = +i (k/|k|) coth(|k| d) h
    /// and its gradients. k > 0.
    double displacement_over_k(double k_radpm) const {
        return orbit_aspect(k_radpm, depth_m) / k_radpm;
    }
};

/// How far the surface is moved sideways: x = X + choppiness * D(X), each axis for itself. 0 .. 3.
struct Choppiness {
    double x = 1.0;
    double y = 1.0;

    double largest() const { return std::max(x, y); }
    bool operator==(const Choppiness&) const = default;
};

struct Realization {
    std::vector<CascadeModes> cascades; ///< longest tile first
    Choppiness choppiness;
    TimeUs loop_period_us = 0; ///< 0: the sea never repeats

    /// The time at which phases are taken: t itself, or t modulo the loop period (in [0, period)),
    /// which makes a loop exact for ever.
    TimeUs phase_time(TimeUs t_us) const {
        if (loop_period_us <= 0)
            return t_us;
        const TimeUs rest = t_us % loop_period_us;
        return rest < 0 ? rest + loop_period_us : rest;
    }
};

using RealizationPtr = std::shared_ptr<const Realization>;

/// What its modes take in memory.
inline std::size_t bytes_of(const Realization& sea) {
    std::size_t bytes = 0;
    for (const CascadeModes& modes : sea.cascades)
        bytes += modes.h0.size() * sizeof(modes.h0[0]) + modes.rate.size() * sizeof(Rate) +
                 modes.phase_offset_turns.size() * sizeof(std::uint64_t) + modes.given.size();
    return bytes;
}

} // namespace seaway::sea
