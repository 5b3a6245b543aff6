// SPDX-License-Identifier: Apache-2.0
// What an answer's error is made of (sea/surface/answer.h): each cause alone, against what it claims.
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "sea/surface/budget/error_budget.h"
#include "sea/surface/surface.h"
#include "tests/support/explicit_sea.h"

namespace seaway::sea {
namespace {

/// Many waves, so that what they miss is normal, moved straight up and down: a place is where its water is.
RealizationPtr upright_sea() {
    return tests::make_sea({tests::random_cascade(300.0, 64, 12, 300, 0.004, 11)}, {0, 0});
}

class Terms : public ::testing::Test {
  protected:
    const RealizationPtr sea = upright_sea();
    const DirectSum sum{sea};
    const ErrorBudget budget = plan_budget(*sea, 0.01);
    const TimeUs interval_us = budget.cascades[0].interval_us;
    const double spacing_m = sea->cascades[0].spec.spacing_m();

    Surface surface(const KeyframePtr& before, const KeyframePtr& after, const MapError& error) {
        return Surface(
            {{std::make_shared<SplineMap>(*before), std::make_shared<SplineMap>(*after)}},
            sea->choppiness, {.reach_m = 1.0}, error);
    }
    Surface exact() {
        return surface(tests::exact_keyframe(sea, 0, 0), tests::exact_keyframe(sea, 0, interval_us),
                       map_error(budget, 0));
    }
    struct Found {
        std::vector<Answer> answers;
        std::vector<ErrorTerms> terms;
    };
    static Found ask(const Surface& of, const std::vector<QueryPoint>& points) {
        Found found{std::vector<Answer>(points.size()), std::vector<ErrorTerms>(points.size())};
        of.answer(points, found.answers, {.terms = found.terms});
        return found;
    }
    /// Every error is within what `stated` says of its cause, and that is not empty: the largest is a third of it or more.
    /// Of as many normal errors none in a million is beyond five deviations, and the largest of 2000 has three.
    template <class Truth, class Stated>
    static void expect_true(const Found& found, const std::vector<QueryPoint>& points,
                            const Truth& truth, const Stated& stated) {
        double largest = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const double off_m = std::abs(found.answers[i].height_m - truth(i));
            EXPECT_LE(off_m,
                      stated(found.terms[i]) + found.terms[i].rounding_m + found.terms[i].inverse_m)
                << i;
            if (stated(found.terms[i]) > 0)
                largest = std::max(largest, off_m / stated(found.terms[i]));
        }
        EXPECT_GT(largest, 1.0 / 3);
    }
};

TEST_F(Terms, add_up_to_the_error_of_every_answer_found_at_once_or_carefully) {
    const RealizationPtr moved = tests::make_sea({tests::random_cascade(200.0, 64, 8, 30, 0.15, 1)},
                                                 {0.8, 1.4}); // folds here and there
    MapError error;
    error.cascades.push_back(
        {{0.001, 0.002, 0.003, 0.004, 0.05, 0.0007}, {0.006, 0.007, 0.008, 0.009, 0.01}});
    error.height_bound_m = 0.0001;
    error.displacement_bound_m = 0.0002;
    const Surface of({{std::make_shared<SplineMap>(*tests::exact_keyframe(moved, 0, 0)),
                       std::make_shared<SplineMap>(*tests::exact_keyframe(moved, 0, 200'000))}},
                     moved->choppiness, {.reach_m = 20.0}, error);
    std::vector<QueryPoint> points;
    for (int i = 0; i < 500; ++i)
        points.push_back({1.37 * i, -2.9 * i, i * 400});
    points.push_back({std::nan(""), 0, 0});
    const Found found = ask(of, points);
    std::vector<Answer> alone(points.size());
    of.answer(points, alone);
    bool folded = false, single = false;
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
        const ErrorTerms& terms = found.terms[i];
        EXPECT_EQ(found.answers[i].error_m, alone[i].error_m)
            << "that terms are wished for changes nothing";
        // Sums of the same numbers in another order.
        EXPECT_NEAR(terms.sum_m(), found.answers[i].error_m, 1e-14 * terms.sum_m()) << i;
        EXPECT_GT(terms.codec_m, 0);
        EXPECT_GT(terms.space_m, 0);
        EXPECT_GT(terms.rounding_m, 0);
        EXPECT_EQ(terms.clock_m, 0);
        EXPECT_EQ(terms.stale_m, 0);
        folded = folded || (found.answers[i].flags & answer_folded);
        single = single || found.answers[i].flags == 0;
    }
    EXPECT_TRUE(folded && single) << "both ways are tried";
    EXPECT_EQ(found.terms.back().sum_m(), 0) << "nothing is said of what is no point";
    EXPECT_TRUE(std::isnan(found.answers.back().error_m));
}

TEST_F(Terms, of_time_alone_are_true_at_grid_points) {
    std::vector<QueryPoint> points;
    std::mt19937 random(3);
    std::uniform_int_distribution<int> node(0, 63);
    std::uniform_int_distribution<TimeUs> time(0, interval_us);
    for (int i = 0; i < 2000; ++i)
        points.push_back({node(random) * spacing_m, node(random) * spacing_m, time(random)});
    const Found found = ask(exact(), points);
    for (const ErrorTerms& terms : found.terms) {
        EXPECT_LT(terms.space_m, 1e-9); // a node is met to what a double resolves
        EXPECT_EQ(terms.codec_m, 0);
    }
    expect_true(
        found, points,
        [&](std::size_t i) {
            return sum.at(points[i].x_m, points[i].y_m, points[i].time_us).height;
        },
        [](const ErrorTerms& terms) { return terms.time_m; });
}

// Naive: between one keyframe and itself no time has passed, whatever the time is.
TEST_F(Terms, of_one_keyframe_alone_grow_with_the_time_from_it) {
    const KeyframePtr one = tests::exact_keyframe(sea, 0, 0);
    std::vector<QueryPoint> points;
    for (const TimeUs time_us : {0, 20'000, 50'000, 100'000, 1'000'000})
        points.push_back({3, 4, time_us});
    const Found after = ask(surface(one, one, map_error(budget, 0)), points);
    const Found between = ask(exact(), {{3, 4, interval_us / 2}});
    EXPECT_EQ(after.terms[0].time_m, 0);
    for (std::size_t i = 1; i < 4; ++i)
        EXPECT_GT(after.terms[i].time_m, after.terms[i - 1].time_m) << i;
    EXPECT_GT(after.terms[3].time_m, 3 * between.terms[0].time_m);
    EXPECT_EQ(after.terms[4].time_m, after.terms[3].time_m)
        << "where it stands it is off by no more";
    for (QueryPoint& point : points)
        point.time_us *= -1;
    const Found before = ask(surface(one, one, map_error(budget, 0)), points);
    for (std::size_t i = 0; i < points.size(); ++i)
        EXPECT_EQ(before.terms[i].time_m, after.terms[i].time_m) << i;
}

TEST_F(Terms, of_space_alone_are_true_at_the_time_of_a_keyframe) {
    std::vector<QueryPoint> points;
    std::mt19937 random(4);
    std::uniform_real_distribution<double> place(-1e4, 1e4);
    for (int i = 0; i < 2000; ++i)
        points.push_back({place(random), place(random), i % 2 == 0 ? 0 : interval_us});
    const Found found = ask(exact(), points);
    for (const ErrorTerms& terms : found.terms)
        EXPECT_EQ(terms.time_m, 0);
    const DirectSum::Moment first = sum.at_time(0), last = sum.at_time(interval_us);
    expect_true(
        found, points,
        [&](std::size_t i) {
            return (i % 2 == 0 ? first : last).at(points[i].x_m, points[i].y_m).height;
        },
        [](const ErrorTerms& terms) { return terms.space_m; });
}

TEST_F(Terms, of_coding_alone_are_true_of_maps_that_were_rounded) {
    const double step_m = 0.01, step_mps = 0.05;
    MapError error = map_error(budget, 0);
    const double uniform = 1 / std::sqrt(12.0); // deviation of what rounding to whole steps leaves
    error.cascades[0].height.value_m = step_m * uniform;
    error.cascades[0].height.rate_mps = step_mps * uniform;
    const auto rounded = [&](TimeUs time_us) {
        auto map = std::make_shared<Keyframe>(*tests::exact_keyframe(sea, 0, time_us));
        for (const auto& [field, step] :
             {std::pair(Field::height, step_m), std::pair(Field::height_rate, step_mps)})
            for (float& value : map->plane(field))
                value = static_cast<float>(step * std::round(static_cast<double>(value) / step));
        return KeyframePtr(map);
    };
    const Surface coded = surface(rounded(0), rounded(interval_us), error);
    std::vector<QueryPoint> points;
    std::mt19937 random(5);
    std::uniform_real_distribution<double> place(-1e4, 1e4);
    std::uniform_int_distribution<TimeUs> time(0, interval_us);
    for (int i = 0; i < 2000; ++i)
        points.push_back({place(random), place(random), time(random)});
    const Found found = ask(coded, points), plain = ask(exact(), points);
    // What time and space miss is the same in both: the difference is what rounding does.
    expect_true(
        found, points, [&](std::size_t i) { return plain.answers[i].height_m; },
        [](const ErrorTerms& terms) { return terms.codec_m; });
}

} // namespace
} // namespace seaway::sea
