// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <random>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "sea/surface/budget/error_budget.h"
#include "sea/surface/surface.h"
#include "tests/support/explicit_sea.h"

namespace seaway::sea {
namespace {

constexpr TimeUs interval_us = 200'000;

Surface surface_of(const RealizationPtr& sea, MapError error = {}) {
    std::vector<SplinePair> pairs;
    for (int c = 0; c < static_cast<int>(sea->cascades.size()); ++c)
        pairs.push_back({std::make_shared<SplineMap>(*tests::exact_keyframe(sea, c, 0)),
                         std::make_shared<SplineMap>(*tests::exact_keyframe(sea, c, interval_us))});
    return Surface(std::move(pairs), sea->choppiness, {.reach_m = 5.0}, error);
}

RealizationPtr two_cascades() {
    return tests::make_sea({tests::random_cascade(200.0, 64, 8, 30, 0.02, 1),
                            tests::random_cascade(37.3, 64, 10, 30, 0.02, 2)});
}

TEST(Surface, passes_through_every_grid_value) {
    const RealizationPtr sea = two_cascades();
    const KeyframePtr keyframe = tests::exact_keyframe(sea, 0, 0);
    const SplineMap map(*keyframe);
    for (int y = 0; y < 64; y += 7)
        for (int x = 0; x < 64; ++x) {
            const float value = map.sample(x * 200.0 / 64, y * 200.0 / 64).value[0];
            // Single precision through a filter of gain 36.
            EXPECT_NEAR(value, keyframe->plane(Field::height)[static_cast<std::size_t>(y * 64 + x)],
                        3e-6);
        }
}

TEST(Surface, every_value_agrees_with_the_direct_sum_between_grid_points_and_keyframes) {
    const RealizationPtr sea = two_cascades();
    const Surface surface = surface_of(sea);
    const DirectSum sum(sea);
    // The laws of error_budget.h for these modes, added up without mercy: 60 waves, each missing at
    // most spline_error(q) + hermite_error(u) of its amplitude.
    double bound = 0;
    for (const CascadeModes& modes : sea->cascades)
        for (std::size_t i = 0; i < modes.h0.size(); ++i) {
            const int nx = signed_index(static_cast<int>(i % 64), 64);
            const int ny = signed_index(static_cast<int>(i / 64), 64);
            const double q = two_pi / 64;
            bound += 2 * std::abs(modes.h0[i]) *
                     (spline_error(q * std::abs(nx)) + spline_error(q * std::abs(ny)) +
                      hermite_error(omega_from_rate(modes.rate[i]) * 0.2));
        }
    std::mt19937 random(5);
    std::uniform_real_distribution<double> place(-1e4, 1e4);
    std::uniform_int_distribution<TimeUs> time(0, interval_us);
    for (int i = 0; i < 1000; ++i) {
        const double x = place(random);
        const double y = place(random);
        const TimeUs t = time(random);
        const LagrangianPoint truth = sum.at(x, y, t);
        const LagrangianPoint p = surface.at(x, y, t);
        EXPECT_NEAR(p.height, truth.height, bound);
        EXPECT_NEAR(p.displacement_x, truth.displacement_x, bound);
        EXPECT_NEAR(p.displacement_y, truth.displacement_y, bound);
        // Derivatives lose one order of q or u: 30 times the error of the value at these grids.
        EXPECT_NEAR(p.height_rate, truth.height_rate, 30 * bound);
        EXPECT_NEAR(p.displacement_x_rate, truth.displacement_x_rate, 30 * bound);
        EXPECT_NEAR(p.displacement_y_rate, truth.displacement_y_rate, 30 * bound);
        EXPECT_NEAR(p.slope_x, truth.slope_x, 30 * bound);
        EXPECT_NEAR(p.slope_y, truth.slope_y, 30 * bound);
        EXPECT_NEAR(p.strain_xx, truth.strain_xx, 30 * bound);
        EXPECT_NEAR(p.strain_yy, truth.strain_yy, 30 * bound);
        EXPECT_NEAR(p.strain_xy, truth.strain_xy, 30 * bound);
    }
    EXPECT_LT(bound, 2e-3) << "the bound of this test must mean something";
}

// Naive: floats that are finite, as a tile's may be, make coefficients that are not, a search goes where there is no number, and
// reads there.
TEST(Surface, of_maps_without_bounds_answers_and_reads_no_wild_memory) {
    for (const float huge : {1e37f, 3e38f}) {
        std::vector<SplinePair> pairs;
        std::vector<std::shared_ptr<const SplineMap>> maps;
        for (const TimeUs time_us : {TimeUs{0}, interval_us}) {
            Keyframe keyframe;
            keyframe.time_us = time_us;
            keyframe.size = 8;
            keyframe.length_m = 100;
            keyframe.fields = surface_fields;
            keyframe.values.assign(keyframe.plane_size() * 6, 0.0f);
            for (const Field field : {Field::displacement_x, Field::displacement_y})
                for (std::size_t i = 0; i < keyframe.plane_size(); ++i)
                    keyframe.plane(field)[i] = (i + i / 8) % 2 == 0 ? huge : -huge;
            maps.push_back(std::make_shared<SplineMap>(keyframe));
        }
        pairs.push_back({maps[0], maps[1]});
        const Surface surface(std::move(pairs), {1, 1}, {.reach_m = 5.0}, {});
        std::vector<QueryPoint> points;
        for (int i = 0; i < 64; ++i)
            points.push_back({i * 3.7, i * -1.9, i * interval_us / 64});
        std::vector<Answer> answers(points.size());
        surface.answer(points, answers);
        for (const Answer& answer : answers)
            EXPECT_TRUE(answer.height_m == 0 || answer.flags != 0) << "heights are level";
    }
}

// D6: inverting cascade by cascade misses |D1| |grad eta2|, centimetres here.
TEST(Surface, d6_the_summed_displacement_is_inverted) {
    const RealizationPtr sea = two_cascades();
    const Surface surface = surface_of(sea);
    const DirectSum sum(sea);
    const DirectSum::Moment moment = sum.at_time(0);
    for (int i = 0; i < 200; ++i) {
        const QueryPoint point{13.7 * i - 900.0, -7.1 * i, 0};
        const Answer exact = surface_at(point, {sea->choppiness, 1e-9, 5.0}, moment);
        EXPECT_NEAR(surface.answer(point).height_m, exact.height_m, 2e-3);
    }
}

// G1: at 1e7 m a float coordinate is a staircase of 1 m.
TEST(Surface, g1_far_from_the_origin_is_as_near) {
    const RealizationPtr sea = two_cascades();
    const Surface surface = surface_of(sea);
    const DirectSum sum(sea);
    for (const double far_m : {1e6, -1e7}) {
        const LagrangianPoint truth = sum.at(far_m + 3.3, far_m - 1.1, 100'000);
        EXPECT_NEAR(surface.at(far_m + 3.3, far_m - 1.1, 100'000).height, truth.height, 1e-3);
    }
    EXPECT_NEAR(surface_of(tests::make_sea({sea->cascades[0]})).at(7.0 + 200.0 * 1e6, 0, 0).height,
                surface_of(tests::make_sea({sea->cascades[0]})).at(7.0, 0, 0).height, 1e-6);
}

// G2: fmod(-0.1, L) is negative and becomes index -1.
TEST(Surface, g2_negative_and_border_coordinates_are_continuous) {
    const Surface surface = surface_of(two_cascades());
    const double at_zero = surface.at(0.0, 0.0, 0).height;
    for (const double x : {-1e-12, -0.0, -5e-324, 1e-300})
        EXPECT_NEAR(surface.at(x, x, 0).height, at_zero, 1e-6) << x;
    for (const double x : {0.0, 37.3, 200.0, -37.3, -200.0}) {
        const double before = surface.at(std::nextafter(x, -1e9), 0, 0).height;
        const double after = surface.at(std::nextafter(x, 1e9), 0, 0).height;
        EXPECT_NEAR(before, after, 1e-6) << x;
    }
}

// G4: a straight line through two values is silently wrong outside them.
TEST(Surface, g4_time_outside_the_keyframes_is_flagged) {
    const Surface surface = surface_of(two_cascades());
    EXPECT_EQ(surface.answer({1, 2, interval_us}).flags, 0u);
    EXPECT_TRUE(surface.answer({1, 2, interval_us + 1}).flags & answer_extrapolated);
    EXPECT_TRUE(surface.answer({1, 2, -1}).flags & answer_extrapolated);
}

// G4: the cubic of the last two keyframes made 63 m of a sea of 5 m, 16 s later, and each point took 40 ms of looking for the
// highest of its sheets.
TEST(Surface, g4_a_sea_outside_its_keyframes_stands_and_is_no_higher_than_it_may_be) {
    const RealizationPtr sea = two_cascades();
    const Surface surface = surface_of(sea);
    double highest_m =
        0; // all waves at once; u is 2 at most here, so half as much again of them (TimeBudget)
    for (const CascadeModes& modes : sea->cascades)
        for (const auto& h0 : modes.h0)
            highest_m += 2 * std::abs(h0);
    for (const TimeUs beyond_us : {TimeUs{1}, TimeUs{50'000}, TimeUs{4'000'000}, time_us_max})
        for (const TimeUs time_us : {-beyond_us, interval_us + beyond_us})
            for (int i = 0; i < 100; ++i) {
                const Answer answer = surface.answer({1.7 * i, 2.9 * i, time_us});
                ASSERT_LE(std::abs(answer.height_m), 2 * highest_m) << time_us;
                ASSERT_EQ(answer.flags, std::uint32_t{answer_extrapolated})
                    << "and does not fold where it did not";
                ASSERT_TRUE(std::isfinite(answer.error_m));
                if (beyond_us >= 4'000'000) {
                    ASSERT_LT(std::abs(answer.velocity_mps[2]), 1e-4);
                }
            }
}

TEST(Surface, g8_answers_do_not_depend_on_batch_or_order) {
    const Surface surface = surface_of(two_cascades());
    std::vector<QueryPoint> points;
    for (int i = 0; i < 1'000'000; ++i) // the case's
        points.push_back({i * 1.3, i * -0.7, (i * 631LL) % interval_us});
    points.push_back(points.front());
    std::vector<Answer> forward(points.size());
    surface.answer(points, forward);
    std::vector<QueryPoint> reversed(points.rbegin(), points.rend());
    std::vector<Answer> backward(points.size());
    surface.answer(reversed, backward);
    for (std::size_t i = 0; i < points.size(); ++i)
        ASSERT_EQ(forward[i].height_m, backward[points.size() - 1 - i].height_m) << i;
    EXPECT_EQ(forward.front().height_m, forward.back().height_m);
    surface.answer({}, {});
}

/// Losses of two cascades, all different.
MapError some_error() {
    return {
        .cascades = {{{0.001, 0.002, 0.003, 0.004, 0.05}, {0.006, 0.007, 0.008, 0.009, 0.01}},
                     {{0.0011, 0.0012, 0.0013, 0.0014, 0.15}, {0.0016, 0.017, 0.018, 0.019, 0.1}}},
        .height_bound_m = 0.0001,
        .displacement_bound_m = 0.0002};
}

// Held as a formula: most answers would stay inside their bound with any one part left out.
TEST(Surface, an_answer_states_what_its_time_and_place_miss_by_all_parts) {
    const RealizationPtr sea = tests::make_sea(two_cascades()->cascades, {0.8, 1.4});
    const Surface surface = surface_of(sea, some_error());
    const DirectSum sum(sea);
    for (int i = 0; i < 50; ++i) {
        const double X = 7.3 * i, Y = -3.1 * i; // undisplaced
        const TimeUs time_us = interval_us * (i % 11) / 10;
        const LagrangianPoint moved = surface.at(X, Y, time_us);
        const Answer answer = surface.answer(
            {X + 0.8 * moved.displacement_x, Y + 1.4 * moved.displacement_y, time_us});
        const double slope = surface_slope(answer);
        const double s = static_cast<double>(i % 11) / 10, r = 1 - s, interval_s = 0.2;
        const double values = std::pow(r * r * (1 + 2 * s), 2) + std::pow(s * s * (1 + 2 * r), 2);
        const double rates = interval_s * interval_s * s * s * r * r * (s * s + r * r);
        double variance = 0;
        for (std::size_t c = 0; c < 2; ++c) {
            const double cells = 64 / sea->cascades[c].spec.length_m;
            const auto middle = [](double x) {
                const double t = x - std::floor(x);
                return 16 * t * t * (1 - t) * (1 - t);
            };
            const auto of = [&](const MapLoss& loss) {
                const double east = middle(X * cells), north = middle(Y * cells);
                return std::pow(loss.time_m * 16 * s * s * r * r, 2) +
                       loss.east_m * loss.east_m * east + loss.north_m * loss.north_m * north +
                       (1 - east / 5) * (1 - north / 5) *
                           (loss.value_m * loss.value_m * values +
                            loss.rate_mps * loss.rate_mps * rates);
            };
            const CascadeLoss& loss = surface.map_error().cascades[c];
            variance += of(loss.height) + slope * slope * 1.4 * 1.4 * of(loss.displacement);
        }
        const double stated = 5 * std::sqrt(variance) + 0.0001 + slope * 1.4 * 0.0002;
        // Newton ends within 0.1 mm of X, which is seen in the residual and, slightly, in the place.
        EXPECT_NEAR(answer.error_m, stated, 1e-4 * slope + 1e-4 * stated) << i;
        EXPECT_LE(answer.error_m, surface.height_bound_m(slope) + 1e-4 * slope) << i;
    }
}

TEST(Surface, folds_are_told_apart_by_six_deviations_of_what_maps_miss_sideways) {
    const RealizationPtr sea = tests::make_sea(two_cascades()->cascades, {0.8, 1.4});
    MapError error = some_error();
    error.strain_bound = 0.03;
    error.codec_strain_bound = 0.05;
    const Surface surface = surface_of(sea, error);
    // Interval times rate is below a quarter of the value: values at a keyframe are the worst.
    error.cascades[1].displacement.rate_mps = 0.01;
    const double variance =
        1e-6 * (36 + 49 + 64 + 81) + 1e-6 * (1.6 * 1.6 + 289 + 324) +
        std::max(1e-6 * 361, 1e-6 * 361 * codec_peak(std::pow(0.02 / 0.019, 2)));
    EXPECT_NEAR(surface.fold_blur_m(), 1.4 * (6 * std::sqrt(variance) + 0.0002), 1e-12);
    EXPECT_NEAR(surface.fold_strain_blur(), 1.4 * 0.03 + 0.05, 1e-15);
}

TEST(Surface, maps_without_displacement_are_a_surface_without_choppiness) {
    const RealizationPtr sea = two_cascades();
    const KeyframePtr full = tests::exact_keyframe(sea, 0, 0);
    Keyframe height_only = *full;
    height_only.fields = {Field::height, Field::height_rate};
    const std::span<const float> heights = full->plane(Field::height),
                                 rates = full->plane(Field::height_rate);
    std::vector<float> values(heights.begin(), heights.end());
    values.insert(values.end(), rates.begin(), rates.end());
    height_only.values = std::move(values);
    const auto map = std::make_shared<SplineMap>(height_only);
    const Surface surface({{map, map}}, {1, 1}, {.reach_m = 5.0}, {});
    const LagrangianPoint p = surface.at(12.0, 5.0, 0);
    EXPECT_EQ(p.displacement_x, 0.0);
    EXPECT_NEAR(p.height, SplineMap(*full).sample(12.0, 5.0).value[0], 1e-6);
}

int pauses = 0;

// What is filtered between two pauses depends on the size: 384 is no multiple of it.
TEST(Surface, a_map_that_is_made_with_pauses_is_the_same_and_passes_through_its_grid) {
    for (const int size : {32, 256, 384}) {
        Keyframe keyframe{0, 0, 0, size, 100.0, surface_fields};
        std::mt19937 random(1);
        std::uniform_real_distribution<float> any(-1, 1);
        std::vector<float> values(static_cast<std::size_t>(surface_fields.size()) *
                                  keyframe.plane_size());
        std::ranges::generate(values, [&] { return any(random); });
        keyframe.values = std::move(values);
        const SplineMap at_once(keyframe);
        pauses = 0;
        const SplineMap paused(keyframe, [] { ++pauses; });
        EXPECT_TRUE(std::ranges::equal(paused.coefficients(), at_once.coefficients())) << size;
        const StrainBounds &one = paused.windows().whole_tile(),
                           &other = at_once.windows().whole_tile();
        const auto all_of = [](const StrainBounds& bounds) {
            return std::tuple(bounds.range_on_m, bounds.range_back_m, bounds.range_rate,
                              bounds.strain_on, bounds.strain_back, bounds.strain_rate);
        };
        EXPECT_EQ(all_of(one), all_of(other));
        const double d_m = 100.0 / size;
        for (int i = 0; i < size; ++i) // a diagonal crosses all that is filtered together
            EXPECT_NEAR(paused.sample(i * d_m, i * d_m).value[spline_channel::height],
                        keyframe.plane(Field::height)[static_cast<std::size_t>(i) *
                                                      static_cast<std::size_t>(size + 1)],
                        3e-6); // rounding of some floats of up to 6
        // Interleaved, filtered both ways, forth and back, and looked at for windows: six times.
        const double pieces = 6.0 * size * size / Pauses::between;
        EXPECT_GE(pauses, std::floor(0.8 * pieces)) << size;
        EXPECT_LE(pauses, pieces + 1) << size;
    }
}

} // namespace
} // namespace seaway::sea
