// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "sea/surface/sheets.h"
#include "sea/surface/surface_sheets.h"
#include "tests/sea/surface/folding_sea.h"
#include "tests/support/allocations.h"

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

// Engines ask in every frame. What a search needs is kept by its thread, so once the same was asked there is enough.
TEST(Sheets, are_searched_for_without_an_allocation_once_the_thread_has_searched) {
    const FoldingSea& sea = folding_sea();
    std::mt19937 random(15);
    std::uniform_real_distribution<double> place(-5e3, 5e3);
    std::vector<QueryPoint> points;
    while (points.size() < 50) { // below turned sheets
        const Vec2 X{place(random), place(random)};
        const LagrangianPoint p = sea.surface.at(X.x, X.y, moment_us);
        if (jacobian(p, sea.sea->choppiness) < 0)
            points.push_back({sea.landed(X, p).x, sea.landed(X, p).y, moment_us});
    }
    std::vector<Answer> answers(points.size());
    sea.surface.answer(points, answers);
    for (const Answer& answer : answers)
        EXPECT_TRUE(answer.flags & answer_folded);
    const seaway::tests::Allocations asked;
    sea.surface.answer(points, answers);
    EXPECT_EQ(asked.count(), 0u);
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

/// One wave of wavenumber 1 along (0.8, 0.6): eta = a cos s, D = -a sin s along it, J = 1 - a cos s.
class OneWave final : public SheetField {
  public:
    explicit OneWave(double amplitude_m) : a_(amplitude_m) {}
    static constexpr Vec2 along{0.8, 0.6};
    static Vec2 at(double s_m, double off_m = 0) {
        return {along.x * s_m - along.y * off_m, along.y * s_m + along.x * off_m};
    }
    static double s_of(Vec2 X) { return along.x * X.x + along.y * X.y; }
    double landed_m(double s_m) const { return s_m - a_ * std::sin(s_m); }

    LagrangianPoint displaced(Vec2 X) const override {
        const double s = s_of(X);
        LagrangianPoint p;
        p.displacement_x = -a_ * std::sin(s) * along.x;
        p.displacement_y = -a_ * std::sin(s) * along.y;
        p.strain_xx = -a_ * std::cos(s) * along.x * along.x;
        p.strain_yy = -a_ * std::cos(s) * along.y * along.y;
        p.strain_xy = -a_ * std::cos(s) * along.x * along.y;
        return p;
    }
    double height(Vec2 X) const override { return a_ * std::cos(s_of(X)); }
    RecycledVector<Roughness> roughness(const Box&) const override {
        return {{.range_m = 2 * a_, .strain_range = 2 * a_, .bend_per_m = a_}};
    }
    RecycledVector<Rise> rises(const Box&) const override {
        return {{.range_m = 2 * a_, .slope = a_}};
    }
    Box left_of(const Box& box, Vec2) const override { return box; }
    double spacing_m() const override { return 1; }

  private:
    double a_;
};

SheetSearch search_around(Vec2 target, Vec2 middle, double half_m, double blur_m) {
    return {.choppiness = {1, 1},
            .target = target,
            .box = Box::around(middle, half_m, half_m),
            .blur_m = blur_m,
            .strain_blur = 0,
            .height_blur_m = 0,
            .solved_m = 1e-9};
}

// Above the middle of a folded crest lie three sheets; the one in the middle is turned.
TEST(SheetSearch, a_turned_sheet_that_is_known_is_a_fold_wherever_the_rest_is_looked_for) {
    const OneWave wave(1.2);
    double side_m = 1; // s = 1.2 sin s
    for (int i = 0; i < 100; ++i)
        side_m = 1.2 * std::sin(side_m);
    SheetSearch search = search_around({0, 0}, OneWave::at(side_m + 0.05), 0.1, 1e-9);
    const Sheets alone = find_sheets(search, wave);
    EXPECT_FALSE(alone.folded);
    EXPECT_FALSE(alone.open);
    ASSERT_EQ(alone.found.size(), 1u);
    EXPECT_NEAR(alone.found[0].x, 0.8 * side_m, 1e-8);
    EXPECT_NEAR(alone.found[0].y, 0.6 * side_m, 1e-8);
    search.known = Vec2{0, 0};
    EXPECT_TRUE(find_sheets(search, wave).folded) << "the known one is turned";
    search.known = OneWave::at(-side_m);
    const Sheets beside = find_sheets(search, wave);
    EXPECT_FALSE(beside.folded) << "neither of these is";
    EXPECT_EQ(beside.found.size(), 1u);
    // All three, and each once.
    search = search_around({0, 0}, OneWave::at(0.07, 0.03), 1.5, 1e-9);
    const Sheets all = find_sheets(search, wave);
    EXPECT_TRUE(all.folded);
    EXPECT_FALSE(all.ended_early);
    for (std::size_t i = 0; i < all.found.size(); ++i)
        for (std::size_t k = 0; k < i; ++k)
            EXPECT_GT(std::hypot(all.found[i].x - all.found[k].x, all.found[i].y - all.found[k].y),
                      0.5);
    const auto highest =
        std::ranges::max_element(all.found, {}, [&](Vec2 X) { return wave.height(X); });
    ASSERT_NE(highest, all.found.end());
    EXPECT_NEAR(wave.height(*highest), 1.2, 1e-12) << "the turned one is the highest here";
}

// Nearly folded: J = 5e-4 over the crest. Where the field may be wrong by a micrometre, that may be a
// fold, and which sheet is the highest is open; where by a nanometre, it is neither.
TEST(SheetSearch, what_is_nearer_to_a_fold_than_the_blur_counts_as_folded_and_open) {
    const OneWave wave(0.9995);
    const auto found = [&](double blur_m) {
        return find_sheets(search_around({0, 0}, OneWave::at(0.11, -0.07), 0.4, blur_m), wave);
    };
    EXPECT_FALSE(found(1e-11).folded);
    EXPECT_FALSE(found(1e-11).open);
    EXPECT_EQ(found(1e-11).found.size(), 1u);
    // One to one still, s1^2 = 2.5e-7, but below 4 bends of 1 / m times the blur.
    EXPECT_FALSE(found(1e-7).folded);
    EXPECT_TRUE(found(1e-7).open);
    EXPECT_TRUE(found(1e-6).folded);
    EXPECT_TRUE(found(1e-6).open);
}

// At the edge of a fold two sheets meet: both sides of it are found, the residual there within the blur.
TEST(SheetSearch, places_on_both_sides_of_an_edge_are_found) {
    const OneWave wave(1.2);
    constexpr double blur_m = 1e-6;
    const double edge_m = std::acos(1 / 1.2); // J = 0
    for (const double side : {1.0, -1.0}) {
        const double s = side * edge_m;
        const Vec2 target = OneWave::at(wave.landed_m(s));
        const Sheets sheets =
            find_sheets(search_around(target, OneWave::at(s + 0.013, 0.02), 0.1, blur_m), wave);
        EXPECT_TRUE(sheets.folded);
        EXPECT_TRUE(sheets.open);
        int before = 0, beyond = 0;
        for (const Vec2& X : sheets.found) {
            const double off_m = OneWave::s_of(X) - s;
            EXPECT_LT(std::abs(wave.landed_m(OneWave::s_of(X)) - wave.landed_m(s)), blur_m);
            EXPECT_NEAR(OneWave::along.x * X.y - OneWave::along.y * X.x, 0, 1e-6)
                << "across the wave nothing moves it";
            before += off_m < -2e-4;
            beyond += off_m > 2e-4;
        }
        EXPECT_GE(before, 1);
        EXPECT_GE(beyond, 1);
    }
}

// Gradients that may be wrong by more than a sheet is steep: it may turn. By a little less: it may end.
TEST(SheetSearch, what_gradients_may_be_wrong_by_counts_as_if_the_sheet_were_less_steep) {
    const OneWave wave(0.9995); // 5e-4 over the crest
    const auto found = [&](double strain_blur) {
        SheetSearch search = search_around({0, 0}, OneWave::at(0.11, -0.07), 0.4, 1e-11);
        search.strain_blur = strain_blur;
        return find_sheets(search, wave);
    };
    EXPECT_FALSE(found(4.5e-4).folded); // (5e-5)^2 is above 4 bends of 1 / m times the blur
    EXPECT_FALSE(found(4.5e-4).open);
    EXPECT_FALSE(found(4.97e-4).folded); // (3e-6)^2 is below
    EXPECT_TRUE(found(4.97e-4).open);
    EXPECT_TRUE(found(5.5e-4).folded);
}

// The sheet beside a crest is 0.62 m high and may end within this blur; the one over it, 1.2 m.
TEST(SheetSearch, a_lower_sheet_that_may_end_leaves_open_only_what_it_may_reach) {
    const OneWave wave(1.2);
    const auto open = [&](std::optional<Vec2> known, double height_blur_m) {
        SheetSearch search = search_around({0, 0}, OneWave::at(1.0), 0.2, 0.03);
        search.height_blur_m = height_blur_m;
        search.known = known;
        return find_sheets(search, wave).open;
    };
    EXPECT_TRUE(open({}, 0)) << "nothing higher is known";
    EXPECT_FALSE(open(Vec2{0, 0}, 0));
    EXPECT_FALSE(open(Vec2{0, 0}, 0.3));
    EXPECT_TRUE(open(Vec2{0, 0}, 0.8)) << "heights may be wrong by that much";
}

} // namespace
} // namespace seaway::sea
