// SPDX-License-Identifier: Apache-2.0
// Maps that a client makes of waves: answers from them are within their bounds of the exact sum, and few are held.
#include <thread>

#include "client/rebuilt/gliding_sea.h"
#include "tests/client/wave_maps_of.h"
#include "tests/support/allocations.h"

namespace seaway::client {
namespace {

// Bounds of maps are five standard deviations; none of some thousand answers lies beyond.
TEST_F(WaveMapsOf, a_sea_answer_within_their_bounds_of_the_exact_sum_at_any_time) {
    WaveMaps maps(state, sea_off_by({}));
    const sea::TimeUs times[] = {0,
                                 1,
                                 3 * interval_us,
                                 -1,
                                 -interval_us / 3,
                                 123'456'789,
                                 -987'654'321'012,
                                 900'000'000'000'123};
    double worst_bound_m = 0, largest_m = 0;
    for (const sea::TimeUs time_us : times) {
        const auto asked = points(400, time_us);
        HeldSurfaces::Lent surface;
        ASSERT_TRUE(maps.lend({time_us, many}, surface)) << time_us;
        std::vector<sea::Answer> answers(asked.size());
        surface->surface.answer(asked, answers, {.mixed = &maps.mixed()});
        for (std::size_t i = 0; i < asked.size(); ++i) {
            const sea::Answer is = exact(asked[i]);
            EXPECT_EQ(answers[i].flags & sea::answer_extrapolated, 0u);
            EXPECT_LE(std::abs(answers[i].height_m - is.height_m), answers[i].error_m)
                << "at " << time_us;
            for (int axis = 0; axis < 3; ++axis) // a gentle sea: to 2 degrees, and 5 cm/s
                EXPECT_NEAR(answers[i].normal[axis], is.normal[axis], 0.035);
            worst_bound_m = std::max(worst_bound_m, answers[i].error_m);
            largest_m = std::max(largest_m, std::abs(is.height_m));
        }
    }
    EXPECT_EQ(maps.made(), 11 * cascades)
        << "one before 0, where 0 is held, and two of each other time";
    EXPECT_LE(worst_bound_m, 0.02) << "the scene's error is 0.01, on a slope";
    EXPECT_GT(largest_m, 0.5) << "a sea of Hs above 1 m";
}

TEST_F(WaveMapsOf, a_sea_that_is_off_say_so) {
    WaveMaps right(state, sea_off_by({})), off(state, sea_off_by({0.03, 0.02, 0.01}));
    const auto asked = points(100, 77'000);
    std::vector<sea::Answer> of_right(asked.size()), of_off(asked.size());
    for (const auto& [maps, answers] : {std::pair(&right, &of_right), {&off, &of_off}}) {
        HeldSurfaces::Lent surface;
        ASSERT_TRUE(maps->lend({77'000, many}, surface));
        surface->surface.answer(asked, *answers);
    }
    for (std::size_t i = 0; i < asked.size(); ++i) {
        EXPECT_EQ(of_off[i].height_m, of_right[i].height_m);
        EXPECT_GE(of_off[i].error_m, 0.03);
        EXPECT_LE(of_off[i].error_m, of_right[i].error_m + 0.03 + 0.02);
    }
    EXPECT_GE(off.surface({.time_us = 77'000, .points = many, .cascades = 1})
                  ->surface.flat_height_bound_m(),
              0.03)
        << "of the first cascade alone, too";
}

TEST_F(WaveMapsOf, a_sea_are_not_made_for_points_that_are_all_of_other_times) {
    WaveMaps maps(state, sea_off_by({}));
    HeldSurfaces::Lent surface;
    for (int i = 0; i < 5000; ++i)
        EXPECT_FALSE(maps.lend({i * 10 * interval_us, 1}, surface));
    EXPECT_EQ(maps.made(), 0u);
}

TEST_F(WaveMapsOf, a_sea_hold_four_keyframes_a_cascade_and_three_where_time_runs_on) {
    WaveMaps maps(state, sea_off_by({}));
    HeldSurfaces::Lent surface;
    for (const int interval :
         {0, 10, 0, 10, 0, 10}) // two times in turns: all that is needed is there
        ASSERT_TRUE(maps.lend({interval * interval_us, many}, surface));
    EXPECT_EQ(maps.made(), 4 * cascades);
    ASSERT_TRUE(maps.lend({20 * interval_us, many}, surface));
    EXPECT_EQ(maps.made(), 6 * cascades);
    EXPECT_TRUE(maps.lend({10 * interval_us, 1}, surface));
    EXPECT_FALSE(maps.lend({1, 1}, surface)) << "the first have gone";
    for (const int interval : {21, 22, 23})
        ASSERT_TRUE(maps.lend({interval * interval_us + 1, many}, surface));
    EXPECT_TRUE(maps.lend({22 * interval_us, 1}, surface));
    EXPECT_FALSE(maps.lend({21 * interval_us, 1}, surface)) << "which the fourth would keep";
}

TEST_F(WaveMapsOf, a_sea_allocate_nothing_once_they_are_made) {
    WaveMaps maps(state, sea_off_by({}));
    const auto asked = points(64, 1000);
    std::vector<sea::Answer> answers(asked.size());
    for (int round = 0; round < 3; ++round) {
        const tests::Allocations now;
        HeldSurfaces::Lent surface;
        ASSERT_TRUE(maps.lend({1000 + round, many}, surface));
        surface->surface.answer(asked, answers, {.mixed = &maps.mixed()});
        if (round > 0) {
            EXPECT_EQ(now.count(), 0u);
        }
    }
}

// Of a scene made by hand, as a client that rebuilds it has it: waves that are no modes are in its maps, too.
TEST_F(WaveMapsOf, a_sea_of_stylised_waves_hold_them) {
    const Result<sea::Scene> scene = sea::parse_scene(R"(
[sea]
seed = 3
[[sea.system]]
type = "sines"
shape = "exponential"
sharpness = 1.2
length_m = 256.0
count = 20
wavenumber_ratio = 1.05
amplitude_m = 0.6
wavelength_m = 85.0
from_deg = 250
direction_spread_deg = 35
[[cascade]]
length_m = 256.0
size = 64
)",
                                                      "sines", ".");
    ASSERT_TRUE(scene) << scene.error().message;
    const auto sines = std::make_shared<const sea::Realization>(*sea::realize(*scene));
    const sea::ErrorBudget costs = sea::plan_budget(*sines, 0.05);
    auto values = std::make_shared<SeaState>();
    values->epoch = 1;
    values->cascades = {
        {.length_m = 256, .size = 64, .interval_us = costs.cascades[0].interval_us}};
    values->choppiness_x = sines->choppiness.x;
    values->choppiness_y = sines->choppiness.y;
    put(costs, *values);
    const sea::DirectSum sum(sines);
    const WavePrices prices(*values, RebuiltSea(sines, *values, {}));
    EXPECT_GT(prices.keyframe_us(0), 64 * 64 * (map_point_us + 19.9 * map_shaped_wave_us));
    WaveMaps maps(values, std::make_shared<const RebuiltSea>(sines, *values, RebuiltError{}));
    const auto asked = points(200, 12'345'678);
    std::vector<sea::Answer> answers(asked.size());
    HeldSurfaces::Lent surface;
    ASSERT_TRUE(maps.lend({12'345'678, many}, surface));
    surface->surface.answer(asked, answers);
    double largest_m = 0;
    for (std::size_t i = 0; i < asked.size(); ++i) {
        const sea::Answer is = sea::surface_at(
            asked[i], {sines->choppiness, 1e-9, sea::FoldSearch{}}, sum.at_time(12'345'678));
        EXPECT_LE(std::abs(answers[i].height_m - is.height_m), answers[i].error_m);
        largest_m = std::max(largest_m, std::abs(is.height_m));
    }
    EXPECT_GT(largest_m, 0.1);
}

TEST_F(WaveMapsOf, seas_are_held_of_some_while_their_waves_are_the_same) {
    MapsOfSeas seas;
    const auto of_epoch = [&](std::uint32_t epoch) {
        auto other = std::make_shared<SeaState>(*state);
        other->epoch = epoch;
        return SeaStatePtr(other);
    };
    SeaStatePtr states[5];
    for (std::uint32_t i = 0; i < 5; ++i)
        states[i] = of_epoch(i);
    const OwnSeaPtr own = sea_off_by({}), better = sea_off_by({0.001, 0.001, 0});
    const auto first = seas.of(states[0], own), second = seas.of(states[1], own);
    EXPECT_NE(second, first);
    EXPECT_EQ(seas.of(states[0], own), first);
    for (const int i : {2, 3})
        seas.of(states[i], own);
    EXPECT_EQ(seas.of(states[0], own), first);
    const auto fifth = seas.of(states[4], own);
    EXPECT_EQ(seas.of(states[0], own), first);
    EXPECT_NE(seas.of(states[1], own), second) << "the one that was asked for least recently";
    EXPECT_EQ(seas.of(states[4], own), fifth);
    const auto more = seas.of(states[4], better);
    EXPECT_NE(more, fifth) << "more of its waves have come";
    EXPECT_EQ(seas.of(states[4], better), more);
    seas.forget(4);
    EXPECT_NE(seas.of(states[4], better), more);
}

TEST_F(WaveMapsOf, two_seas_have_keyframes_at_once) {
    MapsOfSeas seas;
    const OwnSeaPtr own = sea_off_by({});
    HeldSurfaces::Lent surface;
    std::vector<std::shared_ptr<WaveMaps>> maps;
    for (std::uint32_t epoch = 0; epoch < 3; ++epoch) {
        auto other = std::make_shared<SeaState>(*state);
        other->epoch = epoch;
        maps.push_back(seas.of(other, own));
        ASSERT_TRUE(maps.back()->lend({1000, many}, surface));
    }
    EXPECT_TRUE(maps[2]->lend({1000, 1}, surface));
    EXPECT_TRUE(maps[1]->lend({1000, 1}, surface));
    EXPECT_FALSE(maps[0]->lend({1000, 1}, surface)) << "its memory has gone back";
}

// Wind and depth change, each time with maps of its own waves and of what they grow by. The bound is of the envelope, as a
// server says it of a glide.
TEST_F(WaveMapsOf, a_sea_on_its_way_answer_within_their_bounds_of_its_own_sums) {
    sea::SeaState next = tests::announced_scene().sea;
    std::get<sea::WindSea>(next.systems[0]).wind_speed_10m_mps = 13;
    for (const double depth_m : {30.0, 8.0}) {
        next.depth_m = depth_m;
        const auto later = std::make_shared<const sea::Realization>(
            *sea::realize(next, tests::announced_scene().cascades));
        constexpr sea::TimeUs start_us = 50'000'000, end_us = 62'000'000;
        const auto change = sea::SeaTransition::create(waves, later, start_us, end_us);
        ASSERT_TRUE(change);
        const sea::ErrorBudget costs = sea::plan_budget(*change->envelope(), 0.01);
        auto values = std::make_shared<SeaState>(*state);
        values->losses.clear();
        put(costs, *values);
        const sea::TimeUs apart_us = std::ranges::min(costs.cascades, {}, of_interval).interval_us;
        for (protocol::CascadeInfo& cascade : values->cascades)
            cascade.interval_us = apart_us;
        values->start_time_us = start_us;
        values->glide = protocol::GlideValues{.end_us = end_us,
                                              .choppiness_x = values->choppiness_x,
                                              .choppiness_y = values->choppiness_y};
        const RebuiltSea from(waves, *values, {}), to(change->after(), *values, {});
        const auto glide = GlidingSea::create(*values, from, to, start_us, end_us);
        ASSERT_TRUE(glide) << glide.error().message;
        MapsOfSeas seas;
        const auto maps = seas.of(values, *glide);
        double worst_of_bound = 0;
        for (const sea::TimeUs time_us :
             {start_us - 123'456, start_us, start_us + 77'000, sea::TimeUs{54'321'000},
              sea::TimeUs{56'000'000}, sea::TimeUs{59'999'999}, end_us - 1, end_us + 33'333}) {
            const auto asked = points(300, time_us);
            HeldSurfaces::Lent surface;
            ASSERT_TRUE(maps->lend({time_us, many}, surface)) << time_us;
            std::vector<sea::Answer> answers(asked.size()), sums(asked.size());
            surface->surface.answer(asked, answers);
            (*glide)->answer(asked, sums, {});
            for (std::size_t i = 0; i < asked.size(); ++i) {
                if (answers[i].flags & sea::answer_folded)
                    continue;
                const double off_m = std::abs(answers[i].height_m - sums[i].height_m);
                EXPECT_LE(off_m, answers[i].error_m + sums[i].error_m) << "at " << time_us;
                worst_of_bound = std::max(worst_of_bound, off_m / answers[i].error_m);
                for (int axis = 0; axis < 3; ++axis) // of waves of 1 m/s, on a grid of 64
                    EXPECT_NEAR(answers[i].velocity_mps[axis], sums[i].velocity_mps[axis], 0.06);
            }
        }
        EXPECT_GT(worst_of_bound, 0.2) << "else the bound is none of these maps";
    }
}

// Naive: who asks about times far apart takes the keyframes of who follows the present.
TEST_F(WaveMapsOf, a_sea_that_are_in_use_stay_while_others_are_made) {
    WaveMaps maps(state, sea_off_by({}));
    HeldSurfaces::Lent surface;
    ASSERT_TRUE(maps.lend({500, many}, surface));
    for (int far = 1; far < 8; ++far) {
        ASSERT_TRUE(maps.lend({far * 100 * interval_us, many}, surface));
        EXPECT_TRUE(maps.lend({500 + far, 1}, surface)) << far;
    }
    EXPECT_EQ(maps.made(), 8 * 2 * cascades);
}

// What a tile is too large to be transformed for is summed.
TEST_F(WaveMapsOf, a_sea_without_a_transform_are_never_made) {
    auto larger = std::make_shared<sea::Realization>(*waves);
    larger->cascades[1].spec.size = 48; // no power of two
    larger->cascades[1].h0.resize(48 * 48);
    larger->cascades[1].rate.resize(48 * 48);
    WaveMaps maps(state, std::make_shared<const RebuiltSea>(larger, *state, RebuiltError{}));
    HeldSurfaces::Lent surface;
    EXPECT_FALSE(maps.lend({0, many}, surface));
    EXPECT_FALSE(maps.lend({1, many}, surface));
    EXPECT_LE(maps.made(), 2u) << "nor tried again";
    EXPECT_FALSE(maps.map(0, 1));
    EXPECT_TRUE(maps.map(0, 0)) << "which is of another tile";
}

// More threads than there are places for surfaces, at more times than there is room for keyframes.
TEST_F(WaveMapsOf, a_sea_answer_many_threads_each_at_its_own_time) {
    WaveMaps maps(state, sea_off_by({}));
    std::vector<std::vector<sea::QueryPoint>> asked;
    std::vector<std::vector<sea::Answer>> is;
    for (int t = 0; t < 6; ++t) {
        asked.push_back(points(20, t * 7 * interval_us + 1000));
        is.emplace_back();
        for (const sea::QueryPoint& point : asked.back())
            is.back().push_back(exact(point));
    }
    std::atomic<int> lent = 0, wrong = 0;
    std::vector<std::thread> threads;
    for (std::size_t t = 0; t < asked.size(); ++t)
        threads.emplace_back([&, t] {
            std::vector<sea::Answer> answers(asked[t].size());
            for (int round = 0; round < 20; ++round) {
                HeldSurfaces::Lent surface;
                if (!maps.lend({asked[t][0].time_us, many}, surface))
                    continue;
                ++lent;
                surface->surface.answer(asked[t], answers, {.mixed = &maps.mixed()});
                for (std::size_t i = 0; i < answers.size(); ++i)
                    if (!(std::abs(answers[i].height_m - is[t][i].height_m) <=
                          answers[i].error_m) ||
                        (answers[i].flags & sea::answer_extrapolated))
                        ++wrong;
            }
        });
    for (std::thread& thread : threads)
        thread.join();
    EXPECT_EQ(wrong, 0);
    EXPECT_EQ(lent, 6 * 20) << "so many points wait for who makes others";
}

} // namespace
} // namespace seaway::client
