// SPDX-License-Identifier: Apache-2.0
// What a sea amounts to: heights, periods, directions; as asked for and as realised.
// Pure functions; thread-safe.
#pragma once

#include <vector>

#include "sea/waves/realization.h"
#include "sea/waves/sea_state.h"

namespace seaway::sea {

/// Waves of longer periods stand still: stylised ones may be slowed down so far.
inline constexpr double period_max_s = 1e9;

struct SeaStatistics {
    double significant_height_m = 0; ///< 4 sqrt(m0)
    /// Requested: where S(f) is largest; of measured bins the top of the parabola through the
    /// highest bin and its neighbours, or its middle where they do not allow one
    /// (MeasuredSpectrum::peak_around). Of explicit and stylised waves the frequency that most of their energy
    /// has, if they hold more than spectra do in a band of 10 % around their peak. Realised: sum S^4 / sum f S^4 around the densest band (Young
    /// 1995). 0 for a flat sea and one that stands still, as all periods.
    double peak_period_s = 0;
    /// 2 pi sqrt(m0/m2). Of Phillips' spectrum with surface tension m2 is of the waves up to the end of the finest band: whole, it is infinite.
    double zero_crossing_period_s = 0;
    double mean_period_s = 0;     ///< Tm01 = 2 pi m0/m1
    double mean_towards_rad = 0;  ///< energy-weighted, anticlockwise from east
    double spread_rad = 0;        ///< circular: sqrt(2 (1 - |sum E e^i theta| / m0))
    double mean_square_slope = 0; ///< of the waves up to the end of the finest band
    /// Of the divergence of D over the same waves; in deep water the mean square slope.
    double mean_square_strain = 0;
};

struct CascadeVariance {
    double
        requested_m2; ///< integral of the spectrum over the band, and waves given one by one on this tile
    double expected_m2; ///< mean of realised_m2 over seeds: what the lattice makes of it
    double realised_m2; ///< sum over the drawn modes, averaged over time
    /// Relative standard deviation, over seeds, of Hs of the tile at one instant: sqrt(2 sum E^2) / (2 m0),
    /// E the mean of the variances expected of k and -k (physics.md section 5), and under the root 4 E E_given of each wave that
    /// is given as well. Of waves drawn from spectra: what a noise scatters by is not in it.
    double expected_scatter;
};

/// What the lattice makes of one wave system on average over seeds, beside what its spectrum puts
/// into the bands. Energy is shared exactly (sea/waves/mode_variances.h); directions are those of
/// the modes, and where a beam is a few modes wide they are not its own.
struct LatticeBias {
    std::size_t system = 0;  ///< index in the sea state; a system with a spectrum
    double energy = 1.0;     ///< ratio of variances, expected over requested
    double turned_rad = 0.0; ///< expected mean direction less the requested; 0 where there is none
    double spread = 1.0;     ///< ratio of circular spreads; 1 where the requested is zero
};

struct SeaSummary {
    SeaStatistics requested;               ///< integrals of the spectrum itself
    SeaStatistics realised;                ///< sums over the drawn modes, averaged over time
    std::vector<CascadeVariance> cascades; ///< of the realisation, in its order
    std::vector<LatticeBias> lattice;      ///< of systems with energy in the bands
    double lost_below_m2 = 0;              ///< waves longer than the longest tile can hold
    double lost_above_m2 = 0;              ///< waves shorter than the finest band
    double lost_fade_m2 = 0;               ///< short-wave fade and cut-offs, within the bands
    double longest_peak_wavelength_m = 0;  ///< over the systems with a spectrum; 0: none has
    double rms_squeeze =
        0; ///< of lambda_x dDx/dx + lambda_y dDy/dy of the drawn modes: what folds a sea
    /// Where a measured bin holds the requested peak: the period of its middle, which is the Tp that
    /// buoys publish (CDIP, NDBC). Else 0.
    double peak_bin_period_s = 0;
};

/// Relative standard deviation, over seeds, of Hs of the whole sea at one instant. Cascades are drawn apart from each
/// other: variances of m0 add, and Hs scatters by half of m0's share. 0 for a sea without spectra.
double hs_scatter(const SeaSummary& summary);

/// About as long as realize().
SeaSummary summarize(const SeaState& sea, const Realization& realization);

/// Variance that was asked for between two frequencies, m2, to 1e-9: spectra and explicit waves.
double requested_variance(const SeaState& sea, double omega_lo_radps, double omega_hi_radps);

/// S(w) that was asked for, m2 s/rad, all systems; explicit and stylised waves, which are lines,
/// are not in it.
double requested_frequency_density(const SeaState& sea, double omega_radps);

} // namespace seaway::sea
