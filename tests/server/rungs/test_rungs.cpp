// SPDX-License-Identifier: Apache-2.0
// Coarser maps: smaller ones, fewer keyframes. What they state holds, and says something.
#include <cmath>
#include <ostream>
#include <random>

#include <gtest/gtest.h>

#include "server/host/grant.h"
#include "tests/server/rungs/stream_of.h"

namespace seaway::tests {
namespace {

using server::Demand;

struct Case {
    const char* scene;
    bool compact;
    int size_max;
    float rate_hz_max;

    friend std::ostream& operator<<(std::ostream& out, const Case& one) {
        return out << one.scene << (one.compact ? " compact, size " : " whole, size ")
                   << one.size_max << ", rate " << one.rate_hz_max;
    }
};

Demand wish_of(const Case& wanted) {
    return {.cascades = ~0u,
            .fields = sea::surface_fields,
            .compact = wanted.compact,
            .rate_hz_max = wanted.rate_hz_max,
            .size_max = wanted.size_max};
}

struct Errors {
    int answers = 0;
    int flagged = 0; ///< folds, or may: no bound is promised
    int beyond = 0;
    double square = 0;
    double stated_square = 0;

    double rms() const { return std::sqrt(square / answers); }
    /// What they state, as a standard deviation.
    double stated_rms() const { return std::sqrt(stated_square / answers) / sea::bound_sigmas; }
};

/// At random places within a kilometre and times within a day.
Errors errors_of(StreamOf& stream, int times, int places) {
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> place(-1000, 1000);
    std::uniform_int_distribution<sea::TimeUs> time(0, 86'400'000'000);
    const server::RunningSea& sea = stream.sea();
    Errors errors;
    for (int i = 0; i < times; ++i) {
        const sea::TimeUs time_us = time(random);
        stream.hold(time_us);
        const auto surface = stream.surface(time_us);
        EXPECT_TRUE(surface && surface->covers);
        const auto truth = sea.truth->at_time(time_us);
        for (int j = 0; surface && j < places; ++j) {
            const sea::QueryPoint point{place(random), place(random), time_us};
            const sea::Answer answer = surface->surface.answer(point);
            if ((answer.flags & sea::answer_folded) != 0) {
                ++errors.flagged;
                continue;
            }
            const sea::Answer exact = sea::surface_at(
                point, {sea.realization->choppiness, 1e-9, sea::fold_search(sea.budget)}, truth);
            const double error = std::abs(answer.height_m - exact.height_m);
            ++errors.answers;
            errors.beyond += error > answer.error_m ? 1 : 0;
            errors.square += error * error;
            errors.stated_square += answer.error_m * answer.error_m;
        }
    }
    return errors;
}

class Rungs : public testing::TestWithParam<Case> {};

// Five standard deviations are stated, which one answer in a million exceeds: of 2000 none. And what is stated is no
// excuse: as standard deviations the two agree within a third, by which grown waves of one moment may be off others.
TEST_P(Rungs, what_coarser_maps_state_holds_and_is_near_to_what_they_miss) {
    StreamOf stream(sea_of_scene(GetParam().scene), wish_of(GetParam()));
    ASSERT_FALSE(stream.grant().empty()) << stream.grant().why;
    EXPECT_TRUE(server::is_coarser(stream.grant().quality));
    const Errors errors = errors_of(stream, 25, 80);
    EXPECT_EQ(errors.beyond, 0);
    EXPECT_GT(errors.answers, 150) << "else nothing was tried";
    EXPECT_GT(errors.stated_rms(), 0.8 * errors.rms());
    EXPECT_LT(errors.stated_rms(), 1.5 * errors.rms());
    EXPECT_TRUE(GetParam().size_max == 0 || stream.largest_side() <= GetParam().size_max);
}

INSTANTIATE_TEST_SUITE_P(
    Seas, Rungs,
    testing::Values(Case{"north_sea_gale.toml", true, 128, 0},
                    Case{"north_sea_gale.toml", true, 64, 0},
                    Case{"north_sea_gale.toml", false, 128, 0},
                    Case{"north_sea_gale.toml", true, 0, 2},
                    Case{"north_sea_gale.toml", true, 128, 2}, Case{"calm.toml", true, 64, 0},
                    Case{"calm.toml", false, 64, 4}, Case{"calm.toml", true, 0, 4},
                    Case{"hurricane.toml", true, 128, 0}, Case{"shallow_lagoon.toml", true, 64, 0},
                    Case{"shallow_lagoon.toml", true, 0, 4}));

Demand granted(const server::RunningSeaPtr& sea, const Demand& wish,
               const std::bitset<server::quality_rungs>& in_use = {}) {
    const sea::ErrorBudget* const budgets[] = {&sea->budget};
    return server::grant_of(wish, budgets, sea->streamed(), in_use);
}

// Naive: a wish within what there is gets a rung of its own, and everything is encoded once more for it.
TEST(Grants, limits_that_all_there_is_keeps_change_nothing) {
    const server::RunningSeaPtr sea = sea_of_scene("north_sea_gale.toml");
    for (const bool compact : {false, true}) {
        const Demand plain = granted(sea, wish_of({"", compact, 0, 0}));
        const Demand limited = granted(sea, wish_of({"", compact, 256, 1000}));
        EXPECT_EQ(limited.quality, plain.quality);
        EXPECT_EQ(limited.error_m, plain.error_m);
        EXPECT_EQ(limited.why, "");
        EXPECT_EQ(limited.size_max, 0);
        EXPECT_EQ(limited.rate_hz_max, 0.0f);
    }
}

// Naive: a bound is rounded to the nearest float, which half of the time is below it, and not kept by what it was said of.
TEST(Grants, what_is_granted_is_no_less_than_what_is_kept_and_is_granted_again_to_who_asks_for_it) {
    for (const char* const scene : {"north_sea_gale.toml", "calm.toml", "hurricane.toml"}) {
        const server::RunningSeaPtr sea = sea_of_scene(scene);
        for (const float error_m : {0.01f, 0.02f, 0.05f, 0.1f, 0.2f}) {
            Demand wish = wish_of({"", true, 0, 0});
            wish.error_m = error_m;
            const Demand first = granted(sea, wish);
            wish.error_m = first.error_m;
            const Demand again = granted(sea, wish);
            EXPECT_EQ(again.error_m, first.error_m) << scene << ", asked for " << error_m;
            EXPECT_EQ(again.quality, first.quality) << scene << ", asked for " << error_m;
        }
    }
}

TEST(Grants, what_is_less_than_the_wish_is_said) {
    const server::RunningSeaPtr sea = sea_of_scene("north_sea_gale.toml");
    const auto why = [&](Demand wish) { return granted(sea, wish).why; };
    Demand wish = wish_of({"", true, 0, 0});
    EXPECT_EQ(why(wish), "");
    wish.cascades = 0xf;
    EXPECT_EQ(why(wish), "this sea has 3 cascades");
    wish = wish_of({"", true, 0, 0});
    wish.error_m = 1e-4f;
    EXPECT_NE(why(wish).find("are the finest of this sea"), std::string::npos) << why(wish);
    wish = wish_of({"", true, 100, 0});
    EXPECT_NE(why(wish).find("at most 64 points a side: the next below 100"), std::string::npos);
    wish = wish_of({"", true, 0, 2.5f});
    EXPECT_NE(why(wish).find("at most 2 keyframes a second: the next below 2.5"),
              std::string::npos);
    wish.error_m = 0.01f;
    EXPECT_NE(why(wish).find("are the finest of such maps"), std::string::npos);
    wish = wish_of({"", true, 128, 2});
    wish.fields |= sea::FieldSet{sea::Field::foam, sea::Field::jacobian};
    const Demand without = granted(sea, wish);
    EXPECT_EQ(without.fields | without.follows, sea::surface_fields);
    EXPECT_NE(without.why.find("jacobian, foam: no sum of waves"), std::string::npos)
        << without.why;
    wish = wish_of({"", true, 0, 2});
    wish.fields.insert(sea::Field::foam);
    EXPECT_NE(why(wish).find("foam is a history"), std::string::npos);
    const server::RunningSeaPtr plain = sea_of_scene(
        "[sea]\nseed = 1\n[[sea.system]]\ntype = \"wind\"\nwind_speed_10m_mps = 8\nfrom_deg = "
        "10\nfetch_m = 1e5\n[[cascade]]\nlength_m = 300\nsize = 64\n[effects]\nslopes = false\n");
    wish = wish_of({"", true, 0, 0});
    wish.fields.insert(sea::Field::slope_x);
    EXPECT_EQ(granted(plain, wish).why, "this sea streams no slope_x");
}

// Naive: what others than the wanted ones would miss as coarse as that is stated, too. The long waves of the gale are cut at 64.
TEST(Grants, the_bound_counts_coarser_maps_of_what_is_wanted_alone) {
    const server::RunningSeaPtr sea = sea_of_scene("north_sea_gale.toml");
    Demand wish = wish_of({"", true, 64, 0});
    EXPECT_GT(granted(sea, wish).error_m, 1.0f);
    wish.cascades = 1u << 2;
    EXPECT_LT(granted(sea, wish).error_m, 0.2f);
}

// Keyframes further apart than a turn of the fastest wave say nothing of it: refused by name, not served as noise.
TEST(Grants, what_cannot_be_is_refused_with_the_reason) {
    const server::RunningSeaPtr gale = sea_of_scene("north_sea_gale.toml");
    const Demand slow = granted(gale, wish_of({"", true, 0, 1}));
    EXPECT_TRUE(slow.empty());
    EXPECT_NE(slow.why.find("rate_hz_max is 1: cascade 2 takes"), std::string::npos) << slow.why;
    EXPECT_FALSE(slow.busy);
    Demand long_waves = wish_of({"", true, 0, 1});
    long_waves.cascades = 3;
    EXPECT_FALSE(granted(gale, long_waves).empty()) << "these are told by one a second";
    const server::RunningSeaPtr toy = sea_of_scene("gerstner_toy.toml");
    const Demand small = granted(toy, wish_of({"", true, 32, 0}));
    EXPECT_TRUE(small.empty());
    EXPECT_NE(small.why.find("cannot be cut"), std::string::npos) << small.why;
}

// Crowds of odd wishes cost no more than so many encodings of a keyframe.
TEST(Grants, only_so_many_kinds_of_coarser_maps_are_made_at_a_time) {
    const server::RunningSeaPtr sea = sea_of_scene("north_sea_gale.toml");
    std::bitset<server::quality_rungs> in_use;
    int refused = 0, shared = 0;
    for (int round = 0; round < 2; ++round)
        for (const int size : {32, 64, 128, 0})
            for (const float rate : {2.0f, 0.0f})
                for (const bool compact : {false, true})
                    for (const float error_m : {0.0f, 0.5f, 5.0f}) {
                        Demand wish = wish_of({"", compact, size, rate});
                        wish.error_m = error_m;
                        const Demand grant = granted(sea, wish, in_use);
                        if (grant.empty()) {
                            EXPECT_TRUE(grant.busy);
                            ++refused;
                            continue;
                        }
                        in_use.set(grant.quality);
                        shared += grant.why.find("in use by others") != std::string::npos;
                        EXPECT_TRUE(size == 0 || grant.size_max <= size);
                        EXPECT_TRUE(rate == 0 || grant.rate_hz_max <= rate);
                    }
    std::size_t coarser = 0;
    for (std::size_t n = server::whole_rungs; n < in_use.size(); ++n)
        coarser += in_use[n] ? 1 : 0;
    EXPECT_EQ(coarser, server::coarser_rungs_max);
    EXPECT_GT(refused, 0);
    EXPECT_GT(shared, 0);
}

// Naive: who comes first has all kinds of coarser maps, and thin lines of others get the worst there is.
TEST(Grants, an_address_that_has_its_share_of_kinds_is_given_such_as_somebody_has) {
    const server::RunningSeaPtr sea = sea_of_scene("north_sea_gale.toml");
    std::bitset<server::quality_rungs> in_use;
    Demand wish = wish_of({"", false, 128, 0});
    const Demand own = granted(sea, wish, in_use);
    EXPECT_FALSE(own.crowded);
    wish.shared_only = true;
    EXPECT_TRUE(granted(sea, wish, in_use).busy) << "nobody has any";
    in_use.set(granted(sea, wish_of({"", false, 64, 0}), in_use).quality);
    const Demand shared = granted(sea, wish, in_use);
    EXPECT_TRUE(shared.crowded);
    EXPECT_TRUE(in_use[shared.quality]);
    EXPECT_NE(shared.why.find("of this address"), std::string::npos) << shared.why;
    in_use.set(own.quality);
    EXPECT_EQ(granted(sea, wish, in_use).quality, own.quality);
}

TEST(Quality, a_number_says_its_rung_and_no_two_have_the_same) {
    for (int quality = 0; quality < server::quality_rungs; ++quality) {
        const auto number = static_cast<std::uint8_t>(quality);
        EXPECT_EQ(server::number_of(server::rung_of(number)), number);
        EXPECT_EQ(server::is_coarser(number),
                  server::rung_of(number).size != 0 || server::rung_of(number).rate != 0);
    }
}

} // namespace
} // namespace seaway::tests
