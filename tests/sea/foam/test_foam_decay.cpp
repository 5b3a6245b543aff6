// SPDX-License-Identifier: Apache-2.0
// Hard case E3: how long foam stays, from not at all to the longest that a scene may ask for.
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sea/foam/foam.h"
#include "tests/sea/foam/foam_seas.h"
#include "tests/sea/scene_of.h"

namespace seaway::sea {
namespace {

constexpr double longest_decay_s = 1e6; ///< of a scene

// Naive: exp(-dt/0) is 0/0 at dt = 0.
TEST(Foam, E3_every_decay_that_a_scene_may_have_has_a_meaning_at_any_tick) {
    EXPECT_EQ(foam_remains(0.0, 0.0), 0.0); // no history: foam is where waves break now
    EXPECT_EQ(foam_remains(0.1, 0.0), 0.0);
    EXPECT_EQ(foam_remains(1e5, 0.0), 0.0);
    EXPECT_EQ(foam_remains(0.0, 4.0), 1.0);
    EXPECT_DOUBLE_EQ(foam_remains(4.0, 4.0), std::exp(-1.0));
    EXPECT_EQ(foam_remains(1e5, 4.0), 0.0);
    EXPECT_EQ(foam_remains(0.0, longest_decay_s), 1.0);
    EXPECT_DOUBLE_EQ(foam_remains(0.1, longest_decay_s), std::exp(-1e-7));
    EXPECT_DOUBLE_EQ(foam_remains(1e5, longest_decay_s), std::exp(-0.1));
    EXPECT_EQ(foam_remains(1e5, std::numeric_limits<double>::infinity()), 1.0); // no scene's

    const sea::RealizationPtr sea = storm();
    const FoamLawPtr instant = make_foam_law(*sea, {0.6, 0.0, 3.0});
    EXPECT_GT(instant->mean_coverage, 0.0);
    FoamHistory history(instant, 0, 4, interval_us);
    history.advance(uniform_strains(4, -0.5f), 0.0);
    const float breaking = history.ratios()[0];
    EXPECT_GT(breaking, 1.0f);
    history.advance(uniform_strains(4, 0.3f), 0.0);
    EXPECT_LT(history.ratios()[0], 0.1f); // forgotten at once
}

// Naive: the mean coverage is the gain times the decay, and infinite.
TEST(Foam, E3_a_decay_without_end_is_refused_by_name) {
    for (const char* bad : {"inf", "-inf", "nan", "-1", "1.1e6"})
        EXPECT_THAT(testing::error_of(fmt::format("[sea]\n[foam]\ndecay_s = {}\n", bad)),
                    ::testing::HasSubstr("decay_s"))
            << bad;
    const Scene scene =
        testing::scene_of(fmt::format("[sea]\n[foam]\ndecay_s = {}\n", longest_decay_s));
    EXPECT_EQ(scene.foam.decay_s, longest_decay_s);
}

// The case's infinity is the longest decay of a scene here.
TEST(Foam, E3_foam_of_the_longest_decay_rises_monotonously_to_all_and_a_calm_of_minutes_keeps_it) {
    const sea::RealizationPtr one = tests::make_sea({storm()->cascades[0]}); // no others
    const FoamLawPtr law = make_foam_law(*one, {0.6, longest_decay_s, 1e-5});
    FoamHistory history(law, 0, 1, interval_us);
    const auto coverage = [&] { return foam_coverage(law->mean_coverage, history.ratios()); };
    history.advance(uniform_strains(1, 0.5f), 1e9); // nothing breaks, all is forgotten
    EXPECT_EQ(coverage(), 0.0);
    const Keyframe breaking = uniform_strains(1, -0.6f); // J = 0.4: a shortfall of 0.2
    const auto rise = [&](double tick_s, int ticks) {
        for (int tick = 0; tick < ticks; ++tick) {
            const double before = coverage();
            history.advance(breaking, tick_s);
            ASSERT_GE(coverage(), before);
        }
    };
    rise(0.2, 5000);
    // What remains of foam after such a tick is 1 - 2e-7, and floats there are 6e-8 apart: 15 % of what fades, which is half a
    // thousandth by now.
    const double risen = 1e-5 * 0.2 * longest_decay_s * (1 - std::exp(-1e-3));
    EXPECT_NEAR(coverage() / risen, 1, 1e-4);
    rise(1e4, 100);
    EXPECT_EQ(coverage(), 1.0);
    const float whole = history.ratios()[0];
    for (int tick = 0; tick < 5000; ++tick)
        history.advance(uniform_strains(1, 0.5f), 0.2);
    EXPECT_NEAR(history.ratios()[0] / whole, std::exp(-1e-3), 3e-4); // twice 15 % of a thousandth
    EXPECT_EQ(coverage(), 1.0);
}

} // namespace
} // namespace seaway::sea
