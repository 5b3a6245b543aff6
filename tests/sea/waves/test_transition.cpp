// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sea/waves/transition.h"
#include "tests/sea/sea_fixture.h"

namespace seaway::sea {
namespace {

using testing::hs_of;
using testing::realized;
using testing::three_cascades;
using testing::windy_sea;

double height(const RealizationPtr& sea, TimeUs t) {
    return DirectSum(sea).at(3.0, 4.0, t).height;
}

// Naive: a new draw or a phase reset, and the sea jumps.
TEST(Transition, A22_a_small_gust_moves_the_sea_little) {
    SeaState stronger = windy_sea();
    std::get<WindSea>(stronger.systems[0]).wind_speed_10m_mps += 0.01;
    const auto before = realized(windy_sea(), three_cascades);
    const auto after = realized(stronger, three_cascades);
    for (const double t : {0.0, 1e3, 1e6})
        EXPECT_LT(std::abs(height(after, us_from_seconds(t)) - height(before, us_from_seconds(t))),
                  0.01 * hs_of(before));
}

// Naive: omega'(depth) * t is 100 rad after a day.
TEST(Transition, I7_a_change_of_depth_keeps_every_phase) {
    SeaState shallow = windy_sea();
    shallow.depth_m = 12.0;
    const auto old_sea = realized(windy_sea(), three_cascades);
    const auto new_sea = realized(shallow, three_cascades);
    const TimeUs start = us_from_seconds(1e6);
    const auto change = SeaTransition::create(old_sea, new_sea, start, start + 2'000'000);
    ASSERT_TRUE(change);
    const TimeUs frame = 16'667;
    double normal = 0.0, during = 0.0;
    for (int i = 0; i < 60; ++i) {
        const TimeUs t = start - 30 * frame + i * frame;
        normal = std::max(normal, std::abs(height(old_sea, t + frame) - height(old_sea, t)));
        during = std::max(
            during, std::abs(height(change->at(t + frame), t + frame) - height(change->at(t), t)));
    }
    EXPECT_LT(during, 3.0 * normal);
    // Without the offsets the two seas have nothing to do with each other.
    EXPECT_GT(std::abs(height(new_sea, start) - height(old_sea, start)), 3.0 * normal);
    EXPECT_NEAR(height(change->at(start), start), height(old_sea, start), 1e-9);
}

TEST(Transition, amplitudes_glide_from_the_old_to_the_new) {
    SeaState stronger = windy_sea();
    std::get<WindSea>(stronger.systems[0]).wind_speed_10m_mps = 20.0;
    const auto old_sea = realized(windy_sea(), three_cascades);
    const auto new_sea = realized(stronger, three_cascades);
    const auto change = SeaTransition::create(old_sea, new_sea, 5'000'000, 6'000'000);
    double last = hs_of(old_sea) * (1 - 1e-12);
    for (TimeUs t = 4'900'000; t <= 6'100'000; t += 50'000) {
        const double now = hs_of(change->at(t));
        EXPECT_GE(now, last * (1 - 1e-12));
        last = now;
    }
    EXPECT_EQ(change->at(4'999'999), old_sea);
    EXPECT_NEAR(last / hs_of(new_sea), 1.0, 1e-12);
}

// Naive: the share of the glide rounds to more than one in the last seconds of a long one, the inverse of a depth that
// glides to infinity is less than nothing, and what is 1e16 m deep the wrong way moves sideways twenty times as far.
TEST(Transition, to_deep_water_the_depth_grows_and_sideways_motion_shrinks_to_the_last_moment) {
    SeaState shallow = windy_sea(), deep = windy_sea();
    shallow.depth_m = 20.0;
    deep.depth_m = deep_water_m;
    const auto from = realized(shallow, three_cascades), to = realized(deep, three_cascades);
    for (const TimeUs glide_us :
         {TimeUs{3600} * 1'000'000, TimeUs{86'400} * 1'000'000, glide_us_max}) {
        const auto change = SeaTransition::create(from, to, 0, glide_us);
        ASSERT_TRUE(change);
        double last_m = 20.0;
        for (TimeUs left_us = 15'000'000; left_us > 0;
             left_us -= left_us > 2'000 ? 999 * left_us / 50'000 : 7) {
            const double share = glide_share(glide_us - left_us, 0, glide_us);
            ASSERT_LE(share, 1.0) << left_us;
            // As a glide mixes it: at() would make 200 seas of it.
            const double inverse = glided(1.0 / 20.0, 1.0 / deep_water_m, share);
            ASSERT_GE(inverse, 0.0) << left_us;
            // Below the last bits of the share.
            ASSERT_GE(1.0 / inverse, std::min(last_m, 1e9) * (1 - 1e-6)) << left_us;
            last_m = 1.0 / inverse;
        }
        const auto sideways = [&](const RealizationPtr& sea) {
            return DirectSum(sea).at(3.0, 4.0, 0).displacement_x;
        };
        for (const TimeUs left_us : {50'000, 100'000, 200'000, 400'000, 12'000'000})
            EXPECT_NEAR(sideways(change->at(glide_us - left_us)), sideways(change->at(glide_us)),
                        1e-3)
                << left_us;
    }
}

// Naive: the water glides and the picture's points jump sideways.
TEST(Transition, choppiness_glides_from_that_of_the_old_sea_to_that_of_the_new) {
    SeaState flatter = windy_sea(), steeper = windy_sea();
    flatter.choppiness = {0.7, 1.6};
    steeper.choppiness = {1.2, 0.3};
    const auto old_sea = realized(flatter, three_cascades);
    const auto new_sea = realized(steeper, three_cascades);
    const auto change = SeaTransition::create(old_sea, new_sea, 5'000'000, 6'000'000);
    const Choppiness first = change->at(5'000'000)->choppiness;
    const Choppiness middle = change->at(5'500'000)->choppiness;
    const Choppiness last = change->at(6'000'000)->choppiness;
    EXPECT_EQ(first.x, 0.7);
    EXPECT_EQ(first.y, 1.6);
    EXPECT_NEAR(middle.x, 0.95, 1e-12);
    EXPECT_NEAR(middle.y, 0.95, 1e-12);
    EXPECT_EQ(last.x, 1.2);
    EXPECT_EQ(last.y, 0.3);
}

TEST(Transition, a_chain_of_changes_back_to_the_same_depth_leaves_a_phase_but_no_jump) {
    SeaState shallow = windy_sea();
    shallow.depth_m = 12.0;
    const auto deep_sea = realized(windy_sea(), three_cascades);
    const auto shallow_sea = realized(shallow, three_cascades);
    const auto down = SeaTransition::create(deep_sea, shallow_sea, 1'000'000, 2'000'000);
    const auto up = SeaTransition::create(down->after(), deep_sea, 9'000'000, 10'000'000);
    const TimeUs at = 9'000'000;
    EXPECT_NEAR(height(up->at(at), at), height(down->at(at), at), 1e-9);
    EXPECT_NEAR(hs_of(up->after()) / hs_of(deep_sea), 1.0, 1e-12);
    // The same history gives the same bits.
    const auto again = SeaTransition::create(down->after(), deep_sea, 9'000'000, 10'000'000);
    EXPECT_EQ(again->after()->cascades[0].h0, up->after()->cascades[0].h0);
}

// Naive: they begin with the phase that a wave of no frequency would have: a sea hangs on what it glided from.
TEST(Transition, waves_that_only_the_new_sea_has_are_those_of_its_scene) {
    SeaState before, after;
    before.systems = {ExplicitModes{100.0, {{3, 0, 1.0, 0.3}}}};
    after.systems = {ExplicitModes{100.0, {{0, 5, 0.5, 0.7}}}};
    const std::vector<CascadeSpec> tiles{{37.0, 64}};
    const auto new_sea = realized(after, tiles);
    const auto change =
        SeaTransition::create(realized(before, tiles), new_sea, 8'000'000, 20'000'000);
    for (const TimeUs t : {20'000'000, 777'000'000})
        EXPECT_EQ(height(change->at(t), t), height(new_sea, t));
}

// What bounds are made of: no moment of the glide has a larger wave, more choppiness or shallower water.
TEST(Transition, the_envelope_holds_every_wave_of_every_moment) {
    SeaState before = windy_sea(), after = windy_sea();
    std::get<WindSea>(after.systems[0]).wind_speed_10m_mps = 16.0;
    std::get<WindSea>(after.systems[0]).towards_rad += 1.0; // some waves grow, others go
    after.seed = 99;
    after.depth_m = 30.0;
    before.choppiness = {1.3, 0.4};
    const auto change = SeaTransition::create(realized(before, three_cascades),
                                              realized(after, three_cascades), 0, 20'000'000);
    const RealizationPtr most = change->envelope();
    for (const TimeUs t : {-1, 1, 5'000'000, 10'000'000, 15'000'000, 20'000'000}) {
        const RealizationPtr now = change->gliding(t);
        EXPECT_LE(now->choppiness.x, most->choppiness.x);
        EXPECT_LE(now->choppiness.y, most->choppiness.y);
        for (std::size_t c = 0; c < 3; ++c) {
            EXPECT_GE(now->cascades[c].depth_m, most->cascades[c].depth_m * (1 - 1e-12));
            for (std::size_t i = 0; i < now->cascades[c].h0.size(); ++i)
                ASSERT_LE(std::abs(now->cascades[c].h0[i]),
                          std::abs(most->cascades[c].h0[i]) * (1 + 1e-12));
        }
    }
}

SineRamps one_of(SineKind kind, double amplitude_m) {
    SineRamps ramps;
    ramps.kind = kind;
    ramps.length_m = 100.0;
    ramps.count = 1;
    ramps.amplitude_m = amplitude_m;
    ramps.wavelength_m = 33.3;
    return ramps;
}

ExplicitModes one_mode(int nx, int ny, double amplitude_m) {
    return {100.0, {{nx, ny, amplitude_m, 0.3}}};
}

struct Glide {
    const char* waves;
    WaveSystem old_system;
    WaveSystem new_system;
    CascadeSpec cascade;
};

/// From 8 to 14 s after `base_us`, to a loop of 10 s.
void expect_no_jump(const Glide& glide, double old_loop_s, TimeUs base_us) {
    const TimeUs start = base_us + 8'000'000, wraps = base_us + 10'000'000,
                 end = base_us + 14'000'000, step = 1000;
    SeaState before, after;
    before.systems = {glide.old_system};
    before.loop_period_s = old_loop_s;
    after.systems = {glide.new_system};
    after.loop_period_s = 10.0;
    const auto change = SeaTransition::create(realized(before, {glide.cascade}),
                                              realized(after, {glide.cascade}), start, end);
    ASSERT_TRUE(change);
    for (const TimeUs edge : {start, base_us + 9'000'000, wraps, end, base_us + 20'000'000}) {
        const std::string where =
            fmt::format("{} from a loop of {} s at {}", glide.waves, old_loop_s, edge);
        EXPECT_NEAR(height(change->at(edge - 1), edge - 1), height(change->at(edge), edge), 2e-5)
            << where;
        if (edge == start || edge == end)
            continue;
        // The waves of one moment, run on over the edge: differences are off by h^2 w^3/6.
        const DirectSum sum(change->at(edge - 1));
        const auto rise =
            sum.at(3.0, 4.0, edge + step).height - sum.at(3.0, 4.0, edge - step).height;
        EXPECT_NEAR(rise / (2e-6 * step), sum.at(3.0, 4.0, edge).height_rate, 1e-3) << where;
    }
}

// The loop of the new sea begins anew at 10 s, within the glide; a wave of 1 m moves by 1e-6 m in a
// microsecond. Naive: what only the old sea has, and what has frequencies of its own in each, jumps by
// up to 1 m there.
TEST(Transition,
     a_glide_over_the_end_of_a_loop_is_without_a_jump_and_its_rates_are_those_of_its_heights) {
    const CascadeSpec same_tile{100.0, 64}, other_tile{37.0, 64};
    WindSea fresh, strong;
    fresh.wind_speed_10m_mps = 6.0;
    strong.wind_speed_10m_mps = 8.0;
    const std::vector<Glide> glides{
        {"sine", one_of(SineKind::sine, 1.0), one_of(SineKind::sine, 1.1), same_tile},
        {"exponential", one_of(SineKind::exponential, 1.0), one_of(SineKind::exponential, 1.1),
         same_tile},
        {"noise", one_of(SineKind::noise, 1.0), one_of(SineKind::noise, 1.1), same_tile},
        {"modes", one_mode(3, 0, 1.0), one_mode(3, 0, 0.5), same_tile},
        {"modes that fade", one_mode(3, 0, 1.0), one_mode(0, 5, 0.5), same_tile},
        {"modes that fade on a tile of their own", one_mode(3, 0, 1.0), one_mode(0, 5, 0.5),
         other_tile},
        {"wind sea", fresh, strong, same_tile}};
    // Whole loops of all of them. Far out, what rounding leaves of a turn a loop is a part of a turn.
    const TimeUs loops_us = 6570 * TimeUs{1'000'000};
    for (const Glide& glide : glides)
        for (const double old_loop_s : {0.0, 7.3, 9.0})
            for (const TimeUs loops : {0, 150'000'000})
                expect_no_jump(glide, old_loop_s, loops * loops_us);
}

// A sea in the middle of a glide is one to glide from.
TEST(Transition, a_glide_that_takes_over_from_another_goes_on_without_a_jump) {
    SeaState first, second;
    first.systems = {one_of(SineKind::sine, 1.0), one_mode(3, 0, 1.0)};
    first.loop_period_s = 7.3;
    second.systems = {one_of(SineKind::sine, 0.5), one_mode(0, 5, 0.5)};
    second.loop_period_s = 10.0;
    const std::vector<CascadeSpec> tiles{{37.0, 64}};
    const auto one = SeaTransition::create(realized(first, tiles), realized(second, tiles),
                                           8'000'000, 14'000'000);
    const TimeUs taken_over = 11'000'000; // after the new loop has begun anew
    const auto other =
        SeaTransition::create(one->at(taken_over), realized(first, tiles), taken_over, 16'000'000);
    EXPECT_NEAR(height(other->at(taken_over), taken_over), height(one->at(taken_over), taken_over),
                1e-9);
    const TimeUs wraps = 14'600'000;
    EXPECT_NEAR(height(other->at(wraps - 1), wraps - 1), height(other->at(wraps), wraps), 2e-5);
}

// Naive: waves of a list stay where they stood, whatever phases it gives them; those of another seed or of a system that
// has moved up have phases of waves that are not theirs.
TEST(Transition, stylised_waves_that_run_as_those_before_have_the_phases_of_their_scene) {
    const auto listed = [](double phase_rad) {
        SineRamps list = one_of(SineKind::sine, 1.0);
        list.by_hand = {{33.3, 1.0, 0.4, phase_rad, 0.0}};
        return list;
    };
    const auto spread = [](SineKind kind, double wavelength_m) {
        SineRamps ramps = one_of(kind, 1.0);
        ramps.count = 5;
        ramps.wavelength_m = wavelength_m;
        ramps.direction_spread_rad = 1.0;
        return ramps;
    };
    struct Change {
        const char* what;
        std::vector<WaveSystem> before, after;
        std::uint64_t seed = 1; ///< of the new sea
    };
    const std::vector<Change> changes{
        {"another phase", {listed(0.0)}, {listed(1.5)}},
        {"another seed", {spread(SineKind::sine, 33.3)}, {spread(SineKind::sine, 33.3)}, 2},
        {"noise of another seed",
         {spread(SineKind::noise, 33.3)},
         {spread(SineKind::noise, 33.3)},
         2},
        {"without the first",
         {spread(SineKind::exponential, 50.0), spread(SineKind::exponential, 20.0)},
         {spread(SineKind::exponential, 20.0)}}};
    for (const Change& change : changes) {
        SeaState before, after;
        before.systems = change.before;
        before.seed = 1;
        after.systems = change.after;
        after.seed = change.seed;
        const auto new_sea = realized(after, {{100.0, 64}});
        const auto glide =
            SeaTransition::create(realized(before, {{100.0, 64}}), new_sea, 8'000'000, 20'000'000);
        ASSERT_TRUE(glide);
        for (const TimeUs t : {20'000'000, 777'000'000})
            EXPECT_EQ(height(glide->at(t), t), height(new_sea, t)) << change.what;
    }
}

// Naive: what fades turns as before and what grows as in the new depth, and halfway they cancel each other every 49 s.
TEST(Transition, stylised_waves_of_both_seas_turn_as_one_where_the_depth_changes) {
    for (const SineKind kind : {SineKind::sine, SineKind::exponential, SineKind::noise}) {
        SineRamps ramps = one_of(kind, 1.0);
        ramps.wavelength_m = 64.0;
        ramps.length_m = 640.0;
        SeaState deep, shallow;
        deep.systems = shallow.systems = {ramps};
        shallow.depth_m = 10.0;
        const auto from = realized(deep, {{640.0, 128}}), to = realized(shallow, {{640.0, 128}});
        const auto glide = SeaTransition::create(from, to, 7'000'000, 607'000'000);
        ASSERT_TRUE(glide);
        for (TimeUs t = 7'000'000; t < 607'000'000; t += 9'876'543)
            EXPECT_NEAR(height(glide->gliding(t), t), height(glide->after(), t), 1e-9) << t;
        EXPECT_NEAR(height(glide->at(7'000'000), 7'000'000), height(from, 7'000'000), 1e-9);
    }
}

// Naive: a sea that glides has each field twice, and of those one went on at the depth before: 60 % of the height every 33 s, and
// less towards the middle.
TEST(Transition, stylised_waves_turn_as_one_where_a_depth_takes_over_from_a_glide_to_another) {
    for (const SineKind kind : {SineKind::sine, SineKind::exponential, SineKind::noise}) {
        SineRamps ramps = one_of(kind, 1.0);
        ramps.wavelength_m = 64.0;
        ramps.length_m = 640.0;
        const auto at_depth = [&](double depth_m) {
            SeaState sea;
            sea.systems = {ramps, ramps};
            sea.depth_m = depth_m;
            return realized(sea, {{640.0, 128}});
        };
        RealizationPtr sea = at_depth(100.0);
        TimeUs start = 7'000'000;
        for (const double depth_m : {10.0, 5.0, 20.0}) {
            const TimeUs end = start + 600'000'000;
            const auto glide = SeaTransition::create(sea, at_depth(depth_m), start, end);
            ASSERT_TRUE(glide);
            for (TimeUs t = start; t < end; t += 9'876'543)
                EXPECT_NEAR(height(glide->gliding(t), t), height(glide->after(), t), 1e-9)
                    << depth_m << " m, " << t;
            EXPECT_NEAR(height(glide->at(start), start), height(sea, start), 1e-9) << depth_m;
            start += 200'000'000;
            sea = glide->gliding(start);
        }
    }
}

/// Waves that drag those behind them along by as much as they are high.
SineRamps dragging(double amplitude_m) {
    SineRamps ramps = one_of(SineKind::exponential, amplitude_m);
    ramps.count = 4;
    ramps.drag = 1.0;
    return ramps;
}

// Naive: two halves of a field drag half as far, and less is no field with a minus before it.
TEST(Transition, waves_that_drag_others_glide_as_sums_of_two_fields) {
    SeaState high, low;
    high.systems = {dragging(10.0)};
    low.systems = {dragging(4.0)};
    const std::vector<CascadeSpec> tile{{100.0, 64}};
    const auto sea = realized(high, tile);
    const auto nowhere = SeaTransition::create(sea, sea, 0, 10'000'000);
    const auto down = SeaTransition::create(sea, realized(low, tile), 0, 10'000'000);
    for (const TimeUs t : {1'000'000, 5'000'000, 9'000'000}) {
        EXPECT_NEAR(height(nowhere->gliding(t), t), height(sea, t), 1e-12);
        EXPECT_NEAR(height(nowhere->growth(t), t), 0.0, 1e-12);
        const TimeUs step = 1000;
        const double rise = (height(down->gliding(t + step), t + step) -
                             height(down->gliding(t - step), t - step)) /
                            (2e-6 * static_cast<double>(step));
        const double waves = DirectSum(down->gliding(t)).at(3.0, 4.0, t).height_rate;
        const double growth = glide_rate(t, 0, 10'000'000) * height(down->growth(t), t);
        EXPECT_NEAR(rise, waves + growth, 1e-4) << t; // h^2 w^3 / 6 of the difference
        EXPECT_GT(std::abs(growth), 1e-3) << "else this says nothing";
    }
}

TEST(Transition, a_cascade_that_is_wanted_alone_is_that_of_the_whole_and_the_others_are_not_there) {
    SeaState other = windy_sea();
    std::get<WindSea>(other.systems[0]).wind_speed_10m_mps = 20.0;
    other.depth_m = 12.0;
    other.choppiness = {0.5, 0.7};
    const auto change = SeaTransition::create(realized(windy_sea(), three_cascades),
                                              realized(other, three_cascades), 0, 10'000'000);
    const TimeUs t = 3'000'000;
    const std::pair<RealizationPtr, RealizationPtr> all_and_one[] = {
        {change->gliding(t), change->gliding(t, 2u)},
        {change->growth(t), change->growth(t, 2u)},
        {change->displacement_growth(t), change->displacement_growth(t, 2u)}};
    for (const auto& [all, one] : all_and_one) {
        EXPECT_EQ(one->choppiness, all->choppiness);
        EXPECT_EQ(one->loop_period_us, all->loop_period_us);
        ASSERT_EQ(one->cascades.size(), 3u);
        for (std::size_t c = 0; c < 3; ++c) {
            EXPECT_EQ(one->cascades[c].is_there(), c == 1);
            EXPECT_EQ(one->cascades[c].spec.size, all->cascades[c].spec.size);
        }
        EXPECT_EQ(one->cascades[1].h0, all->cascades[1].h0);
        EXPECT_EQ(one->cascades[1].depth_m, all->cascades[1].depth_m);
        EXPECT_LT(bytes_of(*one), bytes_of(*all) / 2);
    }
}

TEST(Transition, refuses_other_tiles) {
    const auto a = realized(windy_sea(), three_cascades);
    const auto b = realized(windy_sea(), {{512.0, 128}, {97.0, 64}, {19.0, 64}});
    EXPECT_THAT(SeaTransition::create(a, b, 0, 1).error().message,
                ::testing::HasSubstr("same cascades"));
}

} // namespace
} // namespace seaway::sea
