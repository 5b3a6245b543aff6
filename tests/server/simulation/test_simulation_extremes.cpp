// SPDX-License-Identifier: Apache-2.0
// The simulation at the ends of every range, and beyond them: each question is answered or refused
// by name, and the next one is none the worse.
#include <cmath>
#include <limits>
#include <random>

#include <fmt/format.h>

#include "tests/server/simulation/simulation_bench.h"

namespace seaway::server {
namespace {

constexpr TimeUs lowest_us = std::numeric_limits<TimeUs>::min();
constexpr TimeUs highest_us = std::numeric_limits<TimeUs>::max();

TEST(SimulationExtremes, times_beyond_the_range_are_refused_by_name_and_nobody_else_notices) {
    Bench bench;
    const Demand demand{~0u, sea::surface_fields};
    for (const TimeUs time_us : {highest_us, lowest_us, sea::time_us_max + 1, -sea::time_us_max - 1,
                                 highest_us - 1'000'000, lowest_us + 1'000'000}) {
        const std::string value = fmt::format("time_us is {}", time_us);
        for (const bool exact : {false, true}) {
            const auto answers = bench.try_answer({{0, 0, 0}, {1.0, 2.0, time_us}}, exact);
            ASSERT_FALSE(answers);
            EXPECT_TRUE(answers.error().is(Refusal::bad_value));
            EXPECT_NE(answers.error().message.find(value), std::string::npos);
            EXPECT_NE(answers.error().message.find("1000000000000000000"), std::string::npos);
        }
        EXPECT_TRUE(bench.fetch({0, time_us}, demand).error().is(Refusal::bad_value));
        EXPECT_TRUE(bench.surface(time_us).error().is(Refusal::bad_value));
        EXPECT_EQ(bench.answer({{1.0, 2.0, 0}}).size(), 1u) << "the next one is served";
    }
}

TEST(SimulationExtremes, places_beyond_the_range_are_refused_by_name) {
    Bench bench;
    for (const double far_m : {std::nextafter(sea::position_max_m, 1e300), -1e10, 1e300, -1e308}) {
        EXPECT_NE(bench.try_answer({{far_m, 0, 0}}).error().message.find("x_m is"),
                  std::string::npos);
        EXPECT_NE(bench.try_answer({{0, far_m, 0}}, true).error().message.find("y_m is"),
                  std::string::npos);
        EXPECT_TRUE(bench.try_answer({{0, far_m, 0}}).error().is(Refusal::bad_value));
    }
}

TEST(SimulationExtremes, at_the_ends_of_the_ranges_and_anywhere_between_the_bound_is_kept) {
    Bench bench;
    const double nan = std::numeric_limits<double>::quiet_NaN();
    std::vector<TimeUs> times{
        0, 1, -1, sea::time_us_max, -sea::time_us_max, sea::time_us_max - 1, 1 - sea::time_us_max};
    std::vector<double> places_m{0,
                                 -0.0,
                                 5e-324,
                                 sea::position_max_m,
                                 -sea::position_max_m,
                                 std::nextafter(sea::position_max_m, 0),
                                 nan,
                                 std::numeric_limits<double>::infinity()};
    std::mt19937_64 numbers(11);
    for (int i = 0; i < 20; ++i) { // every power of ten alike
        const double share = static_cast<double>(numbers() >> 11) * 0x1p-53;
        const double sign = i % 2 ? 1 : -1;
        times.push_back(static_cast<TimeUs>(sign * std::pow(10.0, 18 * share)));
        places_m.push_back(sign * std::pow(10.0, 9 * share));
    }
    // The edges of keyframes, whose neighbours lie the furthest out.
    for (const sea::CascadeBudget& cascade : bench.sea->budget.cascades) {
        const TimeUs last = sea::time_us_max / cascade.interval_us * cascade.interval_us;
        times.insert(times.end(), {last, last - 1, last - 2, -last, 1 - last, 2 - last});
    }
    std::vector<sea::QueryPoint> points;
    for (const TimeUs time_us : times)
        for (int i = 0; i < 6; ++i)
            points.push_back({places_m[numbers() % places_m.size()],
                              places_m[numbers() % places_m.size()], time_us});
    const std::vector<sea::Answer> fast = bench.answer(points);
    const std::vector<sea::Answer> exact = bench.answer(points, true);
    ASSERT_EQ(fast.size(), points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto& [x_m, y_m, time_us] = points[i];
        if (!std::isfinite(x_m) || !std::isfinite(y_m)) {
            EXPECT_TRUE(fast[i].flags & sea::answer_invalid);
            EXPECT_TRUE(exact[i].flags & sea::answer_invalid);
            continue;
        }
        EXPECT_LE(std::abs(fast[i].height_m - exact[i].height_m),
                  fast[i].error_m + exact[i].error_m)
            << x_m << ", " << y_m << ", " << time_us;
        EXPECT_EQ(fast[i].flags & (sea::answer_invalid | sea::answer_extrapolated), 0u);
    }
}

TEST(SimulationExtremes, keyframes_and_surfaces_at_the_ends_of_time_hold_what_was_asked) {
    Bench bench("[foam]\nthreshold = 0.8\n");
    for (const TimeUs time_us : {sea::time_us_max, -sea::time_us_max}) {
        const auto held = bench.fetch({time_us}, {~0u, {Field::height, Field::foam}});
        ASSERT_TRUE(held);
        ASSERT_EQ(held->size(), 4u) << "two of each cascade";
        for (std::size_t i = 0; i < 4; i += 2) {
            EXPECT_LE((*held)[i]->time_us, time_us);
            EXPECT_GT((*held)[i + 1]->time_us, time_us);
            for (const float ratio : (*held)[i]->plane(Field::foam))
                ASSERT_TRUE(std::isfinite(ratio) && ratio >= 0);
        }
        const Result<SurfacePtr> surface = bench.surface(time_us);
        ASSERT_TRUE(surface);
        EXPECT_EQ((*surface)->answer({3, 4, time_us}).flags & sea::answer_extrapolated, 0u);
    }
}

} // namespace
} // namespace seaway::server
