// SPDX-License-Identifier: Apache-2.0
#include "sea/surface/budget/error_budget.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <iterator>
#include <numbers>

#include "sea/surface/budget/sine_error.h"

namespace seaway::sea {

namespace {

constexpr double bound_sigmas = 6.0;

/// Largest gain of two-dimensional cubic spline interpolation on bounded errors at the grid points
/// (Lebesgue constant 1.549 a dimension).
constexpr double spline_gain = 1.549 * 1.549;

/// And on its gradient, per grid spacing: 3 along and 1.549 across, both of them most in the middle of a
/// cell, and two components along two axes.
constexpr double spline_slope_gain = 2.0 * 3.0 * 1.549;

/// How a height tile's budget is split between values and time rates.
constexpr double value_share = 0.6;

/// Bounds for maps that no height depends on: fine enough for shading and foam.
constexpr float slope_error = 0.002f;
constexpr float jacobian_error = 0.004f;

double square(double x) {
    return x * x;
}

/// Variance of heights, displacements or strains by frequency, and what the grid spacing costs of it.
struct Motion {
    static constexpr int bins = 512;
    std::array<double, bins> by_frequency_m2{};
    double space_m2 = 0;
    double gradient = 0;
    double whole_m2 = 0;
    double single_m = 0; ///< what single precision costs

    void add(double variance, double k_squared, int bin, double missed) {
        by_frequency_m2[static_cast<std::size_t>(bin)] += variance;
        space_m2 += variance * missed * missed;
        gradient += variance * k_squared;
        whole_m2 += variance;
    }
    /// All but the frequencies.
    void add(const Motion& part) {
        space_m2 += part.space_m2;
        gradient += part.gradient;
        whole_m2 += part.whole_m2;
        single_m += part.single_m;
    }
};

/// The modes of one cascade.
struct BandStatistics {
    double omega_max_radps = 0;
    Motion height;
    Motion displacement;
    Motion strain;

    /// `aspect` of the water's orbits.
    void add(double variance, double kx, double ky, double omega_radps, double spacing_m,
             double aspect) {
        const double share = omega_radps / omega_max_radps;
        const int bin = std::min(static_cast<int>(share * Motion::bins), Motion::bins - 1);
        const double missed =
            spline_error(std::abs(kx) * spacing_m) + spline_error(std::abs(ky) * spacing_m);
        const double slope_missed = spline_slope_error(std::abs(kx) * spacing_m) +
                                    spline_slope_error(std::abs(ky) * spacing_m);
        const double k_squared = kx * kx + ky * ky;
        height.add(variance, k_squared, bin, missed);
        displacement.add(variance * (aspect * aspect), k_squared, bin, missed);
        strain.add(variance * (aspect * aspect) * k_squared, 0, bin, slope_missed);
    }
    void add_single_precision(double spacing_m) {
        height.single_m = single_precision_share * 4.0 * std::sqrt(height.whole_m2);
        displacement.single_m = single_precision_share * 4.0 * std::sqrt(displacement.whole_m2);
        strain.single_m = sampled_slope_error(displacement.single_m, spacing_m);
    }
};

BandStatistics statistics(const CascadeModes& modes) {
    BandStatistics s;
    for (std::size_t i = 0; i < modes.h0.size(); ++i)
        if (modes.h0[i] != std::complex<double>{})
            s.omega_max_radps = std::max(s.omega_max_radps, omega_from_rate(modes.rate[i]));
    const int size = modes.spec.size;
    const double dk = modes.spec.wavenumber_step_radpm();
    const double dx = modes.spec.spacing_m();
    for (int iy = 0; iy < size; ++iy)
        for (int ix = 0; ix < size; ++ix) {
            const auto i = static_cast<std::size_t>(iy) * static_cast<std::size_t>(size) +
                           static_cast<std::size_t>(ix);
            const double variance = 2.0 * std::norm(modes.h0[i]);
            const double kx = dk * signed_index(ix, size), ky = dk * signed_index(iy, size);
            if (variance > 0)
                s.add(variance, kx, ky, omega_from_rate(modes.rate[i]), dx,
                      orbit_aspect(std::hypot(kx, ky), modes.depth_m));
        }
    s.add_single_precision(dx);
    return s;
}

/// What a hard bound counts where standard deviations are added.
double as_rms(double bound_m) {
    return bound_m / bound_sigmas;
}

double time_rms(const Motion& motion, double omega_max_radps, TimeUs interval_us) {
    double sum = 0;
    for (int bin = 0; bin < Motion::bins; ++bin) {
        const double omega = omega_max_radps * (bin + 1) / Motion::bins;
        const double missed = hermite_error(omega * seconds_from_us(interval_us));
        sum += motion.by_frequency_m2[static_cast<std::size_t>(bin)] * missed * missed;
    }
    return std::sqrt(sum);
}

/// Keyframes so far apart that a wave turns more than once between two of them say nothing of it.
bool keyframes_tell(const BandStatistics& s, TimeUs interval_us) {
    return s.omega_max_radps * seconds_from_us(interval_us) <= hermite_phase_max;
}

/// What a metre sideways costs of a height at typical steep places.
double sideways_weight(const ErrorBudget& budget) {
    return std::max(budget.choppiness.x, budget.choppiness.y) *
           std::min(1.0, 3.0 * budget.rms_slope);
}

/// How much a codec error of every map counts against the height at typical steep places.
double displacement_weight(const ErrorBudget& budget) {
    return std::numbers::sqrt2 * sideways_weight(budget);
}

/// One cascade, its stylised waves too, which move nothing sideways.
struct Cascade {
    explicit Cascade(const CascadeModes& waves)
        : modes(statistics(waves)), spacing_m(waves.spec.spacing_m()) {
        for (const SineField& field : waves.sines) {
            sines.emplace_back(field, spacing_m);
            modes.height.space_m2 += square(as_rms(sines.back().space_m()));
            modes.height.gradient += sines.back().slope_variance();
        }
    }
    BandStatistics modes;
    double spacing_m;
    std::vector<SineError> sines;
};

/// A keyframe interval and what it costs.
struct Interval {
    TimeUs us = 0;
    double height_rms_m = 0;
    double displacement_rms_m = 0;
    double strain_rms = 0;
};

Interval longest_interval(const Cascade& cascade, const ErrorBudget& budget, double share_m) {
    const BandStatistics& s = cascade.modes;
    // In deep water heights and displacements are missed alike, and the weight is that of a slope.
    const double weight = std::min(1.0, sideways_weight(budget));
    Interval interval;
    for (const TimeUs us : keyframe_intervals_us) {
        const bool last = us == *std::rbegin(keyframe_intervals_us);
        if (!last && !keyframes_tell(s, us))
            continue;
        double height_m2 = square(time_rms(s.height, s.omega_max_radps, us));
        for (const SineError& sine : cascade.sines)
            height_m2 += square(as_rms(sine.time_m(us)));
        interval = {us, std::sqrt(height_m2), time_rms(s.displacement, s.omega_max_radps, us),
                    time_rms(s.strain, s.omega_max_radps, us)};
        if (bound_sigmas * std::max(interval.height_rms_m, weight * interval.displacement_rms_m) <=
            share_m)
            break;
    }
    return interval;
}

/// Sum of the amplitudes of the images of a wave beyond Nyquist, over its own, to a power.
double aliases_of(double q, int power) {
    double sum = 0;
    for (int j = 1; j <= 8; ++j) {
        const double shift = 2.0 * std::numbers::pi * j;
        sum += std::pow(q / (shift + q), power) + std::pow(q / (shift - q), power);
    }
    return sum;
}

/// Error of a sampled value of one cascade when the tiles may cost `codec_error_m` of height.
double sampled_error(const ErrorBudget& budget, double codec_error_m) {
    return codec_error_m / static_cast<double>(budget.cascades.size()) /
           (1.0 + displacement_weight(budget));
}

} // namespace

double hermite_error(double u) {
    if (u <= hermite_phase_max)
        return 1.0 - std::cos(0.5 * u) - 0.25 * u * std::sin(0.5 * u);
    // The wave itself, the two values, whose weights add up to one, and the two rates: to 1/4.
    return 2.0 + 0.25 * u;
}

double spline_error(double q) {
    const double aliases = aliases_of(q, 4);
    return 2.0 * aliases / (1.0 + aliases);
}

double spline_slope_error(double q) {
    // Each alias is steeper than the wave by the ratio of their wavenumbers.
    const double aliases = aliases_of(q, 4);
    return (aliases + aliases_of(q, 3)) / (1.0 + aliases);
}

ErrorBudget plan_budget(const Realization& sea, double height_error_m) {
    ErrorBudget budget;
    budget.height_error_m = height_error_m;
    budget.choppiness = sea.choppiness;
    const double time_share_m =
        budget.shares.time * height_error_m /
        std::sqrt(static_cast<double>(std::max<std::size_t>(sea.cascades.size(), 1)));
    std::vector<Cascade> cascades;
    Motion height, displacement, strain; // of all cascades
    for (const CascadeModes& modes : sea.cascades) {
        const Cascade& cascade = cascades.emplace_back(modes);
        height.add(cascade.modes.height);
        displacement.add(cascade.modes.displacement);
        strain.add(cascade.modes.strain);
    }
    budget.rms_slope = std::sqrt(height.gradient);
    budget.rms_strain = std::sqrt(displacement.gradient);
    budget.displacement_reach_m = bound_sigmas * std::sqrt(displacement.whole_m2) *
                                  std::max(sea.choppiness.x, sea.choppiness.y);
    double height_m2 = height.space_m2, displacement_m2 = displacement.space_m2;
    double strain_2 = strain.space_m2;
    for (const Cascade& cascade : cascades) {
        const Interval chosen = longest_interval(cascade, budget, time_share_m);
        height_m2 += square(chosen.height_rms_m);
        displacement_m2 += square(chosen.displacement_rms_m);
        strain_2 += square(chosen.strain_rms);
        budget.cascades.push_back({chosen.us, chosen.height_rms_m,
                                   std::sqrt(cascade.modes.height.space_m2), cascade.spacing_m});
    }
    budget.interpolation_m = bound_sigmas * std::sqrt(height_m2) + height.single_m;
    budget.interpolation_displacement_m =
        bound_sigmas * std::sqrt(displacement_m2) + displacement.single_m;
    budget.interpolation_strain = bound_sigmas * std::sqrt(strain_2) + strain.single_m;
    return budget;
}

double level_error_m(const ErrorBudget& budget) {
    return budget.interpolation_m + budget.shares.codec * budget.height_error_m;
}

FoldSearch fold_search(const ErrorBudget& budget) {
    return fold_search(budget.displacement_reach_m, budget.choppiness, budget.rms_strain);
}

std::vector<float> codec_bounds(const ErrorBudget& budget, FieldSet fields, int cascade,
                                double codec_error_m) {
    // Spent so that sampled_codec_error() gives the sampled error back.
    const double e = sampled_error(budget, codec_error_m) / spline_gain;
    const double interval_s =
        seconds_from_us(budget.cascades[static_cast<std::size_t>(cascade)].interval_us);
    std::vector<float> bounds;
    for (const Field field : fields) {
        const FieldInfo& row = info(field);
        if (surface_fields.contains(field))
            bounds.push_back(static_cast<float>(
                row.time_rate ? (1.0 - value_share) * e * 4.0 / interval_s : value_share * e));
        else
            bounds.push_back(is_linear(field) ? slope_error : jacobian_error);
    }
    return bounds;
}

double sampled_codec_error(double value_error, double rate_error, double interval_s) {
    // Hermite weights: the two values add up to one, the two rates to interval / 4 at most.
    return spline_gain * (value_error + 0.25 * interval_s * rate_error);
}

double sampled_slope_error(double sampled_error, double spacing_m) {
    return sampled_error * spline_slope_gain / (spline_gain * spacing_m);
}

MapError map_error(const ErrorBudget& budget, double codec_error_m) {
    MapError error{.interpolation_m = budget.interpolation_m,
                   .interpolation_displacement_m = budget.interpolation_displacement_m,
                   .interpolation_strain = budget.interpolation_strain};
    if (!(codec_error_m > 0))
        return error;
    const double sideways =
        std::numbers::sqrt2 * std::max(budget.choppiness.x, budget.choppiness.y);
    for (const CascadeBudget& cascade : budget.cascades) {
        const double of_map_m = sampled_error(budget, codec_error_m);
        error.codec_height_m += of_map_m;
        error.codec_displacement_m += sideways * of_map_m;
        error.codec_strain += sideways * sampled_slope_error(of_map_m, cascade.spacing_m);
    }
    return error;
}

} // namespace seaway::sea
