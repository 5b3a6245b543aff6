// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "sea/surface/sheets.h"
#include "sea/surface/surface_sheets.h"
#include "tests/sea/surface/folding_sea.h"

namespace seaway::sea {
namespace {

using namespace tests_of_folds;

// Which sheet is the highest is left open only where the maps cannot know; elsewhere a folded answer is
// as good as any. Places are below turned sheets, where several come down.
TEST(Sheets, a_folded_answer_keeps_its_bound_unless_it_is_flagged_open) {
    const FoldingSea& sea = folding_sea();
    const ErrorBudget budget = plan_budget(*sea.sea, 0.01);
    std::mt19937 random(12);
    std::uniform_real_distribution<double> place(-5e3, 5e3);
    int folded = 0, open = 0, exact_open = 0;
    while (folded < 300) {
        const Vec2 X{place(random), place(random)};
        const LagrangianPoint p = sea.surface.at(X.x, X.y, moment_us);
        if (jacobian(p, sea.sea->choppiness) > 0)
            continue;
        const Vec2 x = sea.landed(X, p);
        const QueryPoint point{x.x, x.y, moment_us};
        const Answer mapped = sea.surface.answer(point);
        EXPECT_TRUE(mapped.flags & answer_folded);
        ++folded;
        const Answer exact =
            surface_at(point, {sea.sea->choppiness, 1e-9, fold_search(budget)}, sea.moment);
        exact_open += (exact.flags & answer_open) != 0;
        if (mapped.flags & answer_open)
            ++open;
        else
            EXPECT_LE(std::abs(mapped.height_m - exact.height_m), mapped.error_m)
                << x.x << " " << x.y;
    }
    EXPECT_EQ(exact_open, 0);
    EXPECT_LT(open, 0.9 * folded); // a flag that is always set says nothing
    EXPECT_GT(open, 0);
}

// A sea that is the maps' own, moved sideways by as much as they are stated to be wrong: what they answer
// at a place is true where they answer the same a little beside it.
TEST(Sheets, a_folded_answer_that_is_not_open_holds_wherever_the_maps_may_lie) {
    const FoldingSea& sea = folding_sea();
    constexpr double wrong_m = 0.01;
    const double lambda = sea.sea->choppiness.x;
    const Surface maps(sea.surface.pairs(), sea.sea->choppiness, sea.surface.folds(),
                       {.height_bound_m = 1e-4, .displacement_bound_m = wrong_m / lambda});
    std::mt19937 random(14);
    std::uniform_real_distribution<double> place(-5e3, 5e3), turn(0, two_pi);
    int settled = 0, apart = 0;
    for (int found = 0; found < 6000;) {
        const Vec2 X{place(random), place(random)};
        const LagrangianPoint p = maps.at(X.x, X.y, moment_us);
        if (std::abs(jacobian(p, sea.sea->choppiness)) > 0.3)
            continue;
        ++found;
        const Vec2 x = sea.landed(X, p);
        const double angle = turn(random), off_m = 0.99 * wrong_m;
        const Answer here = maps.answer({x.x, x.y, moment_us});
        const Answer beside =
            maps.answer({x.x + off_m * std::cos(angle), x.y + off_m * std::sin(angle), moment_us});
        const double apart_m = std::abs(here.height_m - beside.height_m);
        if (!(here.flags & answer_folded))
            continue;
        apart += apart_m > here.error_m;
        if (here.flags & answer_open)
            continue;
        ++settled;
        EXPECT_LE(apart_m, here.error_m) << x.x << " " << x.y;
    }
    EXPECT_GT(settled, 20) << apart;
    EXPECT_GT(apart, 10); // as many would be wrong if none were open
}

// A tangle of up to nineteen sheets: what lies below the highest is left alone, and bounds are worked out
// anew as boxes shrink. Without either a search takes two to three times as long, and in the steepest seas
// that can be asked for it ends at its limit with whatever it has found.
TEST(Sheets, in_a_tangle_the_highest_sheet_is_found_without_visiting_all) {
    const FoldingSea sea({3, 3}, 0.2);
    std::mt19937 random(13);
    std::uniform_real_distribution<double> place(-5e3, 5e3);
    int most = 0, evaluations = 0;
    for (int i = 0; i < 6; ++i) {
        const Vec2 x{place(random), place(random)};
        const std::vector<double> sheets = sheets_by_force(sea, x, 130);
        const double top = *std::max_element(sheets.begin(), sheets.end());
        most = std::max(most, static_cast<int>(sheets.size()));
        const Answer answer = sea.surface.answer({x.x, x.y, moment_us});
        EXPECT_TRUE(sheets.size() == 1 || (answer.flags & answer_folded));
        EXPECT_NEAR(answer.height_m, top, 5e-3) << x.x << " " << x.y << ", " << sheets.size();

        SurfaceSheets field(sea.surface, moment_us);
        const std::optional<Box> box = field.others(x, nullptr, true);
        ASSERT_TRUE(box);
        const Sheets found = find_sheets(
            {sea.sea->choppiness, x, *box, field.blur_m(), field.strain_blur(), 0.0, 1e-4}, field);
        EXPECT_FALSE(found.ended_early);
        evaluations += found.evaluations;
    }
    EXPECT_LT(evaluations, 11'000); // 8000; 14 000 and 25 000 without
    EXPECT_GT(most, 15);
}

} // namespace
} // namespace seaway::sea
