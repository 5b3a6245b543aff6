// SPDX-License-Identifier: Apache-2.0
// Exact answers of scenes that fold, held to brute force (tests/load/brute_sheets.h).
#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "sea/basics/constants.h"
#include "sea/scene/scene.h"
#include "sea/surface/budget/error_budget.h"
#include "sea/surface/inverse.h"
#include "tests/load/brute_sheets.h"

namespace seaway::sea {
namespace {

struct SceneAtATime {
    RealizationPtr sea;
    FoldSearch folds;
    DirectSum sum;
    DirectSum::Moment moment;
    tests::BruteField field;

    SceneAtATime(RealizationPtr realized, TimeUs time_us)
        : sea(std::move(realized)), folds(fold_search(plan_budget(*sea, 0.01))), sum(sea),
          moment(sum.at_time(time_us)), field(*sea, time_us) {}

    static RealizationPtr realized(const std::string& text) {
        const Result<Scene> scene = parse_scene(text, "folds", ".");
        EXPECT_TRUE(scene) << (scene ? "" : scene.error().message);
        return std::make_shared<const Realization>(*realize(*scene));
    }

    /// By brute force, each followed by the exact sum.
    std::vector<tests::BruteSheet> sheets_above(Vec2 x, double half_m) const {
        const tests::BruteSheets brute(field, x, half_m);
        return polish(moment, x, brute.above(x));
    }
    Answer answer(Vec2 x) const {
        return surface_at({x.x, x.y, 0}, {sea->choppiness, 1e-9, folds}, moment);
    }
};

double top_of(const std::vector<tests::BruteSheet>& sheets) {
    double top_m = -1e9;
    for (const tests::BruteSheet& sheet : sheets)
        top_m = std::max(top_m, sheet.height_m);
    return top_m;
}

// Swell of 120 m and 25 s: under such crests sheets lie tens of metres above each other.
TEST(SceneSheets, of_three_sheets_metres_apart_the_exact_answer_is_the_highest) {
    const SceneAtATime scene(SceneAtATime::realized(R"(
[sea]
seed = 20
height_scale = 3
[[sea.system]]
type = "swell"
spectrum = "jonswap"
from_deg = 250
significant_height_m = 40
peak_period_s = 25
spreading = "cos2s"
spreading_exponent = 10
[[cascade]]
length_m = 9001
size = 256
[[cascade]]
length_m = 1201
size = 256
)"),
                             1'202'117'000);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> place(-2e4, 2e4);
    double span_m = 0;
    for (int found = 0; found < 6;) {
        const Vec2 X{place(random), place(random)};
        const LagrangianPoint p = scene.field.at(X);
        if (jacobian(p, scene.sea->choppiness) > -0.3)
            continue;
        ++found;
        const Vec2 x = scene.field.landed(X, p);
        const std::vector<tests::BruteSheet> sheets = scene.sheets_above(x, 20.0);
        ASSERT_GE(sheets.size(), 3u) << x.x << " " << x.y;
        const Answer answer = scene.answer(x);
        EXPECT_TRUE(answer.flags & answer_folded);
        EXPECT_FALSE(answer.flags & answer_open);
        EXPECT_NEAR(answer.height_m, top_of(sheets), 1e-6) << x.x << " " << x.y;
        for (const tests::BruteSheet& sheet : sheets)
            span_m = std::max(span_m, answer.height_m - sheet.height_m);
    }
    EXPECT_GT(span_m, 5.0);
}

// Two sheets that meet 5 cm away, both of them within what the search's patches miss. Naive: a place for
// Newton to start from on either side of wherever the search has given up, which may be beside the edge.
TEST(SceneSheets, beside_the_edge_of_a_fold_the_exact_answer_is_the_higher_of_two_that_meet_there) {
    const SceneAtATime scene(SceneAtATime::realized(R"(
[sea]
seed = 513356878
choppiness = 2.18
height_scale = 1.71
[[sea.system]]
type = "wind"
spectrum = "tma"
from_deg = 105.1
wind_speed_10m_mps = 20.7
spreading = "mitsuyasu"
[[cascade]]
length_m = 832.7
size = 64
[[cascade]]
length_m = 138.8
size = 64
[[cascade]]
length_m = 23.13
size = 64
)"),
                             0);
    const Vec2 met{-17062.56983, 5193.50560};
    const std::vector<tests::BruteSheet> sheets = scene.sheets_above(met, 2.0);
    ASSERT_EQ(sheets.size(), 3u);
    EXPECT_NEAR(scene.answer(met).height_m, top_of(sheets), 1e-5);

    const tests::BruteSheets brute(scene.field, met, 30.0);
    int several = 0;
    for (const auto& place : brute.places()) {
        // Where sheets meet, one of them is about to turn.
        if (std::abs(place.jacobian) > 0.01 || several >= 60)
            continue;
        const auto above = polish(scene.moment, place.landed, brute.above(place.landed));
        if (above.size() < 2)
            continue;
        ++several;
        EXPECT_NEAR(scene.answer(place.landed).height_m, top_of(above), 1e-5)
            << place.landed.x << " " << place.landed.y;
    }
    EXPECT_GT(several, 10);
}

// What lets exact answers of calmer seas go without a search. Sixty waves of one direction are Gaussian
// enough: turned sheets cover what the law says within 15 %, which is four standard errors and what sixty
// waves lack in the tail.
TEST(SceneSheets, turned_sheets_cover_as_much_of_the_world_as_the_gaussian_law_says) {
    constexpr int waves = 60, seas = 4000, places = 100;
    double cosine[places][waves], sine[places][waves]; // of each wave's way to each place
    for (int i = 0; i < places; ++i)
        for (int n = 0; n < waves; ++n) {
            cosine[i][n] = std::cos(two_pi * i / places * (n + 1));
            sine[i][n] = std::sin(two_pi * i / places * (n + 1));
        }
    std::mt19937 random(11);
    std::uniform_real_distribution<double> turn(0, two_pi);
    for (const double squeeze : {0.45, 0.6}) {
        double covered = 0;
        for (int sea = 0; sea < seas; ++sea) {
            double begins_cosine[waves], begins_sine[waves];
            for (int n = 0; n < waves; ++n) {
                const double phase = turn(random);
                begins_cosine[n] = std::sqrt(2.0 / waves) * std::cos(phase);
                begins_sine[n] = std::sqrt(2.0 / waves) * std::sin(phase);
            }
            for (int i = 0; i < places; ++i) {
                double strain = 0;
                for (int n = 0; n < waves; ++n)
                    strain += cosine[i][n] * begins_cosine[n] - sine[i][n] * begins_sine[n];
                covered += std::max(0.0, -(1 + squeeze * strain));
            }
        }
        EXPECT_NEAR(covered / (seas * places) / folded_share(squeeze), 1.0, 0.15) << squeeze;
    }
    EXPECT_LT(folded_share(folds_searched_above), 5e-8);
    EXPECT_EQ(folded_share(0), 0);
}

} // namespace
} // namespace seaway::sea
