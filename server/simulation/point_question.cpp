// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/point_question.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "sea/surface/below.h"
#include "sea/surface/by_time.h"
#include "server/host/refusal.h"

namespace seaway::server {

namespace {

/// Answered between two looks at the clock.
constexpr std::size_t points_at_once_min = 2 * sea::PointBlock::size;
constexpr std::size_t points_at_once_max = 16 * sea::PointBlock::size;

} // namespace

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

std::uint32_t felt_cascades(const sea::Realization& sea, const sea::Looking& looking) {
    std::uint32_t felt = 0;
    bool all = true;
    for (std::size_t c = 0; c < sea.cascades.size(); ++c)
        if (looking.feels(c, sea.cascades[c].longest_radpm()))
            felt |= 1u << c;
        else
            all = false;
    return all ? sea::all_cascades : felt;
}

std::uint32_t felt_cascades(const SeaCourse& course, std::span<const sea::QueryPoint> points,
                            const sea::Looking& looking) {
    const sea::TimeUs given_us = course.gives_waves_from_us();
    sea::Looking by = looking;
    if (std::ranges::any_of(
            points, [&](const sea::QueryPoint& point) { return point.time_us >= given_us; }))
        by.min_wavelength_m = 0;
    return felt_cascades(*course.first()->realization, by);
}

PointQuestion::PointQuestion(PointsAsked asked, SurfaceUse use, std::uint32_t cascades)
    : asked_(std::move(asked)), use_(use), cascades_(cascades),
      order_(sea::order_by_time(asked_.points)) {
    SEAWAY_CHECK(asked_.z_m.empty() || asked_.z_m.size() == asked_.points.size(),
                 "a depth a point, or none");
    answered_.answers.resize(asked_.points.size());
    answered_.below.resize(asked_.z_m.size());
}

SliceOver over_after(std::chrono::steady_clock::duration time) {
    return [end = std::chrono::steady_clock::now() + time] {
        return std::chrono::steady_clock::now() >= end;
    };
}

void PointQuestion::sample(Surfaces& surfaces, const SliceOver& over, Make make) {
    if (cascades_ == 0)
        lie_flat();
    if (complete())
        return;
    if (!surface_)
        surface_.emplace(next().time_us, use_, cascades_);
    if (!surface_->surface() && !surfaces.work_on(*surface_, make))
        return;
    const sea::TimeUs end_us = surface_->end_us();
    SEAWAY_CHECK(next().time_us < end_us, "each slice brings a question nearer to its end");
    // A slice is looked at after each of them, and each is as long as all before: in seas that fold often some points take
    // 20 us, elsewhere what a batch costs beside its points is shared by more of them.
    std::size_t some = points_at_once_min;
    do {
        put_some(*surface_->surface(), end_us, some);
        some = std::min(2 * some, points_at_once_max);
    } while (!complete() && next().time_us < end_us && !over());
    if (complete() || next().time_us >= end_us)
        surface_.reset();
}

void PointQuestion::put_some(const sea::Surface& surface, sea::TimeUs end_us, std::size_t most) {
    std::array<sea::QueryPoint, points_at_once_max> points;
    std::array<sea::Answer, points_at_once_max> answers;
    std::size_t count = 0;
    for (std::size_t i = done_count_; i < order_.size() && count < most; ++i) {
        points[count] = asked_.points[order_[i]];
        if (points[count].time_us >= end_us)
            break;
        ++count;
    }
    surface.answer({points.data(), count}, {answers.data(), count});
    for (std::size_t i = 0; i < count; ++i)
        put(answers[i]);
}

void PointQuestion::lie_flat() {
    while (!complete()) {
        const sea::QueryPoint& point = next();
        const bool known = std::isfinite(point.x_m) && std::isfinite(point.y_m);
        put(known ? sea::Answer{} : sea::invalid_answer());
    }
}

void PointQuestion::let_go_waves() {
    moment_.reset(); // it refers to the sum
    truth_.reset();
    moment_place_.reset();
    truth_place_.reset();
}

bool PointQuestion::take_waves(const SeaCourse& course, sea::TimeUs time_us) {
    let_go_waves();
    const RunningSeaPtr sea = course.sea_unless_making(course.window_at(time_us).epoch);
    awaits_sea_ = !sea;
    if (awaits_sea_)
        return false;
    truth_ = sea->truth_at(time_us);
    moment_ = truth_->at_time(time_us, cascades_);
    moment_us_ = time_us;
    choppiness_ = sea->choppiness_at(time_us);
    folds_ = fold_search(sea->budget);
    return true;
}

void PointQuestion::sum_exactly(const SeaCourse& course, const SliceOver& over, SumsRoom& sums) {
    while (!complete()) {
        const sea::QueryPoint& point = next();
        if ((!moment_ || moment_us_ != point.time_us) && !take_waves(course, point.time_us))
            return;
        put(exactly(point));
        if (over())
            break;
    }
    if (!complete() && !moment_place_) {
        const bool stays = truth_ == course.first()->truth;
        truth_place_ = stays ? nullptr : sums.take(truth_);
        if (stays || truth_place_)
            moment_place_ = sums.take(moment_->bytes());
    }
    if (complete() || !moment_place_)
        let_go_waves();
}

sea::Answer PointQuestion::exactly(const sea::QueryPoint& point) {
    const double tolerance_m = sea::exact_tolerance_m(point);
    const sea::InverseOptions options{choppiness_, tolerance_m, folds_};
    const std::size_t at = order_[done_count_];
    sea::Answer answer = asked_.z_m.empty() ? sea::surface_at(point, options, *moment_)
                                            : sea::water_at(point, asked_.z_m[at], options,
                                                            *moment_, answered_.below[at]);
    answer.error_m += tolerance_m;
    answer.flags |= sea::answer_exact;
    return answer;
}

} // namespace seaway::server
