// SPDX-License-Identifier: Apache-2.0
#include "sea/surface/surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "sea/surface/maps/hermite.h"
#include "sea/surface/surface_sheets.h"

namespace seaway::sea {

namespace {

void add(LagrangianPoint& sum, const HermiteWeights& weights, const SplineSample& a,
         const SplineSample& b) {
    using spline_channel::height, spline_channel::displacement_x, spline_channel::displacement_y,
        spline_channel::rate;
    using Channels = float[spline_channel::count];
    const auto mix = [](const double(&w)[4], const Channels& pa, const Channels& pb, int c) {
        return w[0] * static_cast<double>(pa[c]) + w[1] * static_cast<double>(pa[c + rate]) +
               w[2] * static_cast<double>(pb[c]) + w[3] * static_cast<double>(pb[c + rate]);
    };
    sum.height += mix(weights.value, a.value, b.value, height);
    sum.displacement_x += mix(weights.value, a.value, b.value, displacement_x);
    sum.displacement_y += mix(weights.value, a.value, b.value, displacement_y);
    sum.height_rate += mix(weights.rate, a.value, b.value, height);
    sum.displacement_x_rate += mix(weights.rate, a.value, b.value, displacement_x);
    sum.displacement_y_rate += mix(weights.rate, a.value, b.value, displacement_y);
    sum.slope_x += mix(weights.value, a.d_dx, b.d_dx, height);
    sum.slope_y += mix(weights.value, a.d_dy, b.d_dy, height);
    sum.strain_xx += mix(weights.value, a.d_dx, b.d_dx, displacement_x);
    sum.strain_yy += mix(weights.value, a.d_dy, b.d_dy, displacement_y);
    sum.strain_xy += 0.5 * (mix(weights.value, a.d_dy, b.d_dy, displacement_x) +
                            mix(weights.value, a.d_dx, b.d_dx, displacement_y));
}

double interval_s(const SplinePair& pair) {
    return seconds_from_us(pair.after->time_us() - pair.before->time_us());
}

} // namespace

Surface::Surface(std::vector<SplinePair> pairs, Choppiness choppiness, FoldSearch folds,
                 MapError error, double tolerance_m)
    : pairs_(std::move(pairs)), choppiness_(choppiness), folds_(folds), error_(std::move(error)),
      tolerance_m_(tolerance_m), sideways_(std::max(choppiness.x, choppiness.y)) {
    SEAWAY_CHECK(pairs_.size() <= surface_pairs_max, "a surface has 16 cascades at most");
    SEAWAY_CHECK(error_.cascades.empty() || error_.cascades.size() == pairs_.size(),
                 "one loss a cascade");
    for (const SplinePair& pair : pairs_) {
        SEAWAY_CHECK(pair.before && pair.after, "a surface needs both maps of every cascade");
        SEAWAY_CHECK(pair.before->size() == pair.after->size(), "a pair is of one cascade");
        moves_sideways_ =
            moves_sideways_ && pair.before->moves_sideways() && pair.after->moves_sideways();
    }
    double displacement_m2 = 0;
    for (std::size_t c = 0; c < error_.cascades.size(); ++c)
        displacement_m2 +=
            error_.cascades[c].displacement.largest_variance_m2(interval_s(pairs_[c]));
    fold_blur_m_ =
        sideways_ * (fold_sigmas * std::sqrt(displacement_m2) + error_.displacement_bound_m);
    fold_strain_blur_ = sideways_ * error_.strain_bound + error_.codec_strain_bound;
}

double Surface::height_bound_m(double slope) const {
    const double sideways = slope * sideways_;
    double variance_m2 = 0;
    for (std::size_t c = 0; c < error_.cascades.size(); ++c) {
        const CascadeLoss& loss = error_.cascades[c];
        variance_m2 +=
            loss.height.largest_variance_m2(interval_s(pairs_[c])) +
            sideways * sideways * loss.displacement.largest_variance_m2(interval_s(pairs_[c]));
    }
    return bound_sigmas * std::sqrt(variance_m2) + error_.height_bound_m +
           sideways * error_.displacement_bound_m;
}

double Surface::height_bound_m(Vec2 lagrangian, TimeUs time_us, double slope) const {
    const double sideways = slope * sideways_;
    const auto between = [](double cells) { return between_samples(cells - std::floor(cells)); };
    double variance_m2 = 0;
    for (std::size_t c = 0; c < error_.cascades.size(); ++c) {
        const SplinePair& pair = pairs_[c];
        const TimeUs start_us = pair.before->time_us();
        const double interval = interval_s(pair);
        const double share = interval > 0 ? seconds_from_us(time_us - start_us) / interval : 0.0;
        const HermiteWeights weights = hermite_weights(start_us, pair.after->time_us(), time_us);
        const double cells_a_metre = pair.before->size() / pair.before->length_m();
        const double east = between(lagrangian.x * cells_a_metre);
        const double north = between(lagrangian.y * cells_a_metre);
        const CascadeLoss& loss = error_.cascades[c];
        variance_m2 +=
            loss.height.variance_m2(share, east, north, weights) +
            sideways * sideways * loss.displacement.variance_m2(share, east, north, weights);
    }
    return bound_sigmas * std::sqrt(variance_m2) + error_.height_bound_m +
           sideways * error_.displacement_bound_m;
}

LagrangianPoint Surface::at(double x_m, double y_m, TimeUs time_us) const {
    struct Cells {
        SplineMap::Cell before;
        SplineMap::Cell after;
    };
    std::array<Cells, surface_pairs_max> cells;
    for (std::size_t c = 0; c < pairs_.size(); ++c)
        cells[c] = {pairs_[c].before->cell(x_m, y_m), pairs_[c].after->cell(x_m, y_m)};
    LagrangianPoint sum;
    for (std::size_t c = 0; c < pairs_.size(); ++c) {
        const SplinePair& pair = pairs_[c];
        const HermiteWeights weights =
            hermite_weights(pair.before->time_us(), pair.after->time_us(), time_us);
        const SplineSample before = pair.before->sample(cells[c].before);
        const bool single = pair.before == pair.after;
        add(sum, weights, before, single ? before : pair.after->sample(cells[c].after));
    }
    return sum;
}

bool Surface::covers(TimeUs time_us) const {
    return std::all_of(pairs_.begin(), pairs_.end(), [&](const SplinePair& pair) {
        return pair.before->time_us() <= time_us && time_us <= pair.after->time_us();
    });
}

Answer Surface::answer(const QueryPoint& point) const {
    const InverseOptions options{choppiness_, tolerance_m_, folds_};
    const auto field = [&](double x_m, double y_m) { return at(x_m, y_m, point.time_us); };
    SurfaceSheets sheets(*this, point.time_us);
    Vec2 lagrangian{point.x_m, point.y_m};
    Answer answer = surface_at(point, options, field, &sheets, &lagrangian);
    if (answer.flags & answer_invalid)
        return answer;
    answer.error_m += height_bound_m(lagrangian, point.time_us, surface_slope(answer));
    if (!covers(point.time_us))
        answer.flags |= answer_extrapolated;
    if (!moves_sideways_)
        answer.flags |= answer_vertical_velocity;
    return answer;
}

void Surface::answer(std::span<const QueryPoint> points, std::span<Answer> answers) const {
    SEAWAY_CHECK(points.size() == answers.size(), "one answer a point");
    for (std::size_t i = 0; i < points.size(); ++i)
        answers[i] = answer(points[i]);
}

} // namespace seaway::sea
