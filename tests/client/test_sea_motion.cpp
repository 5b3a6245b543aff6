// SPDX-License-Identifier: Apache-2.0
// How much further the water is within what a clock is off by (client/sea_motion.h).
#include "client/sea_motion.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "sea/scene/scene.h"
#include "sea/surface/budget/error_budget.h"
#include "sea/surface/inverse.h"
#include "sea/waves/realize.h"
#include "sea/waves/statistics/moments.h"

namespace seaway::client {
namespace {

/// A steep one, and one of short steep waves: both with waves of a few metres or decimetres that longer ones carry along.
constexpr const char* gale = "significant_height_m = 6.8\npeak_period_s = 11.0\n";
constexpr const char* gale_grids = "[[cascade]]\nlength_m = 620.0\nsize = 64\n"
                                   "[[cascade]]\nlength_m = 97.0\nsize = 128\n";
constexpr const char* chop = "significant_height_m = 0.8\npeak_period_s = 3.0\n";
constexpr const char* chop_grids = "[[cascade]]\nlength_m = 61.0\nsize = 64\n"
                                   "[[cascade]]\nlength_m = 13.0\nsize = 64\n";

class MovingSea {
  public:
    MovingSea(const std::string& waves, const std::string& grids,
              const std::string& more = "choppiness = 1.0\n")
        : scene_(*sea::parse_scene("[sea]\nseed = 5\n" + more +
                                       "[[sea.system]]\n"
                                       "type = \"swell\"\nspectrum = \"jonswap\"\nfrom_deg = 270\n"
                                       "spreading = \"cos2s\"\nspreading_exponent = 8\n" +
                                       waves + grids,
                                   "a scene")),
          sum_(std::make_shared<const sea::Realization>(*sea::realize(scene_))) {
        constexpr double any_error_m = 0.01; // of maps, which there are none of
        const sea::ErrorBudget budget = sea::plan_budget(sum_.sea(), any_error_m);
        for (const sea::CascadeModes& modes : sum_.sea().cascades)
            state_.cascades.push_back({.length_m = modes.spec.length_m,
                                       .size = modes.spec.size,
                                       .k_hi_radpm = modes.band.k_hi_radpm});
        state_.rms_slope = budget.rms_slope;
        state_.rms_strain = budget.rms_strain;
        state_.curvature_per_m = budget.curvature_per_m;
        state_.realised.hs_m = sea::summarize(scene_.sea, sum_.sea()).realised.significant_height_m;
        state_.wave_law = sea::wave_law(scene_.sea, sum_.sea());
        options_ = {sum_.sea().choppiness, 1e-6, sea::fold_search(budget)};
    }
    /// Of the height where nothing carries waves along: the root of the sum of w^6 over all of them.
    double rms_third_rate_mps3() const {
        double sum = 0;
        for (const sea::CascadeModes& modes : sum_.sea().cascades)
            for (std::size_t i = 0; i < modes.h0.size(); ++i)
                sum +=
                    2 * std::norm(modes.h0[i]) * std::pow(sea::omega_from_rate(modes.rate[i]), 6);
        return std::sqrt(sum);
    }
    const protocol::SeaStateValues& state() const { return state_; }

    /// Of each place; which of them fold goes to `folded`.
    std::vector<double> heights_m(const std::vector<sea::Vec2>& places, sea::TimeUs time_us,
                                  std::vector<bool>& folded) const {
        const sea::DirectSum::Moment moment = sum_.at_time(time_us);
        std::vector<double> heights_m;
        for (std::size_t i = 0; i < places.size(); ++i) {
            const sea::Answer found =
                sea::surface_at({places[i].x, places[i].y, time_us}, options_, moment);
            heights_m.push_back(found.height_m);
            folded[i] = folded[i] || (found.flags & sea::answer_folded) != 0;
        }
        return heights_m;
    }

  private:
    sea::Scene scene_;
    sea::DirectSum sum_;
    protocol::SeaStateValues state_;
    sea::InverseOptions options_;
};

/// What was found at many moments around some.
struct Found {
    double stated_m = 0;    ///< on average
    double moved_m = 0;     ///< likewise, at the furthest moment
    double beyond_m = 0;    ///< the furthest above what was stated
    double past_ends_m = 0; ///< and above the further end
};

Found found_within(const MovingSea& sea, double off_s) {
    const SeaMotion motion = motion_of(sea.state(), 0);
    const int each_way = looks_each_way(motion, off_s);
    const auto looks = static_cast<std::size_t>(2 * each_way + 1);
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> place(-1e4, 1e4);
    constexpr int times = 12, moments_each_way = 24; // each of the looks among them
    Found found{.beyond_m = -1e9, .past_ends_m = -1e9};
    for (int time = 0; time < times; ++time) {
        std::vector<sea::Vec2> places(16);
        for (sea::Vec2& at : places)
            at = {place(random), place(random)};
        const auto at_us = [&](int moment) {
            return sea::TimeUs{time} * 97'000'000 +
                   std::llround(1e6 * off_s * moment / moments_each_way);
        };
        std::vector<bool> folded(places.size()), unused(places.size());
        std::vector<std::vector<double>> seen, all;
        for (int look = -each_way; look <= each_way; ++look)
            seen.push_back(
                sea.heights_m(places, at_us(look * moments_each_way / each_way), folded));
        for (int moment = -moments_each_way; moment <= moments_each_way; ++moment)
            all.push_back(sea.heights_m(places, at_us(moment), unused));
        for (std::size_t i = 0; i < places.size(); ++i) {
            std::vector<double> heights_m;
            for (std::size_t look = 0; look < looks; ++look)
                heights_m.push_back(seen[look][i]);
            const double here_m = heights_m[looks / 2];
            double moved_m = 0;
            for (const std::vector<double>& then : all)
                moved_m = std::max(moved_m, std::abs(then[i] - here_m));
            const double stated_m = furthest_m(heights_m, off_s / each_way, motion, folded[i]);
            found.stated_m += stated_m / (times * 16);
            found.moved_m += moved_m / (times * 16);
            found.beyond_m = std::max(found.beyond_m, moved_m - stated_m);
            found.past_ends_m = std::max(found.past_ends_m,
                                         moved_m - std::max(std::abs(heights_m[0] - here_m),
                                                            std::abs(heights_m.back() - here_m)));
        }
    }
    return found;
}

TEST(SeaMotion, no_height_is_further_off_at_any_moment_within_what_the_clock_is) {
    for (const bool short_waves : {true, false}) {
        const MovingSea sea(short_waves ? chop : gale, short_waves ? chop_grids : gale_grids);
        // What is stated may be so many times what the water moves, both on average: little more where that is little beside its
        // waves, else up to what any sea so high may do.
        for (const auto& [off_s, more] : {std::pair(0.005, 1.02),
                                          {0.05, 1.25},
                                          {0.3, 1.6},
                                          {0.5, 2.5},
                                          {1.0, 4.0},
                                          {2.0, 5.0}}) {
            const Found found = found_within(sea, off_s);
            EXPECT_LE(found.beyond_m, 1e-5) << off_s << " s, " << short_waves; // of solved places
            EXPECT_LT(found.stated_m, more * found.moved_m) << off_s << " s, " << short_waves;
            if (off_s >= 0.5) {
                EXPECT_GT(found.past_ends_m, 0.02)
                    << off_s << " s, " << short_waves << ": the ends alone do not tell";
            }
        }
    }
}

TEST(SeaMotion, takes_three_looks_where_a_clock_is_off_by_little_and_never_more_than_nine) {
    for (const bool short_waves : {true, false}) {
        const MovingSea sea(short_waves ? chop : gale, short_waves ? chop_grids : gale_grids);
        const SeaMotion motion = motion_of(sea.state(), 0);
        EXPECT_EQ(looks_each_way(motion, 0), 1);
        EXPECT_EQ(looks_each_way(motion, 0.02), 1);
        EXPECT_GT(looks_each_way(motion, 0.5), 1);
        EXPECT_EQ(looks_each_way(motion, 100), looks_each_way_max);
    }
}

// Naive: w^2 = g k, where waves are rounded to whole turns of a loop, and long ones to one of them, and g is not the earth's.
TEST(SeaMotion, counts_how_fast_waves_turn_where_a_sea_repeats_and_under_any_gravity) {
    for (const std::string more : {"loop_period_s = 20\n", "loop_period_s = 5\n",
                                   "loop_period_s = 1\n", "gravity_mps2 = 40\n"}) {
        const MovingSea sea("significant_height_m = 3.0\npeak_period_s = 14.0\n", gale_grids,
                            "choppiness = 0\n" + more);
        const double five_m = sea::bound_sigmas * sea.rms_third_rate_mps3();
        const SeaMotion motion = motion_of(sea.state(), 0);
        EXPECT_GE(motion.third_rate_mps3, five_m) << more;
        protocol::SeaStateValues untold = sea.state(); // as of a sea that glides
        untold.wave_law.reset();
        EXPECT_LT(motion_of(untold, 0).third_rate_mps3, motion.third_rate_mps3) << more;
        EXPECT_EQ(motion_of(untold, 0, *sea.state().wave_law).third_rate_mps3,
                  motion.third_rate_mps3);
    }
}

// Naive: the earth's gravity and no loop, unless a law is of more than the earth's.
TEST(SeaMotion, of_a_sea_that_glides_has_the_law_of_those_that_tell_one) {
    const auto telling = [](std::optional<sea::WaveLaw> law) {
        return std::make_shared<const SeaState>(SeaState{.wave_law = law});
    };
    const sea::WaveLaw weak{{.gravity_mps2 = 3.7}, 5'000'000}, earths{{}, 7'000'000},
        strong{{.gravity_mps2 = 40}, 0};
    const SeaStatePtr glides = telling({});
    EXPECT_EQ(fastest_law({}), sea::WaveLaw{});
    EXPECT_EQ(fastest_law(std::vector{glides}), sea::WaveLaw{});
    EXPECT_EQ(fastest_law(std::vector{telling(weak), glides}), weak);
    EXPECT_EQ(fastest_law(std::vector{glides, telling(earths)}), earths);
    EXPECT_EQ(fastest_law(std::vector{telling(earths), glides, telling(strong), telling(weak)}),
              strong);
}

TEST(SeaMotion, of_a_parabola_finds_the_crest_between_moments) {
    const SeaMotion still{}; // of which nothing is left in between
    const auto height_m = [](double t_s) { return 3 + t_s - t_s * t_s; };
    const std::vector<double> heights_m{height_m(-0.8), height_m(0), height_m(0.8)};
    EXPECT_DOUBLE_EQ(furthest_m(heights_m, 0.8, still, false), 1.44) << "the further end";
    const std::vector<double> later_m{height_m(-1.6), height_m(-0.8), height_m(0), height_m(0.8),
                                      height_m(1.6)};
    EXPECT_DOUBLE_EQ(furthest_m(later_m, 0.8, still, false), 4.16);
    // Through the first three runs 2.75 + t/8 + t^2/8, whose trough is 1/32 below both of its neighbours.
    const std::vector<double> trough_m{2.75, 2.75, 3.0, 3.0, 3.0};
    EXPECT_DOUBLE_EQ(furthest_m(trough_m, 1, still, false), 0.25 + 1.0 / 32);
}

TEST(SeaMotion, of_a_sea_that_lies_flat_is_none) {
    const SeaMotion motion = motion_of({}, 0);
    EXPECT_EQ(motion.between_m(10), 0);
    EXPECT_EQ(looks_each_way(motion, 10), 1);
    const std::vector<double> heights_m(3, 0.0);
    EXPECT_EQ(furthest_m(heights_m, 10, motion, false), 0);
}

} // namespace
} // namespace seaway::client
