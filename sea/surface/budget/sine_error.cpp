// SPDX-License-Identifier: Apache-2.0
#include "sea/surface/budget/sine_error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "sea/surface/budget/interpolation_laws.h"

namespace seaway::sea {

namespace {

constexpr int sample_count = 4096;
constexpr double margin = 1.25;
/// Of the largest of both together, which is of the samples alone: less, for each of the two has its own in it.
constexpr double together_margin = 1.18;
/// From so many of the largest errors that were met it goes uphill, in steps of radians of the shortest and of the fastest
/// wave.
constexpr int starts = 32;
constexpr int steps_max = 16;
constexpr double first_step = 0.25;
constexpr double last_step = 0.01;
constexpr double time_span_s = 1e4;
/// One wave is missed most in the middle; harmonics that turn once in half an interval beside it.
constexpr std::array shares_of_interval{0.25, 0.5, 0.75, 0.5};

/// Half the nodes that the spline at the middle of a cell is summed over: what lies further weighs
/// less than 3e-6.
constexpr int reach = 10;

/// Weight of the node n + 1/2 cells away in the cubic spline through the grid values: the B-spline
/// of the prefilter's answer to a single one (Unser 1999).
std::array<double, reach> cardinal_weights() {
    const double pole = std::sqrt(3.0) - 2.0;
    const auto coefficient = [&](int m) {
        return -6.0 * pole / (1.0 - pole * pole) * std::pow(pole, std::abs(m));
    };
    std::array<double, reach> weights{};
    for (int n = 0; n < reach; ++n)
        weights[static_cast<std::size_t>(n)] =
            23.0 / 48.0 * (coefficient(n) + coefficient(n + 1)) +
            1.0 / 48.0 * (coefficient(n - 1) + coefficient(n + 2));
    return weights;
}

struct Quickest {
    double wavenumber_radpm = 0;
    double omega_radps = 0;
};

/// Of all waves; of noise as sine_steps() counts it.
Quickest quickest_of(const SineField& field) {
    Quickest most;
    const auto count = [&](double wavenumber_radpm, double omega_radps) {
        most.wavenumber_radpm = std::max(most.wavenumber_radpm, wavenumber_radpm);
        most.omega_radps = std::max(most.omega_radps, std::abs(omega_radps));
    };
    for (const SineField::Wave& wave : field.waves)
        count(std::hypot(wave.kx_radpm, wave.ky_radpm), wave.omega_radps);
    for (const NoiseOctave& octave : field.octaves) {
        const double k = 4.0 * std::numbers::pi * octave.cells / field.length_m;
        count(k, k * std::hypot(octave.speed_x_mps, octave.speed_y_mps));
    }
    return most;
}

} // namespace

SineError::SineError(const SineField& field, double spacing_m) : field_(field) {
    // Multiples of irrational numbers modulo one: even in the plane and in time, and never in step
    // with a tile or a loop.
    const auto share = [](int i, double step) { return std::fmod(i * step, 1.0); };
    for (int i = 1; i <= sample_count; ++i)
        samples_.push_back({share(i, 0.8191725133961645) * field.length_m,
                            share(i, 0.6710436067037893) * field.length_m,
                            us_from_seconds(share(i, 0.5497004779019703) * time_span_s),
                            shares_of_interval[static_cast<std::size_t>(i % 4)]});
    const Quickest quickest = quickest_of(field);
    stride_m_ = 1.0 / quickest.wavenumber_radpm;
    omega_max_radps_ = quickest.omega_radps; // noise may stand still
    for (const Sample& s : samples_) {
        const LagrangianPoint truth = sines_at(field, s.x_m, s.y_m, s.time_us);
        slope_variance_ += truth.slope_x * truth.slope_x + truth.slope_y * truth.slope_y;
        const auto at = [&](double dx_m, double dy_m) {
            return sines_at(field, s.x_m + dx_m, s.y_m + dy_m, s.time_us);
        };
        const LagrangianPoint x = at(-spacing_m, 0), y = at(0, -spacing_m),
                              xy = at(-spacing_m, -spacing_m);
        const double detail = truth.height - x.height - y.height + xy.height;
        const double rate = truth.height_rate - x.height_rate - y.height_rate + xy.height_rate;
        detail_m2_ += detail * detail / sample_count;
        rate_detail_m2ps2_ += rate * rate / sample_count;
    }
    slope_variance_ /= sample_count;
    const auto east = [&](const Sample& s) { return spline_error_m(s, spacing_m, 0); };
    const auto north = [&](const Sample& s) { return spline_error_m(s, 0, spacing_m); };
    east_ = met(east);
    north_ = met(north);
    east_m_ = margin * largest(east_, east);
    north_m_ = margin * largest(north_, north);
}

template <class ErrorAt>
std::vector<SineError::Met> SineError::met(const ErrorAt& error_at) const {
    std::vector<Met> all;
    all.reserve(samples_.size() + shares_of_interval.size());
    for (const Sample& s : samples_)
        all.push_back({error_at(s), s});
    // Where the phases of a list are those that were given: waves of phase 0 all meet there.
    for (const double share : shares_of_interval) {
        const Sample origin{0, 0, 0, share};
        all.push_back({error_at(origin), origin});
    }
    return all;
}

/// Sharp crests are met beside their tops: from where errors are largest it goes on to where they are larger still.
template <class ErrorAt>
double SineError::largest(std::vector<Met> met, const ErrorAt& error_at) const {
    for (Met& one : met)
        one.error_m = std::abs(one.error_m);
    std::partial_sort(met.begin(), met.begin() + starts, met.end(),
                      [](const Met& a, const Met& b) { return a.error_m > b.error_m; });
    double largest_m = 0;
    for (int start = 0; start < starts; ++start) {
        Met best = met[static_cast<std::size_t>(start)];
        double step = first_step;
        for (int n = 0; n < steps_max && step > last_step; ++n) {
            const double metres = step * stride_m_;
            const TimeUs time_us =
                omega_max_radps_ > 0 ? us_from_seconds(step / omega_max_radps_) : 0;
            const Sample from = best.at;
            bool higher = false;
            const auto beside = [&](double dx_m, double dy_m, TimeUs later_us) {
                return Sample{from.x_m + dx_m, from.y_m + dy_m, from.time_us + later_us,
                              from.share};
            };
            for (const Sample& next :
                 {beside(-metres, 0, 0), beside(metres, 0, 0), beside(0, -metres, 0),
                  beside(0, metres, 0), beside(0, 0, -time_us), beside(0, 0, time_us)})
                if (const double error_m = std::abs(error_at(next)); error_m > best.error_m) {
                    best = {error_m, next};
                    higher = true;
                }
            if (!higher)
                step /= 2;
        }
        largest_m = std::max(largest_m, best.error_m);
    }
    return largest_m;
}

double SineError::spline_error_m(const Sample& s, double dx_m, double dy_m) const {
    static const std::array<double, reach> weights = cardinal_weights();
    double sum = 0;
    for (int n = 0; n < reach; ++n)
        for (const double side : {-1.0, 1.0}) {
            const double cells = side * (n + 0.5);
            sum += weights[static_cast<std::size_t>(n)] *
                   sines_at(field_, s.x_m + cells * dx_m, s.y_m + cells * dy_m, s.time_us).height;
        }
    return sum - sines_at(field_, s.x_m, s.y_m, s.time_us).height;
}

double SineError::hermite_error_m(const Sample& s, TimeUs interval_us) const {
    const auto between_us = static_cast<TimeUs>(s.share * static_cast<double>(interval_us));
    const TimeUs before_us = s.time_us - between_us;
    const LagrangianPoint before = sines_at(field_, s.x_m, s.y_m, before_us);
    const LagrangianPoint after = sines_at(field_, s.x_m, s.y_m, before_us + interval_us);
    const LagrangianPoint between = sines_at(field_, s.x_m, s.y_m, s.time_us);
    const double x = static_cast<double>(between_us) / static_cast<double>(interval_us);
    const double r = 1.0 - x;
    const double hermite_m =
        r * r * (1.0 + 2.0 * x) * before.height + x * x * (1.0 + 2.0 * r) * after.height +
        seconds_from_us(interval_us) * x * r * (r * before.height_rate - x * after.height_rate);
    return hermite_m - between.height;
}

/// By the largest of t, of x and y together, and of all three, of either sign, since nearer to grid points and keyframes each of them is less:
/// all^2 = t^2 + (x + y)^2 + 2 c t (x + y).
double SineError::agrees(const std::vector<Met>& in_time) const {
    double time_m = 0, space_m = 0, all_m = 0;
    for (std::size_t i = 0; i < in_time.size(); ++i)
        for (const double sign : {-1.0, 1.0}) {
            const auto part = [sign](const Met& met) { return std::max(sign * met.error_m, 0.0); };
            const double t = part(in_time[i]), space = part(east_[i]) + part(north_[i]);
            time_m = std::max(time_m, t);
            space_m = std::max(space_m, space);
            all_m = std::max(all_m, t + space);
        }
    const double product_m2 = 2.0 * time_m * space_m;
    const double together_m = together_margin / margin * all_m;
    if (!(product_m2 > 0))
        return 0;
    return std::clamp((square(together_m) - square(time_m) - square(space_m)) / product_m2, 0.0,
                      1.0);
}

SineError::Time SineError::time(TimeUs interval_us, TimeUs glide_us) const {
    const double u = omega_max_radps_ * seconds_from_us(interval_us);
    const auto error_at = [&](const Sample& s) { return hermite_error_m(s, interval_us); };
    const std::vector<Met> in_time = met(error_at);
    Time time{margin * largest(in_time, error_at), agrees(in_time)};
    if (u > hermite_phase_max)
        time.missed_m = std::max(time.missed_m, sine_height_max_m(field_) * hermite_error(u));
    if (glide_us > 0) {
        const double q = static_cast<double>(interval_us) / static_cast<double>(glide_us);
        time.missed_m += sine_height_max_m(field_) * (gliding_error(u, q) - hermite_error(u));
    }
    return time;
}

} // namespace seaway::sea
