// SPDX-License-Identifier: Apache-2.0
// A client that has the waves of both seas glides as the server does.
#include <random>

#include <gtest/gtest.h>

#include "client/link/failure.h"
#include "client/rebuilt/gliding_sea.h"
#include "client/rebuilt/held_glides.h"
#include "client/rebuilt/wave_keyframes.h"
#include "sea/basics/dispersion.h"
#include "sea/waves/quantised_spectrum.h"
#include "sea/waves/realize.h"
#include "sea/waves/spectrum_builder.h"
#include "tests/client/announced_scene.h"
#include "tests/support/explicit_sea.h"

namespace seaway::client {
namespace {

constexpr sea::TimeUs glide_start_us = 90'000'001, glide_end_us = 150'000'000;

struct Change {
    const char* name;
    double wind_mps;
    double depth_m;
    double loop_s;
};

sea::RealizationPtr waves_of(const Change& change) {
    sea::SeaState sea = tests::announced_scene().sea;
    std::get<sea::WindSea>(sea.systems[0]).wind_speed_10m_mps = change.wind_mps;
    sea.depth_m = change.depth_m;
    sea.loop_period_s = change.loop_s;
    return std::make_shared<const sea::Realization>(
        *sea::realize(sea, tests::announced_scene().cascades));
}

TEST(GlidingSea, is_the_transition_that_the_server_makes_at_every_time) {
    const protocol::SeaStateValues state = tests::announced();
    const sea::RealizationPtr before = waves_of({"", 9, 30, 0});
    std::mt19937_64 random(9);
    std::uniform_real_distribution<double> place(-1e4, 1e4);
    for (const Change& change : {Change{"wind", 14, 30, 0},
                                 {"depth", 9, 6, 0},
                                 {"loop", 12, 30, 40},
                                 {"all", 5, 12, 70}}) {
        const auto made =
            sea::SeaTransition::create(before, waves_of(change), glide_start_us, glide_end_us);
        ASSERT_TRUE(made);
        // What a server sends: the waves as the glide ends in them.
        const RebuiltSea from(before, state, {}), to(made->after(), state, {});
        const auto glide = GlidingSea::create(state, from, to, glide_start_us, glide_end_us);
        ASSERT_TRUE(glide) << glide.error().message;
        for (const sea::TimeUs time_us :
             {glide_start_us - 5'000'000, glide_start_us, glide_start_us + 1,
              sea::TimeUs{100'000'000}, sea::TimeUs{129'999'999}, glide_end_us - 1, glide_end_us,
              glide_end_us + 70'000'000}) {
            const sea::DirectSum truth(made->at(time_us), made->growing_at(time_us));
            for (int i = 0; i < 5; ++i) {
                const double x_m = place(random), y_m = place(random);
                const sea::LagrangianPoint a = truth.at(x_m, y_m, time_us);
                sea::LagrangianPoint b;
                (*glide)->at(time_us,
                             [&](const RebuiltSea& own) { b = own.sum().at(x_m, y_m, time_us); });
                EXPECT_NEAR(a.height, b.height, 1e-9) << change.name << " at " << time_us;
                EXPECT_NEAR(a.height_rate, b.height_rate, 1e-9) << change.name;
                EXPECT_NEAR(a.displacement_x, b.displacement_x, 1e-9) << change.name;
            }
        }
    }
}

// At its grid points a keyframe is the sum of its cascade's waves, and its rates are what that changes by: waves that move, that
// grow, and that reach further sideways as it becomes shallower. Single precision leaves 2e-6 of 1 m; differences over
// 2 ms miss w^3 (1 ms)^2 / 6 of a wave, 2e-5 of 0.5 m at 5 rad/s.
TEST(GlidingSea, has_keyframes_of_its_waves_and_of_what_they_grow_by) {
    const protocol::SeaStateValues state = tests::announced();
    const sea::RealizationPtr before = waves_of({"", 9, 30, 0});
    for (const Change& change : {Change{"wind", 14, 30, 0}, {"wind and depth", 13, 6, 0}}) {
        const auto made =
            sea::SeaTransition::create(before, waves_of(change), glide_start_us, glide_end_us);
        ASSERT_TRUE(made);
        const RebuiltSea from(before, state, {}), to(made->after(), state, {});
        const auto glide = GlidingSea::create(state, from, to, glide_start_us, glide_end_us);
        ASSERT_TRUE(glide) << glide.error().message;
        WaveKeyframes keyframes(*glide);
        for (const sea::TimeUs time_us :
             {glide_start_us - 3'000'000, glide_start_us, sea::TimeUs{105'000'000},
              sea::TimeUs{120'000'000}, glide_end_us, glide_end_us + 5'000'000})
            for (const int cascade : {0, 1}) {
                const auto keyframe = keyframes.make(3, cascade, time_us);
                ASSERT_TRUE(keyframe);
                EXPECT_EQ(keyframe->epoch, 3u);
                EXPECT_EQ(keyframe->time_us, time_us);
                EXPECT_EQ(keyframe->fields, sea::surface_fields);
                const double spacing_m = keyframe->length_m / keyframe->size;
                const auto at = [&](sea::TimeUs then_us) {
                    return std::make_shared<const sea::DirectSum>(made->gliding(then_us));
                };
                const auto now = at(time_us), before_it = at(time_us - 1000),
                           behind = at(time_us + 1000);
                for (int i = 0; i < 40; ++i) {
                    const int x = i * 7 % keyframe->size, y = i * 11 % keyframe->size;
                    const auto value = [&](const sea::DirectSum& sum, sea::TimeUs then_us,
                                           sea::Field field) {
                        return sea::value_of(
                            sum.at_time(then_us, 1u << cascade).at(x * spacing_m, y * spacing_m),
                            field);
                    };
                    for (const auto& [field, rate] :
                         {std::pair(sea::Field::height, sea::Field::height_rate),
                          {sea::Field::displacement_x, sea::Field::displacement_x_rate},
                          {sea::Field::displacement_y, sea::Field::displacement_y_rate}}) {
                        const auto place = static_cast<std::size_t>(y * keyframe->size + x);
                        EXPECT_NEAR(keyframe->plane(field)[place], value(*now, time_us, field),
                                    1e-5)
                            << change.name << " at " << time_us;
                        const double change_mps = (value(*behind, time_us + 1000, field) -
                                                   value(*before_it, time_us - 1000, field)) /
                                                  0.002;
                        EXPECT_NEAR(keyframe->plane(rate)[place], change_mps, 2e-4)
                            << change.name << " at " << time_us;
                    }
                }
            }
    }
}

/// As a client has them whom those were sent that are large enough.
RebuiltSea told_of(const sea::Realization& waves, double depth_m, double error_m) {
    sea::SeaState sea = tests::announced_scene().sea;
    sea.depth_m = depth_m;
    sea::SpectrumFrame frame{.tiles = {},
                             .choppiness = waves.choppiness,
                             .dispersion = sea.dispersion(),
                             .loop_period_us = waves.loop_period_us};
    for (const sea::CascadeModes& modes : waves.cascades)
        frame.tiles.push_back({modes.spec, modes.band, modes.carries_spectra});
    const sea::QuantisedSpectrum sent = sea::quantise(waves, {error_m});
    sea::SpectrumBuilder builder = *sea::SpectrumBuilder::create(frame, sent.steps);
    for (const sea::WaveBlock& block : sent.blocks)
        EXPECT_TRUE(builder.add(block));
    return RebuiltSea(std::make_shared<const sea::Realization>(builder.sea()), tests::announced(),
                      {sea::bound_sigmas * sent.left.back().height_m,
                       sea::bound_sigmas * sent.left.back().displacement_m});
}

// Naive: who is not told of a small wave of the new sea takes it for none, and lets the old one fade at its old frequency.
TEST(GlidingSea, turns_waves_that_fade_into_smaller_ones_than_are_told_by_the_law_of_the_new_sea) {
    const auto before = waves_of({"", 9, 30, 0});
    const auto made = sea::SeaTransition::create(before, waves_of({"calmer and shallow", 2, 3, 0}),
                                                 glide_start_us, glide_end_us);
    ASSERT_TRUE(made);
    const RebuiltSea from = told_of(*before, 30, 0.01), to = told_of(*made->after(), 3, 0.05);
    const auto glide =
        GlidingSea::create(tests::announced(), from, to, glide_start_us, glide_end_us);
    ASSERT_TRUE(glide) << glide.error().message;
    for (const sea::TimeUs time_us : {glide_start_us + 1, sea::TimeUs{100'000'000},
                                      sea::TimeUs{120'000'000}, glide_end_us - 1}) {
        const sea::DirectSum truth(made->at(time_us)), own((*glide)->waves_at(time_us));
        for (int i = 0; i < 20; ++i) {
            const double x_m = 37.0 * i, y_m = -91.0 * i;
            EXPECT_NEAR(truth.at(x_m, y_m, time_us).height, own.at(x_m, y_m, time_us).height,
                        (*glide)->error().height_m)
                << time_us;
        }
    }
}

TEST(GlidingSea, answers_of_a_time_are_those_of_its_waves_in_whatever_order_times_come) {
    const protocol::SeaStateValues state = tests::announced();
    const RebuiltSea from(waves_of({"", 9, 30, 0}), state, {0.01, 0.002});
    const RebuiltSea to(waves_of({"", 12, 30, 0}), state, {0.004, 0.03});
    const auto glide = GlidingSea::create(state, from, to, glide_start_us, glide_end_us);
    ASSERT_TRUE(glide);
    EXPECT_EQ((*glide)->error().height_m, 0.01);
    EXPECT_EQ((*glide)->error().displacement_m, 0.03);
    const std::vector<sea::QueryPoint> points{
        {1, 2, 120'000'000}, {3, 4, 120'000'000}, {1, 2, 100'000'000}, {1, 2, 120'000'000}};
    std::vector<sea::Answer> answers(points.size());
    (*glide)->answer(points, answers, {});
    EXPECT_EQ(answers[0].height_m, answers[3].height_m);
    EXPECT_NE(answers[0].height_m, answers[2].height_m);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const RebuiltSea moment((*glide)->waves_at(points[i].time_us), state, (*glide)->error());
        sea::Answer alone;
        moment.answer({&points[i], 1}, {&alone, 1}, {});
        EXPECT_EQ(answers[i].height_m, alone.height_m);
        EXPECT_EQ(answers[i].error_m, alone.error_m);
    }
}

// Naive: what was stated where a wave was rounded. In two metres of water one of a kilometre moves things twenty times as far sideways
// as in the deep, its rounding too.
TEST(GlidingSea, waves_that_were_rounded_in_deep_water_are_as_far_off_as_where_it_is_shallow) {
    const auto sea_of = [](double depth_m) {
        sea::CascadeModes modes = tests::calm_cascade(2000.0, 64);
        modes.depth_m = depth_m;
        tests::add_wave(modes, 2, 0, 0.3, 0.1);
        return tests::make_sea({modes});
    };
    const protocol::SeaStateValues state = tests::announced();
    const RebuiltError error{.height_m = 0.01, .displacement_m = 0.01, .strain = 1e-4};
    const double k = sea::two_pi / 1000, there = sea::orbit_aspect(k, 2.0);
    for (const bool turned : {false, true}) {
        const RebuiltSea deep(sea_of(2000), state, turned ? RebuiltError{} : error);
        const RebuiltSea shallow(sea_of(2), state, turned ? error : RebuiltError{});
        const auto glide = GlidingSea::create(state, deep, shallow, glide_start_us, glide_end_us);
        ASSERT_TRUE(glide) << glide.error().message;
        const RebuiltError stated = (*glide)->error();
        EXPECT_NEAR(stated.height_m, 0.01, 1e-12);
        const double wider = turned ? 1 : there / sea::orbit_aspect(k, 2000);
        EXPECT_NEAR(stated.displacement_m, 0.01 * wider, 1e-6 * wider);
        EXPECT_NEAR(stated.strain, 1e-4 * wider, 1e-8 * wider);
    }
    EXPECT_GT(there, 19);
}

TEST(GlidingSea, between_seas_of_other_tiles_there_is_none) {
    const protocol::SeaStateValues state = tests::announced();
    auto other = std::make_shared<sea::Realization>(*waves_of({"", 9, 30, 0}));
    other->cascades.pop_back();
    const RebuiltSea from(waves_of({"", 9, 30, 0}), state, {}), to(other, state, {});
    const auto glide = GlidingSea::create(state, from, to, glide_start_us, glide_end_us);
    ASSERT_FALSE(glide);
    EXPECT_EQ(failure_of(glide.error()), Failure::not_held);
}

class HeldGlidesOf : public ::testing::Test {
  protected:
    const protocol::SeaStateValues state = tests::announced();
    const OwnSeaPtr from = sea_of(9), to = sea_of(12);
    HeldGlides held;
    std::vector<std::weak_ptr<const OwnSea>> made;

    OwnSeaPtr sea_of(double wind_mps) const {
        return std::make_shared<const RebuiltSea>(waves_of({"", wind_mps, 30, 0}), state,
                                                  RebuiltError{});
    }
    /// Asked about within it, as a client does.
    OwnSeaPtr of_epoch(std::uint32_t epoch, sea::TimeUs end_us) {
        const GlideEnds ends{to, from};
        if (const OwnSeaPtr glide = held.find(epoch, ends))
            return glide;
        const OwnSeaPtr glide = *GlidingSea::create(state, *from, *to, end_us - 1'000'000, end_us);
        const sea::QueryPoint point{1, 2, end_us - 500'000};
        sea::Answer answer;
        glide->answer({&point, 1}, {&answer, 1}, {});
        held.keep(epoch, end_us, ends, glide);
        made.push_back(glide);
        return glide;
    }
    auto living() const {
        return std::ranges::count_if(made, [](const auto& glide) { return !glide.expired(); });
    }
};

// Naive: each is held as long as its sea state is known, 256 of them: 19 GB of three cascades of 256.
TEST_F(HeldGlidesOf, a_sea_that_changes_forty_times_are_four) {
    for (std::uint32_t epoch = 0; epoch < 40; ++epoch) {
        of_epoch(epoch, 10'000'000 * epoch);
        EXPECT_LE(living(), 4) << epoch;
    }
    const OwnSeaPtr used = of_epoch(36, 0);
    for (std::uint32_t epoch = 40; epoch < 43; ++epoch)
        of_epoch(epoch, 0);
    EXPECT_EQ(of_epoch(36, 0), used) << "those that were asked about last";
    EXPECT_EQ(made.size(), 43u) << "and none was made twice";
}

TEST_F(HeldGlidesOf, a_sea_that_stays_are_none_once_they_have_ended_and_nobody_asks) {
    of_epoch(1, 10'000'000);
    of_epoch(2, 20'000'000);
    EXPECT_TRUE(held.let_go_ended(15'000'000).empty()) << "the first was asked about just now";
    EXPECT_EQ(held.let_go_ended(15'000'000), std::vector<std::uint32_t>{1});
    EXPECT_TRUE(held.let_go_ended(15'000'000).empty()) << "the second runs";
    EXPECT_EQ(held.let_go_ended(20'000'000), std::vector<std::uint32_t>{2});
    EXPECT_EQ(living(), 0);
}

TEST_F(HeldGlidesOf, a_sea_are_made_anew_where_more_of_its_waves_have_come) {
    const OwnSeaPtr glide = of_epoch(1, 10'000'000);
    EXPECT_EQ(held.find(1, {to, from}), glide);
    EXPECT_EQ(held.find(1, {to, sea_of(9)}), nullptr);
    EXPECT_EQ(held.find(1, {sea_of(12), from}), nullptr);
    EXPECT_EQ(held.find(1, {to}), nullptr);
    EXPECT_EQ(held.find(2, {to, from}), nullptr);
    held.forget(1);
    EXPECT_EQ(held.find(1, {to, from}), nullptr);
}

} // namespace
} // namespace seaway::client
