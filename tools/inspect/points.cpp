// SPDX-License-Identifier: Apache-2.0
#include "tools/inspect/points.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "sea/surface/by_time.h"
#include "sea/surface/inverse.h"
#include "sea/waves/reference.h"

namespace seaway::inspect {

namespace {

constexpr double tolerance_m = 1e-9;
/// Rounding of the direct sum, as a share of the sum of all amplitudes (sea/waves/reference.h).
constexpr double sum_rounding = 1e-13;

double sum_of_amplitudes(const sea::Realization& sea) {
    double sum = 0.0;
    for (const sea::CascadeModes& cascade : sea.cascades) {
        for (const std::complex<double> h0 : cascade.h0)
            sum += 2.0 * std::abs(h0);
        for (const sea::SineField& field : cascade.sines)
            sum += sine_height_max_m(field);
    }
    return sum;
}

} // namespace

std::vector<sea::Answer> answer_points(const sea::RealizationPtr& sea, const sea::FoldSearch& folds,
                                       const std::vector<sea::QueryPoint>& points) {
    // By time, so that each moment is built once, whatever the order of the rows.
    const std::vector<std::size_t> order = sea::order_by_time(points);
    const sea::DirectSum sum(sea);
    const double rounding_m = sum_rounding * sum_of_amplitudes(*sea);
    std::vector<sea::Answer> answers(points.size());
    std::optional<sea::DirectSum::Moment> moment;
    for (std::size_t i = 0; i < order.size(); ++i) {
        const sea::QueryPoint& point = points[order[i]];
        if (i == 0 || point.time_us != points[order[i - 1]].time_us)
            moment = sum.at_time(point.time_us);
        // Far out, coordinates themselves are rounded to more than the tolerance.
        const double rounded_to_m = std::numeric_limits<double>::epsilon() *
                                    std::max(std::abs(point.x_m), std::abs(point.y_m));
        const sea::InverseOptions options{sea->choppiness,
                                          std::max(tolerance_m, 4.0 * rounded_to_m), folds};
        sea::Answer& answer = answers[order[i]];
        answer = surface_at(point, options, *moment);
        answer.flags |= sea::answer_exact;
        answer.error_m += rounding_m + 2.0 * rounded_to_m * surface_slope(answer);
    }
    return answers;
}

} // namespace seaway::inspect
