// SPDX-License-Identifier: Apache-2.0
// What a request is priced at: on numbers that are given, without a clock.
#include "tests/server/simulation/simulation_bench.h"

namespace seaway::server {
namespace {

const HoldingOf nothing_held = [](const KeyframeRequest&) { return Holding::nothing; };
const HoldingOf all_held = [](const KeyframeRequest&) { return Holding::spline; };
const std::string foam_of_5_s = "[foam]\nthreshold = 0.8\ndecay_s = 5\n";

double fetch_us(const Prices& prices, const RunningSeaPtr& sea, std::vector<TimeUs> times_us,
                Demand demand, const HoldingOf& held = nothing_held) {
    return prices.keyframes_us(keyframes_around(*steady_course(sea), times_us, demand), held);
}

TEST(Prices, a_fetch_is_its_distinct_keyframes_times_their_fields_and_samples) {
    const RunningSeaPtr sea = running_sea();
    const Prices prices(steady_course(sea));
    const Demand height{1u, {Field::height}};
    const double one = 64.0 * 64.0 * price_sample_us; // a keyframe of one field
    EXPECT_DOUBLE_EQ(fetch_us(prices, sea, {0}, height), 2 * one);
    EXPECT_DOUBLE_EQ(fetch_us(prices, sea, {0, 0, 1}, height), 2 * one) << "the same two";
    EXPECT_DOUBLE_EQ(fetch_us(prices, sea, {0, 3'600'000'000}, height), 4 * one);
    EXPECT_DOUBLE_EQ(fetch_us(prices, sea, {0}, {3u, {Field::height}}), 4 * one) << "cascades";
    EXPECT_DOUBLE_EQ(fetch_us(prices, sea, {0}, {1u, sea::surface_fields}), 12 * one) << "fields";
    EXPECT_EQ(fetch_us(prices, sea, {0}, height, all_held), 0) << "nothing is to be made";
}

TEST(Prices, foam_far_away_is_a_start_of_its_history_and_near_by_the_ticks_between) {
    const RunningSeaPtr sea = running_sea(foam_of_5_s);
    const Prices prices(steady_course(sea));
    FoamMaps foam(steady_course(sea));
    const double tick = 64.0 * 64.0 * price_foam_sample_us;
    const double keyframe = 64.0 * 64.0 * 4 * price_sample_us; // foam and what it stands on
    const double start = foam.ticks_to(0, 0) * tick;
    ASSERT_GT(start, 10 * tick);
    const Demand demand{1u, {Field::foam}};
    const double one_time = fetch_us(prices, sea, {0}, demand);
    EXPECT_GE(one_time, start + 2 * keyframe);
    // The second keyframe is an interval on: some ticks, however long the interval.
    const double interval_us = static_cast<double>(sea->budget.cascades[0].interval_us);
    EXPECT_LE(one_time, start + 2 * keyframe + tick * (1 + interval_us / 200'000));
    const double far_times = fetch_us(prices, sea, {0, 3'600'000'000, 7'200'000'000}, demand);
    EXPECT_NEAR(far_times, 3 * one_time, 1e-6 * far_times);
}

TEST(Prices, points_at_one_time_share_its_surface_and_points_at_many_pay_for_each) {
    const Prices prices(steady_course(running_sea()));
    const double surface = prices.surface_us(0, nothing_held);
    ASSERT_GT(surface, 0);
    EXPECT_NEAR(prices.points_us(points_in_a_row(1000), nothing_held),
                surface + 1000 * price_point_us, 1e-6);
    EXPECT_NEAR(prices.points_us(points_in_a_row(1000, 3'600'000'000), nothing_held),
                1000 * (surface + price_point_us), 1e-3);
    EXPECT_NEAR(prices.points_us(points_in_a_row(1000), all_held), 1000 * price_point_us, 1e-6);
    EXPECT_LE(prices.points_us(points_in_a_row(1), nothing_held), prices.prompt_us())
        << "a single point is a prompt question wherever it is asked about";
    EXPECT_GT(prices.points_us(points_in_a_row(4096), nothing_held), prices.prompt_us());
    EXPECT_GT(prices.points_us(points_in_a_row(2, 3'600'000'000), nothing_held),
              prices.prompt_us());
}

// Naive: who asks about the seas of a long log has them made before anybody has said what that takes.
TEST(Prices, seas_that_are_not_made_are_paid_for_and_none_is_made_to_know_it) {
    const sea::Scene scene = small_scene();
    const auto course = *SeaCourse::begin(scene);
    for (int i = 0; i < 100; ++i)
        ASSERT_TRUE(course->add(scene, (100 * i + 50) * second_us, (100 * i + 70) * second_us));
    const Prices prices(course);
    const double sea_us = 2 * 64.0 * 64.0 * price_sea_wave_us;
    const TimeUs steady_us = 100 * second_us; // and so on: epochs 3, 5, 7 ...
    const auto at = [](TimeUs time_us) { return std::vector<sea::QueryPoint>{{0, 0, time_us}}; };
    EXPECT_NEAR(prices.points_us(at(steady_us), all_held), sea_us + price_point_us, 1e-6);
    EXPECT_NEAR(prices.points_us(at(60 * second_us), all_held), 2 * sea_us + price_point_us, 1e-6);
    EXPECT_NEAR(prices.fetch_us({steady_us, 2 * steady_us}, {1u, {Field::height}}, all_held),
                2 * sea_us, 1e-6);
    EXPECT_GT(prices.exact_us(points_in_a_row(100, 100 * second_us)), 99 * sea_us);
    EXPECT_GT(prices.points_us(at(steady_us), all_held), prices.prompt_us());
    for (std::uint32_t epoch = 2; epoch <= course->epochs(); ++epoch)
        EXPECT_EQ(course->sea_if_held(epoch), nullptr) << epoch;
    (void)course->sea(3);
    EXPECT_NEAR(prices.points_us(at(steady_us), all_held), price_point_us, 1e-6);
}

TEST(Prices, an_exact_sum_in_a_glide_has_its_waves_made_for_each_time) {
    const sea::Scene scene = small_scene();
    const auto course = *SeaCourse::begin(scene);
    ASSERT_TRUE(course->add(scene, 100 * second_us, 200 * second_us));
    (void)course->sea(2);
    const Prices prices(course);
    const auto between = [&](TimeUs from_us, std::size_t count) {
        std::vector<sea::QueryPoint> all = points_in_a_row(count, second_us);
        for (sea::QueryPoint& point : all)
            point.time_us += from_us;
        return prices.exact_us(all);
    };
    EXPECT_NEAR(between(101 * second_us, 50) - between(0, 50),
                50 * 2 * 64.0 * 64.0 * price_glide_wave_us, 1e-6);
}

// Naive: the waves of all cascades, though a device is given those alone that are asked for.
TEST(Prices, a_keyframe_in_a_glide_has_the_waves_of_its_cascade_made_and_of_no_other) {
    const sea::Scene scene = small_scene();
    const auto course = *SeaCourse::begin(scene);
    ASSERT_TRUE(course->add(scene, 100 * second_us, 200 * second_us));
    (void)course->sea(2);
    const Prices prices(course);
    const double keyframes = 2, waves_us = 2 * 64.0 * 64.0 * price_glide_wave_us; // around a time
    const auto more_in_a_glide = [&](std::uint32_t cascades) {
        const Demand heights{cascades, {Field::height}};
        return prices.fetch_us({150 * second_us}, heights, nothing_held) -
               prices.fetch_us({50 * second_us}, heights, nothing_held);
    };
    EXPECT_NEAR(more_in_a_glide(2u), keyframes * waves_us, 1e-6);
    EXPECT_NEAR(more_in_a_glide(3u), 2 * keyframes * waves_us, 1e-6);
    EXPECT_NEAR(prices.surface_us(150 * second_us, nothing_held) -
                    prices.surface_us(50 * second_us, nothing_held),
                2 * keyframes * waves_us, 1e-6)
        << "points feel both cascades";
}

// Naive: waves that no transform carries are free.
TEST(Prices, stylised_waves_are_paid_for_by_keyframes_that_have_them) {
    const auto costs = [](const std::string& shape, FieldSet fields) {
        const std::string waves = "[[sea.system]]\ntype = \"sines\"\nshape = \"" + shape +
                                  "\"\nlength_m = 301.0\ncount = 2\namplitude_m = 0.2\n"
                                  "wavelength_m = 100.0\nfrom_deg = 230\n";
        const RunningSeaPtr sea = running_sea(waves + foam_of_5_s),
                            plain = running_sea(foam_of_5_s);
        const Demand demand{1u, fields};
        return fetch_us(Prices(steady_course(sea)), sea, {0}, demand) -
               fetch_us(Prices(steady_course(plain)), plain, {0}, demand);
    };
    const double sums = 2 * 2 * 64.0 * 64.0; // of two keyframes
    const FieldSet heights{Field::height, Field::height_rate};
    EXPECT_NEAR(costs("sine", heights), sums * price_plane_sine_us, 1e-6);
    EXPECT_NEAR(costs("exponential", heights), sums * price_sharp_sine_us, 1e-6);
    EXPECT_NEAR(costs("noise", heights), sums * price_octave_us, 1e-6);
    EXPECT_NEAR(costs("exponential", {Field::displacement_x, Field::jacobian}), 0, 1e-6);
    EXPECT_NEAR(costs("exponential", {Field::foam}), 0, 1e-6) << "no tick has them";
}

TEST(Prices, foam_of_a_calm_sea_has_no_start_as_long_as_nothing_follows_it) {
    const std::string calm_law = "[foam]\nthreshold = -0.9\ndecay_s = 5\n";
    const sea::Scene scene = small_scene(calm_law);
    const auto course = *SeaCourse::begin(scene);
    const Prices prices(course);
    const auto foam_us = [&] { return prices.fetch_us({0}, {1u, {Field::foam}}, nothing_held); };
    const double calm = foam_us();
    EXPECT_LT(calm, 64.0 * 64.0 * 10 * price_foam_sample_us);
    ASSERT_TRUE(course->add(scene, 100 * second_us, 200 * second_us));
    EXPECT_GT(foam_us(), 10 * calm) << "it may have been walked for";
}

TEST(Prices, an_exact_sum_is_all_waves_for_each_point_and_more_for_each_time) {
    const Prices prices(steady_course(running_sea()));
    const double one = prices.exact_us(points_in_a_row(1)),
                 two = prices.exact_us(points_in_a_row(2));
    EXPECT_GT(one, 0);
    EXPECT_NEAR(prices.exact_us(points_in_a_row(256)), one + 255 * (two - one), 1e-6);
    EXPECT_GT(prices.exact_us(points_in_a_row(256, 1'000'000)),
              prices.exact_us(points_in_a_row(256)));
}

// What nobody looks up counts as not held, so that pricing 4096 times costs no 4096 lookups.
TEST(Prices, looking_up_what_is_held_ends_at_some_time) {
    const Prices prices(steady_course(running_sea()));
    int looked_up = 0;
    (void)prices.points_us(points_in_a_row(4096, 3'600'000'000), [&](const KeyframeRequest&) {
        ++looked_up;
        return Holding::spline;
    });
    EXPECT_EQ(looked_up, price_lookups_max);
}

} // namespace
} // namespace seaway::server
