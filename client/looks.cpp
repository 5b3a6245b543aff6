// SPDX-License-Identifier: Apache-2.0
#include "client/looks.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "client/link/failure.h"

namespace seaway::client {

using sea::LagrangianPoint;
using sea::Vec2;

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// The smaller singular value of I + lambda grad D: displacements are as wrong as maps, over this.
double smallest_stretch(const LagrangianPoint& p, const sea::Choppiness& choppiness) {
    const double a = 1 + choppiness.x * p.strain_xx, b = choppiness.x * p.strain_xy;
    const double c = choppiness.y * p.strain_xy, d = 1 + choppiness.y * p.strain_yy;
    const double sum = a * a + b * b + c * c + d * d, det = a * d - b * c;
    return std::sqrt(
        std::max(0.0, 0.5 * (sum - std::sqrt(std::max(0.0, sum * sum - 4 * det * det)))));
}

/// Below this, first order says nothing.
constexpr double about_to_fold = 0.1;

/// Newton from a given start; nothing: it does not get there.
std::optional<Vec2> solve_from(Vec2 at, Vec2 target, const sea::InverseOptions& options,
                               const sea::LagrangianField& field) {
    constexpr int steps_max = 30;
    for (int step = 0; step < steps_max; ++step) {
        const LagrangianPoint p = field(at.x, at.y);
        const sea::Choppiness& l = options.choppiness;
        const double rx = at.x + l.x * p.displacement_x - target.x;
        const double ry = at.y + l.y * p.displacement_y - target.y;
        if (std::hypot(rx, ry) <= options.tolerance_m)
            return at;
        const double a = 1 + l.x * p.strain_xx, b = l.x * p.strain_xy;
        const double c = l.y * p.strain_xy, d = 1 + l.y * p.strain_yy;
        const double det = a * d - b * c;
        if (std::abs(det) < 1e-9)
            return std::nullopt;
        const double dx = (d * rx - b * ry) / det, dy = (a * ry - c * rx) / det;
        const double shorter =
            std::min(1.0, 0.25 * options.folds.reach_m / std::max(std::hypot(dx, dy), 1e-12));
        at = {at.x - shorter * dx, at.y - shorter * dy};
    }
    return std::nullopt;
}

/// Where the sheet of an answer lay before it was moved.
std::optional<Vec2> place_of(const sea::QueryPoint& point, const sea::InverseOptions& options,
                             const sea::LagrangianField& field, const sea::Answer& answer) {
    const Vec2 target{point.x_m, point.y_m};
    const double height_off_m = std::max(answer.error_m, 1e-6);
    std::optional<Vec2> best;
    double best_off_m = height_off_m;
    const auto look = [&](Vec2 start) {
        const std::optional<Vec2> found = solve_from(start, target, options, field);
        const double off_m =
            found ? std::abs(field(found->x, found->y).height - answer.height_m) : nan;
        if (off_m <= best_off_m) {
            best = found;
            best_off_m = off_m;
        }
    };
    look(target);
    constexpr int ways = 4; // on each side
    if (best && !(answer.flags & sea::answer_folded))
        return best;
    for (int y = -ways; y <= ways; ++y)
        for (int x = -ways; x <= ways; ++x)
            look({target.x + options.folds.reach_m * x / ways,
                  target.y + options.folds.reach_m * y / ways});
    return best;
}

} // namespace

std::uint32_t felt_cascades(const SeaState& state, const Looking& looking) {
    std::uint32_t felt = 0;
    for (std::size_t c = 0; c < state.cascades.size(); ++c)
        if (looking.feels(c, state.longest_radpm(c)))
            felt |= 1u << c;
    return felt;
}

Result<void> check_cascades(const SeaState& state, const Looking& looking) {
    const std::size_t count = state.cascades.size();
    if ((looking.cascades & ((1u << count) - 1)) != 0)
        return {};
    return failed(Failure::bad_argument,
                  looking.cascades == 0
                      ? std::string("no cascade is chosen")
                      : fmt::format("there is no cascade {}; the sea has {}, from 0 on",
                                    std::countr_zero(looking.cascades), count));
}

void lie_flat(std::span<const sea::QueryPoint> points, std::span<sea::Answer> answers,
              std::span<sea::ErrorTerms> terms) {
    for (std::size_t i = 0; i < points.size(); ++i) {
        const bool is_water = std::isfinite(points[i].x_m) && std::isfinite(points[i].y_m);
        answers[i] = is_water ? sea::Answer{} : sea::invalid_answer();
    }
    std::ranges::fill(terms, sea::ErrorTerms{});
}

std::optional<Vec2> put_movement(const sea::QueryPoint& point, const sea::InverseOptions& options,
                                 sea::LagrangianField field, double blur_m, Water& water) {
    std::optional<Vec2> place;
    if (!(water.answer.flags & sea::answer_invalid))
        place = place_of(point, options, field, water.answer);
    if (!place) {
        water.displacement_m[0] = water.displacement_m[1] = water.jacobian = nan;
        water.displacement_error_m = std::numeric_limits<double>::infinity();
        return place;
    }
    const LagrangianPoint p = field(place->x, place->y);
    water.displacement_m[0] = options.choppiness.x * p.displacement_x;
    water.displacement_m[1] = options.choppiness.y * p.displacement_y;
    water.jacobian = sea::jacobian(p, options.choppiness);
    const double stretch = smallest_stretch(p, options.choppiness);
    const bool open = stretch < about_to_fold || (water.answer.flags & sea::answer_folded);
    water.displacement_error_m =
        open ? std::numeric_limits<double>::infinity() : (blur_m + options.tolerance_m) / stretch;
    return place;
}

double foam_ratio(const KeyframePair& pair, sea::TimeUs time_us, Vec2 place_m) {
    const auto of = [&](const HeldKeyframe& held) {
        const sea::Keyframe& map = held.keyframe();
        const std::span<const float> plane = map.plane(sea::Field::foam);
        const auto cell = [&](double at_m) {
            const double at = at_m / map.length_m;
            return (at - std::floor(at)) * map.size;
        };
        const double x = cell(place_m.x), y = cell(place_m.y);
        const double fx = x - std::floor(x), fy = y - std::floor(y);
        const auto texel = [&](int dx, int dy) {
            const int ix = (static_cast<int>(x) + dx) % map.size;
            const int iy = (static_cast<int>(y) + dy) % map.size;
            return static_cast<double>(plane[static_cast<std::size_t>(iy * map.size + ix)]);
        };
        return (1 - fy) * ((1 - fx) * texel(0, 0) + fx * texel(1, 0)) +
               fy * ((1 - fx) * texel(0, 1) + fx * texel(1, 1));
    };
    const sea::TimeUs before_us = pair.before->keyframe().time_us;
    const sea::TimeUs span_us = pair.after->keyframe().time_us - before_us;
    const double share =
        span_us > 0
            ? std::clamp(static_cast<double>(time_us - before_us) / static_cast<double>(span_us),
                         0.0, 1.0)
            : 0.0;
    return (1 - share) * of(*pair.before) + share * of(*pair.after);
}

HeldFoam::HeldFoam(const SeaState& state, const KeyframeRing& ring, sea::TimeUs time_us)
    : time_us_(time_us), mean_(state.foam_mean_at(time_us)) {
    for (std::size_t c = 0; c < state.cascades.size(); ++c) {
        std::optional<KeyframePair> pair =
            ring.around(static_cast<int>(c), state.epoch, time_us, state.cascades[c].interval_us,
                        {sea::Field::foam});
        if (!pair)
            continue;
        beyond_ = beyond_ || !pair->covers; // what was white stays so
        pairs_.push_back(std::move(*pair));
    }
}

double HeldFoam::at(Vec2 place_m) const {
    if (pairs_.empty())
        return nan;
    double product = 2;
    for (const KeyframePair& pair : pairs_)
        product *= 0.5 * (1 + foam_ratio(pair, time_us_, place_m));
    // 2 product (1 + r) / 2 - 1 of docs/foam.md: cascades that are not held count as 1.
    return std::clamp(mean_ * (product - 1), 0.0, 1.0);
}

} // namespace seaway::client
