// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/point_question.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include "server/host/refusal.h"

namespace seaway::server {

Result<void> check_time(sea::TimeUs time_us) {
    if (sea::in_time_range(time_us))
        return {};
    return Error{Refusal::bad_value, fmt::format("time_us is {}, allowed are {} to {}", time_us,
                                                 -sea::time_us_max, sea::time_us_max)};
}

Result<void> check_point(const sea::QueryPoint& point) {
    for (const auto& [name, value] : {std::pair("x_m", point.x_m), std::pair("y_m", point.y_m)})
        if (std::isfinite(value) && std::abs(value) > sea::position_max_m)
            return Error{Refusal::bad_value,
                         fmt::format("{} is {}, allowed are {} to {}", name, value,
                                     -sea::position_max_m, sea::position_max_m)};
    return check_time(point.time_us);
}

PointQuestion::PointQuestion(std::vector<sea::QueryPoint> points, SurfaceUse use)
    : points_(std::move(points)), use_(use), order_(points_.size()), answers_(points_.size()) {
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    std::stable_sort(order_.begin(), order_.end(), [&](std::size_t a, std::size_t b) {
        return points_[a].time_us < points_[b].time_us;
    });
}

SliceOver over_after(std::chrono::steady_clock::duration time) {
    return [end = std::chrono::steady_clock::now() + time] {
        return std::chrono::steady_clock::now() >= end;
    };
}

void PointQuestion::sample(Surfaces& surfaces, const SliceOver& over, Make make) {
    if (complete())
        return;
    if (!surface_)
        surface_.emplace(next().time_us, use_);
    if (!surface_->surface() && !surfaces.work_on(*surface_, make))
        return;
    const sea::TimeUs end_us = surface_->end_us();
    SEAWAY_CHECK(next().time_us < end_us, "each slice brings a question nearer to its end");
    do
        put_some(*surface_->surface(), end_us);
    while (!complete() && next().time_us < end_us && !over());
    if (complete() || next().time_us >= end_us)
        surface_.reset();
}

void PointQuestion::put_some(const sea::Surface& surface, sea::TimeUs end_us) {
    // A slice is looked at after each of them: in seas that fold often some take 20 us.
    constexpr std::size_t most = 2 * sea::PointKernel::block;
    std::array<sea::QueryPoint, most> points;
    std::array<sea::Answer, most> answers;
    std::size_t count = 0;
    for (std::size_t i = done_count_; i < order_.size() && count < most; ++i) {
        points[count] = points_[order_[i]];
        if (points[count].time_us >= end_us)
            break;
        ++count;
    }
    surface.answer({points.data(), count}, {answers.data(), count});
    for (std::size_t i = 0; i < count; ++i)
        put(answers[i]);
}

void PointQuestion::sum_exactly(const SeaCourse& course, const SliceOver& over) {
    while (!complete()) {
        const sea::QueryPoint& point = next();
        if (!moment_ || moment_us_ != point.time_us) {
            moment_.reset(); // it refers to the sum
            exact_sea_ = course.sea_unless_making(course.window_at(point.time_us).epoch);
            awaits_sea_ = !exact_sea_;
            if (awaits_sea_)
                return;
            truth_ = exact_sea_->truth_at(point.time_us);
            moment_ = truth_->at_time(point.time_us);
            moment_us_ = point.time_us;
        }
        // A nanometre, and what rounding leaves of a coordinate far out.
        const double tolerance_m =
            1e-9 + 4e-16 * std::max(std::abs(point.x_m), std::abs(point.y_m));
        sea::Answer answer = sea::surface_at(point,
                                             {exact_sea_->choppiness_at(point.time_us), tolerance_m,
                                              fold_search(exact_sea_->budget)},
                                             *moment_);
        answer.error_m += tolerance_m;
        answer.flags |= sea::answer_exact;
        put(answer);
        if (over())
            return;
    }
}

} // namespace seaway::server
