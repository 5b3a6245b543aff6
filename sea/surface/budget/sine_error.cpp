// SPDX-License-Identifier: Apache-2.0
#include "sea/surface/budget/sine_error.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace seaway::sea {

namespace {

constexpr int sample_count = 4096;
constexpr double margin = 1.75;
constexpr double time_span_s = 1e4;

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

} // namespace

SineError::SineError(const SineField& field, double spacing_m) : field_(field) {
    // Multiples of irrational numbers modulo one: even in the plane and in time, and never in step
    // with a tile or a loop.
    const auto share = [](int i, double step) { return std::fmod(i * step, 1.0); };
    for (int i = 1; i <= sample_count; ++i)
        samples_.push_back({share(i, 0.8191725133961645) * field.length_m,
                            share(i, 0.6710436067037893) * field.length_m,
                            us_from_seconds(share(i, 0.5497004779019703) * time_span_s)});
    for (const Sample& s : samples_) {
        const LagrangianPoint truth = sines_at(field, s.x_m, s.y_m, s.time_us);
        east_m_ = std::max(east_m_, margin * spline_error_m(s, spacing_m, 0, truth.height));
        north_m_ = std::max(north_m_, margin * spline_error_m(s, 0, spacing_m, truth.height));
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
}

double SineError::spline_error_m(const Sample& s, double dx_m, double dy_m, double truth_m) const {
    static const std::array<double, reach> weights = cardinal_weights();
    double sum = 0;
    for (int n = 0; n < reach; ++n)
        for (const double side : {-1.0, 1.0}) {
            const double cells = side * (n + 0.5);
            sum += weights[static_cast<std::size_t>(n)] *
                   sines_at(field_, s.x_m + cells * dx_m, s.y_m + cells * dy_m, s.time_us).height;
        }
    return std::abs(sum - truth_m);
}

double SineError::time_m(TimeUs interval_us) const {
    const double interval_s = seconds_from_us(interval_us);
    double largest_m = 0;
    for (const Sample& s : samples_) {
        const LagrangianPoint before = sines_at(field_, s.x_m, s.y_m, s.time_us);
        const LagrangianPoint middle = sines_at(field_, s.x_m, s.y_m, s.time_us + interval_us / 2);
        const LagrangianPoint after = sines_at(field_, s.x_m, s.y_m, s.time_us + interval_us);
        const double hermite_m = 0.5 * (before.height + after.height) +
                                 0.125 * interval_s * (before.height_rate - after.height_rate);
        largest_m = std::max(largest_m, std::abs(hermite_m - middle.height));
    }
    return margin * largest_m;
}

} // namespace seaway::sea
