// SPDX-License-Identifier: Apache-2.0
// A sea as an instrument reported it, made into a directional spectrum again.
//
// Frequency: each bin's density is constant over its width, so m0 is the sum of S df, exactly.
// Direction: from the first two Fourier coefficients by the maximum entropy method of Lygre &
// Krogstad 1986, which keeps a1, b1, a2, b2 exactly and is never negative; from a1, b1 alone by the
// cos2s beam with the same first moment; from a table of directions as it stands, linear between
// its entries; from nothing with the spreading that the scene names.
//
// Immutable; thread-safe.
#pragma once

#include <complex>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "sea/spectrum/spreading.h"

namespace seaway::sea {

/// Where one frequency's energy goes: D over "towards" angles, anticlockwise from east.
class MeasuredDirections {
  public:
    /// c_n = integral of D e^{i n phi}. Coefficients that no D >= 0 can have (noise) are moved to
    /// the nearest that one can, keeping c1 if possible; changed() tells.
    static MeasuredDirections from_moments(std::complex<double> c1,
                                           std::optional<std::complex<double>> c2);
    /// `density` >= 0 at equally spaced angles from `first_rad` on, any scale, one of them > 0.
    static MeasuredDirections from_table(double first_rad, std::vector<double> density);

    /// What straight lines between so many entries leave of their first moment: sinc^2 of half a step.
    static double lines_share(std::size_t directions);

    double operator()(double towards_rad) const; ///< 1/rad; integral over the circle is 1
    std::complex<double> first_moment() const { return c1_; }
    bool changed() const { return changed_; }

  private:
    std::complex<double> c1_;
    std::complex<double> phi1_; ///< coefficients of the maximum entropy form
    std::complex<double> phi2_;
    double scale_ = 0.0;
    std::optional<Spreading> beam_; ///< a1, b1 alone
    double first_rad_ = 0.0;
    std::vector<double> table_;
    bool changed_ = false;
};

/// One frequency bin; bins do not overlap and are in order.
struct MeasuredBin {
    double omega_lo_radps;
    double omega_hi_radps;
    double omega_mid_radps;                       ///< as the table gives it
    double density;                               ///< S(w), m2 s/rad
    std::optional<MeasuredDirections> directions; ///< absent: the scene's spreading
};

/// The angles that a buoy's coefficients a_n + i b_n = integral of D e^{i n angle} are over.
enum class CoefficientFrame : std::uint8_t {
    from_clockwise_north,       ///< where waves come from, clockwise from north: CDIP
    towards_anticlockwise_east, ///< where waves go: Longuet-Higgins, Spotter, NDBC's inner a, b
};

/// What a reader of the table should know; energies as shares of m0.
struct MeasuredQuality {
    int changed_bins = 0;          ///< coefficients that no density has: moved
    int undirected_bins = 0;       ///< with energy, but r1 = r2 = 0: spread evenly all around
    bool has_coefficients = false; ///< a1, b1 (.., a2, b2), which need a frame
    int overlaps = 0;
    double overlapped_share = 0.0; ///< counted twice, because bins cover each other
    int gaps = 0;
    double gap_share = 0.0; ///< what straight lines across the gaps would add
    double widest_gap_lo_hz = 0.0;
    double widest_gap_hi_hz = 0.0;
    /// Of a two-dimensional table, all frequencies together: by its rows alone, each for its own direction, and with the
    /// straight lines between them, which are what is read. 0: no such table.
    double spread_of_rows_rad = 0.0;
    double spread_read_rad = 0.0;
};

struct MeasuredSpectrum {
    std::vector<MeasuredBin> bins;
    MeasuredQuality quality;

    /// The bin that holds this frequency, or null.
    const MeasuredBin* find(double omega_radps) const;
    /// peak_around() the highest bin; 0 if there is no energy.
    double peak_omega_radps() const;
    /// The top of the parabola through the middles of this bin and its two neighbours, where both
    /// join it, neither is higher and their widths are like its own (within a factor of 1.75); else
    /// the middle of the bin. `bin` is one of `bins`.
    double peak_around(const MeasuredBin& bin) const;
    bool has_directions() const { return !bins.empty() && bins.front().directions.has_value(); }
};

/// Reads one of these tables; `name` is quoted in errors:
///   f_hz,<width>,s_m2_hz[,<directions>]  one row a frequency, at most 4096. <width> is df_hz, or
///       f_lo_hz,f_hi_hz with f within. <directions> is a1,b1 or a1,b1,a2,b2 over the angles of
///       `frame`; or r1,alpha1_deg or r1,alpha1_deg,r2,alpha2_deg as NDBC publishes them:
///       D(A) = (1/pi) (1/2 + r1 cos(A - alpha1) + r2 cos 2(A - alpha2)), A where waves come
///       from, degrees clockwise from north
///   f_hz,dir_from_deg,e_m2_hz_deg        two-dimensional; every frequency with the same directions
/// Frequencies ascend. At most 4096 rows (72 * 1024 for the two-dimensional table).
Result<MeasuredSpectrum>
parse_measured(std::string_view csv, const std::string& name,
               CoefficientFrame frame = CoefficientFrame::from_clockwise_north);

} // namespace seaway::sea
