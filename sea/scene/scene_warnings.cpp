// SPDX-License-Identifier: Apache-2.0
#include "sea/scene/scene_warnings.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "sea/scene/scene_names.h"
#include "sea/surface/inverse.h"
#include "sea/waves/directional_spectrum.h"

namespace seaway::sea {

namespace {

constexpr double tile_wavelengths_min = 8.0;
constexpr double scatter_reported =
    0.06; ///< of Hs; wind seas on eight peak wavelengths have 2 to 6 %
constexpr double breaking_height_over_depth = 0.6;
constexpr double lost_share_reported = 0.01;
constexpr double lattice_bias_reported = 0.01; ///< as a share, or in radians
/// Of m0, in overlaps and gaps of bins: rounding of printed frequencies stays below.
constexpr double bins_reported = 0.002;
constexpr double widening_reported = 0.03; ///< of a spread
constexpr double hurried_reported = 0.05;
/// 5 % of a wavelength, or 3 degrees.
constexpr double snapping_reported = 0.05;

void warn_of_measured(const MeasuredSea& sea, const std::string& system,
                      std::vector<std::string>& warnings) {
    const MeasuredQuality& quality = sea.spectrum->quality;
    const std::size_t bins = sea.spectrum->bins.size();
    if (quality.has_coefficients && !sea.coefficients)
        warnings.push_back(fmt::format(
            "{}: nothing says what a1, b1 are over; they are taken as angles that waves come from, "
            "clockwise from north. coefficients = \"{}\" says so, \"{}\" the contrary",
            system, name_of(CoefficientFrame::from_clockwise_north),
            name_of(CoefficientFrame::towards_anticlockwise_east)));
    if (quality.changed_bins > 0)
        warnings.push_back(fmt::format(
            "{}: directions of {} of {} frequencies fit no spectrum that is nowhere negative; they "
            "were moved to the nearest that does",
            system, quality.changed_bins, bins));
    if (quality.undirected_bins > 0)
        warnings.push_back(fmt::format(
            "{}: {} of {} frequencies have energy but no direction (r1 = r2 = 0); it goes evenly "
            "all around",
            system, quality.undirected_bins, bins));
    if (quality.overlapped_share > bins_reported)
        warnings.push_back(fmt::format(
            "{}: {} bins cover the ones before them; {:.1f} % of the energy is counted twice, as "
            "the sum of S df does",
            system, quality.overlaps, 100.0 * quality.overlapped_share));
    if (quality.gap_share > bins_reported)
        warnings.push_back(fmt::format(
            "{}: {} gaps between bins, the widest {:.4g} .. {:.4g} Hz, hold no waves; straight "
            "lines across them would add {:.1f} % of the energy",
            system, quality.gaps, quality.widest_gap_lo_hz, quality.widest_gap_hi_hz,
            100.0 * quality.gap_share));
    if (quality.spread_read_rad > (1.0 + widening_reported) * quality.spread_of_rows_rad)
        warnings.push_back(fmt::format(
            "{}: the table has few directions for so narrow a sea; straight lines between them "
            "spread it by {:.1f} degrees, its rows alone by {:.1f}",
            system, quality.spread_read_rad * 180.0 / pi, quality.spread_of_rows_rad * 180.0 / pi));
}

void warn_of_systems(const Scene& scene, std::vector<std::string>& warnings) {
    for (std::size_t i = 0; i < scene.sea.systems.size(); ++i) {
        const WaveSystem& system = scene.sea.systems[i];
        const DirectionalSpectrum spectrum(system, scene.sea);
        if (spectrum.growth_clamped())
            warnings.push_back(fmt::format(
                "sea.system[{}]: the fetch is longer than this wind needs; growth is clamped at "
                "full development, peak period {:.3g} s",
                i + 1, two_pi / spectrum.peak_omega_radps()));
        const auto* measured = std::get_if<MeasuredSea>(&system);
        if (measured != nullptr)
            warn_of_measured(*measured, fmt::format("sea.system[{}]", i + 1), warnings);
        const auto* ramps = std::get_if<SineRamps>(&system);
        if (ramps == nullptr)
            continue;
        if (ramps->by_hand.empty()) { // a look: what snapping changes is no fault of it
            if (ramps->wavelength_m > ramps->length_m)
                warnings.push_back(fmt::format(
                    "sea.system[{}]: waves of {:g} m do not fit on {:g} m, after which they "
                    "repeat: such waves become the longest that do, in about their direction",
                    i + 1, ramps->wavelength_m, ramps->length_m));
            continue;
        }
        const SineSnapping moved =
            sine_snapping(*ramps, scene.sea.seed, static_cast<std::uint32_t>(i));
        if (moved.wavelength_share > snapping_reported || moved.direction_rad > snapping_reported)
            warnings.push_back(fmt::format(
                "sea.system[{}]: to repeat every {:g} m, waves are changed by up to {:.0f} % in "
                "length and {:.0f} degrees in direction; a longer tile changes them less",
                i + 1, ramps->length_m, 100.0 * moved.wavelength_share,
                moved.direction_rad * 180.0 / pi));
    }
}

void warn_of_folds(const Scene& scene, const SeaSummary& summary,
                   std::vector<std::string>& warnings) {
    const Choppiness& choppiness = scene.sea.choppiness;
    if (summary.rms_squeeze > folds_common_above)
        warnings.push_back(fmt::format(
            "choppiness {} and an rms strain of {:.2g} fold about {:.2g} % of the surface: "
            "where it folds there are several heights, and answers are flagged",
            choppiness.x == choppiness.y
                ? fmt::format("{:.2g}", choppiness.x)
                : fmt::format("[{:.2g}, {:.2g}]", choppiness.x, choppiness.y),
            std::sqrt(summary.realised.mean_square_strain),
            50.0 * std::erfc(1.0 / (std::sqrt(2.0) * summary.rms_squeeze))));
}

/// What the lattice does to a system whatever the seed (hard case A16), above 1 %.
void warn_of_lattice_bias(const SeaSummary& summary, std::vector<std::string>& warnings) {
    for (const LatticeBias& bias : summary.lattice) {
        const double worst = std::max(
            {std::abs(bias.energy - 1.0), std::abs(bias.turned_rad), std::abs(bias.spread - 1.0)});
        if (worst > lattice_bias_reported)
            warnings.push_back(fmt::format(
                "sea.system[{}]: its waves are few on these tiles; on average over seeds its "
                "energy is off by {:+.1f} %, its direction by {:+.1f} degrees clockwise, its "
                "spread by "
                "{:+.1f} %",
                bias.system + 1, 100.0 * (bias.energy - 1.0), -bias.turned_rad * 180.0 / pi,
                100.0 * (bias.spread - 1.0)));
    }
}

void warn_of_added_tiles(const Realization& realization, std::vector<std::string>& warnings) {
    for (const CascadeModes& cascade : realization.cascades)
        if (!cascade.carries_spectra)
            warnings.push_back(fmt::format(
                "no cascade has the length of the explicit waves, {:g} m; one of size {} was added",
                cascade.spec.length_m, cascade.spec.size));
}

void warn_of_accuracy(const Scene& scene, const ErrorBudget& budget,
                      std::vector<std::string>& warnings) {
    const double asked_m = scene.accuracy.height_error_m;
    if (const double level_m = level_error_m(budget, budget.codec_error_m); level_m > asked_m)
        warnings.push_back(fmt::format(
            "accuracy.height_error_m = {:g} cannot be reached: interpolation alone costs {:.2g} m, "
            "and heights state {:.2g} m on level water; larger sizes of the cascades bring it down",
            asked_m, budget.interpolation_m, level_m));
}

/// By how much the loop changes how fast waves turn, as a share, on average over their energy.
double hurried_by_loop(const Scene& scene, const Realization& realization) {
    if (!(scene.sea.loop_period_s > 0))
        return 0;
    const Dispersion dispersion = scene.sea.dispersion();
    double hurried = 0, all = 0;
    for (const CascadeModes& modes : realization.cascades) {
        const int size = modes.spec.size;
        for (std::size_t i = 0; i < modes.h0.size(); ++i) {
            const double energy = std::norm(modes.h0[i]);
            if (energy == 0)
                continue;
            const int nx = signed_index(static_cast<int>(i) % size, size);
            const int ny = signed_index(static_cast<int>(i) / size, size);
            const double omega =
                dispersion.omega(modes.spec.wavenumber_step_radpm() * std::hypot(nx, ny));
            hurried += energy * std::abs(omega_from_rate(modes.rate[i]) / omega - 1);
            all += energy;
        }
    }
    return all > 0 ? hurried / all : 0;
}

/// Of waves whose orbits are drawn too narrow (orbit_aspect()): their share of the energy, and of their width.
struct Narrowed {
    double energy_share = 0;
    double width = 1; ///< of what it should be, on average over that energy
};
Narrowed narrowed_by_depth(const Scene& scene, const Realization& realization) {
    double energy = 0, width = 0, all = 0;
    for (const CascadeModes& modes : realization.cascades) {
        const int size = modes.spec.size;
        const double step_kd = modes.spec.wavenumber_step_radpm() * scene.sea.depth_m;
        for (std::size_t i = 0; i < modes.h0.size(); ++i) {
            const double norm = std::norm(modes.h0[i]);
            all += norm;
            if (norm == 0 || step_kd >= orbit_kd_min)
                continue;
            const double kd = step_kd * std::hypot(signed_index(static_cast<int>(i) % size, size),
                                                   signed_index(static_cast<int>(i) / size, size));
            if (kd >= orbit_kd_min)
                continue;
            energy += norm;
            width += norm * kd / orbit_kd_min;
        }
    }
    return energy > 0 ? Narrowed{energy / all, width / energy} : Narrowed{};
}

void warn_of_time_and_depth(const Scene& scene, const Realization& realization,
                            std::vector<std::string>& warnings) {
    if (const double hurried = hurried_by_loop(scene, realization); hurried > hurried_reported)
        warnings.push_back(fmt::format(
            "sea.loop_period_s = {:g}: to be whole turns, waves run {:.0f} % faster or slower than "
            "water does; a longer loop changes them less",
            scene.sea.loop_period_s, 100.0 * hurried));
    const Narrowed narrowed = narrowed_by_depth(scene, realization);
    if (narrowed.energy_share > lost_share_reported)
        warnings.push_back(fmt::format("{:.0f} % of the energy of spectra and modes is in waves "
                                       "more than 125 times as long as the water is deep: "
                                       "their sideways motion is {:.2g} of what it should be",
                                       100.0 * narrowed.energy_share, narrowed.width));
}

/// Few waves carry the sea: those of a tile that is short beside the peak, or of a narrow one on any tile.
void warn_of_scatter(const Scene& scene, const Realization& realization, const SeaSummary& summary,
                     std::vector<std::string>& warnings) {
    const double tile = scene.cascades.front().length_m;
    const double peak = summary.longest_peak_wavelength_m;
    if (!(peak > 0.0))
        return;
    const double scatter = hs_scatter(summary);
    if (tile < tile_wavelengths_min * peak)
        warnings.push_back(fmt::format(
            "the largest cascade ({:g} m) holds {:.1f} peak wavelengths of {:.0f} m, fewer than "
            "{:g}: Hs of one seed scatters by {:.0f} %",
            tile, tile / peak, peak, tile_wavelengths_min, 100.0 * scatter));
    else if (scatter > scatter_reported) {
        const auto scatters_m2 = [](const CascadeVariance& one) {
            return one.expected_scatter * one.requested_m2;
        };
        const auto most = std::ranges::max_element(summary.cascades, {}, scatters_m2);
        warnings.push_back(fmt::format(
            "so narrow a sea has few waves on the cascade of {:g} m: Hs of one seed scatters by "
            "{:.0f} %; a longer one in its place scatters less",
            realization.cascades[static_cast<std::size_t>(most - summary.cascades.begin())]
                .spec.length_m,
            100.0 * scatter));
    }
}

} // namespace

std::vector<std::string> scene_warnings(const Scene& scene, const Realization& realization,
                                        const SeaSummary& summary, const ErrorBudget& budget) {
    std::vector<std::string> warnings;
    const double height = summary.requested.significant_height_m;
    warn_of_systems(scene, warnings);
    warn_of_folds(scene, summary, warnings);
    warn_of_lattice_bias(summary, warnings);
    warn_of_added_tiles(realization, warnings);
    warn_of_accuracy(scene, budget, warnings);
    warn_of_time_and_depth(scene, realization, warnings);
    if (!(height > 0.0))
        return warnings;
    const double variance = height * height / 16.0;
    warn_of_scatter(scene, realization, summary, warnings);
    if (height > breaking_height_over_depth * scene.sea.depth_m)
        warnings.push_back(fmt::format(
            "Hs {:.2f} m is above {:g} of the depth, {:g} m: such waves break, outside the model",
            height, breaking_height_over_depth, scene.sea.depth_m));
    const auto lost = [&](double lost_m2, const char* what) {
        if (lost_m2 > lost_share_reported * variance)
            warnings.push_back(
                fmt::format("{:.1f} % of the energy is {}", 100.0 * lost_m2 / variance, what));
    };
    lost(summary.lost_below_m2, "in waves longer than the largest cascade can hold");
    lost(summary.lost_above_m2, "in waves shorter than the finest cascade resolves");
    lost(summary.lost_fade_m2, "taken by the short-wave fade and the cut-offs");
    return warnings;
}

} // namespace seaway::sea
