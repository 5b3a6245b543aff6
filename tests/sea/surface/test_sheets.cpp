// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "sea/surface/budget/error_budget.h"
#include "sea/surface/moment_sheets.h"
#include "sea/surface/surface.h"
#include "sea/surface/surface_sheets.h"
#include "tests/sea/surface/folding_sea.h"

namespace seaway::sea {
namespace {

using namespace tests_of_folds;

TEST(Sheets, maps_answer_with_the_highest_of_all_sheets_and_flag_every_fold) {
    const FoldingSea& sea = folding_sea();
    std::mt19937 random(1);
    std::uniform_real_distribution<double> place(-5e3, 5e3);
    // At the edge of a fold 1e-4 m of residual is a centimetre along the surface.
    constexpr double edge_m = 5e-3;
    int folded = 0, highest = 0, flagged_without = 0, points = 0;
    while (points < 4000) {
        Vec2 x{place(random), place(random)};
        // Every other one below a place that comes close to folding: else most points are plain.
        if (++points % 10 != 0) {
            const LagrangianPoint p = sea.surface.at(x.x, x.y, moment_us);
            if (jacobian(p, sea.sea->choppiness) > 0.15)
                continue;
            x = sea.landed(x, p);
        }
        const std::vector<double> sheets = sheets_by_force(sea, x);
        const Answer answer = sea.surface.answer({x.x, x.y, moment_us});
        ASSERT_FALSE(sheets.empty());
        const double top = *std::max_element(sheets.begin(), sheets.end());
        if (sheets.size() > 1) {
            ++folded;
            EXPECT_TRUE(answer.flags & answer_folded) << x.x << " " << x.y;
            highest += std::abs(answer.height_m - top) < edge_m;
        } else {
            flagged_without += (answer.flags & answer_folded) != 0;
            EXPECT_NEAR(answer.height_m, top, edge_m) << x.x << " " << x.y;
        }
    }
    EXPECT_GT(folded, 40);
    EXPECT_GE(highest, 0.99 * folded);
    // Beside a fold, within what the maps may be wrong by: most of these points were chosen there.
    EXPECT_LT(flagged_without, 3 * folded);
}

// Solutions counted with the sign of J add up to one: where a turned sheet comes down there are three.
TEST(Sheets, below_every_turned_sheet_the_exact_sum_and_the_maps_see_a_fold) {
    const FoldingSea& sea = folding_sea();
    std::mt19937 random(2);
    std::uniform_real_distribution<double> place(-5e3, 5e3);
    const ErrorBudget budget = plan_budget(*sea.sea, 0.01);
    int turned = 0;
    for (int i = 0; i < 100'000 && turned < 60; ++i) {
        const Vec2 X{place(random), place(random)};
        const LagrangianPoint near = sea.surface.at(X.x, X.y, moment_us);
        if (jacobian(near, sea.sea->choppiness) > -0.02)
            continue;
        ++turned;
        const LagrangianPoint p = sea.moment.at(X.x, X.y);
        const Vec2 x = sea.landed(X, p);
        const QueryPoint point{x.x, x.y, moment_us};
        const Answer exact =
            surface_at(point, {sea.sea->choppiness, 1e-9, fold_search(budget)}, sea.moment);
        EXPECT_TRUE(exact.flags & answer_folded) << X.x << " " << X.y;
        EXPECT_FALSE(exact.flags & answer_not_converged);
        EXPECT_GE(exact.height_m, p.height - 1e-8); // a sheet of its own
        const Answer mapped = sea.surface.answer(point);
        EXPECT_TRUE(mapped.flags & answer_folded) << X.x << " " << X.y;
        EXPECT_GE(mapped.height_m, p.height - mapped.error_m) << X.x << " " << X.y;
        EXPECT_GE(exact.normal[2], 0); // turned up on whatever sheet
        EXPECT_GE(mapped.normal[2], 0);
    }
    EXPECT_EQ(turned, 60);
}

// What the search leaves out holds no solution, however unlike choppiness is along x and y.
TEST(Sheets, every_place_that_lands_here_lies_where_sheets_are_looked_for) {
    for (const Choppiness choppiness : {Choppiness{2.4, 0.3}, {0.3, 2.4}}) {
        const FoldingSea sea(choppiness);
        std::mt19937 random(7);
        std::uniform_real_distribution<double> place(-5e3, 5e3);
        double widest_m = 0, narrowest_m = 1e9;
        for (int i = 0; i < 200; ++i) {
            const Vec2 X{place(random), place(random)};
            const InverseOptions options{choppiness, 1e-6, sea.surface.folds()};
            const Vec2 mapped = sea.landed(X, sea.surface.at(X.x, X.y, moment_us));
            const Vec2 exact = sea.landed(X, sea.moment.at(X.x, X.y));
            SurfaceSheets of_maps(sea.surface, moment_us);
            MomentSheets of_sum(sea.moment, options);
            for (const auto& box :
                 {of_maps.others(mapped, nullptr, true), of_sum.others(exact, nullptr, true)}) {
                ASSERT_TRUE(box);
                EXPECT_TRUE(box->low.x <= X.x && X.x <= box->high.x) << i;
                EXPECT_TRUE(box->low.y <= X.y && X.y <= box->high.y) << i;
                widest_m = std::max(widest_m,
                                    std::max(box->high.x - box->low.x, box->high.y - box->low.y));
                narrowest_m = std::min(
                    narrowest_m, std::min(box->high.x - box->low.x, box->high.y - box->low.y));
            }
        }
        EXPECT_LT(narrowest_m, 0.25 * widest_m) << "and as little as one axis needs";
    }
}

// Patches are of modes alone: what stylised waves add may lift the lower sheet above the higher one.
TEST(Sheets, heights_of_patches_may_be_wrong_by_what_stylised_waves_add_here_and_there) {
    auto sea = std::make_shared<Realization>(*folding_sea().sea);
    SineRamps ramps;
    ramps.kind = SineKind::sine;
    ramps.length_m = 200;
    ramps.wavelength_m = 40;
    ramps.count = 3;
    ramps.amplitude_m = 0.5;
    ramps.amplitude_ratio = 0.5;
    ramps.normalise = false;
    sea->cascades[0].sines.push_back(sine_field(ramps, 1, 0, Dispersion{}, 1.0, 0));
    const auto blur_of = [](const RealizationPtr& one) {
        const DirectSum sum(one);
        const DirectSum::Moment moment = sum.at_time(moment_us);
        MomentSheets sheets(moment, {one->choppiness, 1e-6, folding_sea().surface.folds()});
        sheets.others({3, 4}, nullptr, true);
        return sheets.height_blur_m();
    };
    // 0.5 + 0.25 + 0.125 m at one of the places, as much below the mean at the other.
    EXPECT_NEAR(blur_of(sea) - blur_of(folding_sea().sea), 2 * 0.875, 1e-9);
}

TEST(Sheets, maps_and_exact_sum_answer_alike_unless_flagged) {
    for (const Choppiness choppiness : {Choppiness{2.2, 2.2}, {2.0, 1.0}, {2.5, 0.0}}) {
        const FoldingSea sea(choppiness);
        const ErrorBudget budget = plan_budget(*sea.sea, 0.01);
        std::mt19937 random(3);
        std::uniform_real_distribution<double> place(-5e3, 5e3);
        int flagged = 0;
        for (int i = 0; i < 1000; ++i) {
            const QueryPoint point{place(random), place(random), moment_us};
            const Answer mapped = sea.surface.answer(point);
            const Answer exact =
                surface_at(point, {choppiness, 1e-9, fold_search(budget)}, sea.moment);
            EXPECT_TRUE(std::isfinite(mapped.height_m));
            if ((mapped.flags | exact.flags) & answer_folded) {
                ++flagged;
                continue;
            }
            EXPECT_LE(std::abs(mapped.height_m - exact.height_m), mapped.error_m)
                << point.x_m << " " << point.y_m;
        }
        EXPECT_LT(flagged, 200);
    }
}

// No keyframe folds, and folds lie between them: each moves the water the same way until their middle. Weighed with their
// signs, the two rates would bound nothing there. Naive: keyframes that stand still, and a mean of bounds that are not carried.
TEST(Sheets, sheets_that_time_rates_make_between_two_keyframes_are_found) {
    constexpr double k_radpm = 2 * two_pi / 64;
    constexpr TimeUs after_us = 1'000'000;
    struct Case {
        double at_keyframes, between; ///< -k times the amplitude of D
        double
            reach_m; ///< around 0, where three sheets stand: k X = 0, and k X = `between` sin(k X)
        double height_m; ///< of the outer ones, and more
    };
    for (const Case& fold : {Case{0, 1.5, 0.5, 0.9}, {0.9, 1.15, 0.2, 0.25}}) {
        // Half-way the two rates count for an eighth of the interval each.
        const double rate_mps = 4 * (fold.between - fold.at_keyframes) / k_radpm;
        const auto keyframe = [&](TimeUs time_us, double sign) {
            Keyframe map;
            map.time_us = time_us;
            map.size = 64;
            map.length_m = 64.0;
            map.fields = surface_fields;
            map.values.resize(6 * map.plane_size());
            for (std::size_t i = 0; i < map.plane_size(); ++i) {
                const double phase = k_radpm * static_cast<double>(i % 64);
                map.plane(Field::height)[i] = static_cast<float>(1 - std::cos(phase));
                map.plane(Field::displacement_x)[i] =
                    static_cast<float>(-fold.at_keyframes / k_radpm * std::sin(phase));
                map.plane(Field::displacement_x_rate)[i] =
                    static_cast<float>(sign * rate_mps * std::sin(phase));
            }
            return std::make_shared<const SplineMap>(map);
        };
        const Surface surface({{keyframe(0, -1), keyframe(after_us, 1)}}, {1, 1}, {.reach_m = 10.0},
                              {});
        for (int i = -8; i <= 8; ++i) {
            const double x_m = fold.reach_m * i / 8;
            const Answer answer = surface.answer({x_m, 3.0, after_us / 2});
            EXPECT_GT(answer.height_m, fold.height_m) << x_m;
            EXPECT_EQ(answer.flags & answer_folded, answer_folded) << x_m;
            EXPECT_EQ(surface.answer({x_m, 3.0, 0}).flags & answer_folded, 0u) << x_m;
        }
    }
}

// A calm sea must not pay: windows alone tell that there is one sheet.
TEST(Sheets, a_sea_that_does_not_fold_is_never_searched) {
    const FoldingSea sea({0.5, 0.5});
    std::mt19937 random(5);
    std::uniform_real_distribution<double> place(-5e3, 5e3);
    int searched = 0;
    for (int i = 0; i < 2000; ++i) {
        const Vec2 X{place(random), place(random)};
        const Vec2 x = sea.landed(X, sea.surface.at(X.x, X.y, moment_us));
        SurfaceSheets sheets(sea.surface, moment_us);
        searched += sheets.others(x, &X, false).has_value();
    }
    EXPECT_EQ(searched, 0);
}

// A long tile whose grid is too coarse for its waves beside a fine one: heights are off by centimetres,
// but by long waves that bend nothing. An error as large in the finest waves would fold them.
TEST(Sheets, what_a_coarse_tile_misses_flags_no_answer_where_nothing_folds) {
    const RealizationPtr sea = tests::make_sea({tests::random_cascade(800.0, 64, 19, 300, 0.004, 5),
                                                tests::random_cascade(6.0, 64, 15, 300, 0.004, 6)});
    const ErrorBudget budget = plan_budget(*sea, 0.05);
    EXPECT_GT(budget.interpolation_displacement_m, 0.04);
    std::vector<SplinePair> pairs;
    for (int c = 0; c < 2; ++c) {
        const auto map = std::make_shared<const SplineMap>(*tests::exact_keyframe(sea, c, 0));
        pairs.push_back({map, map});
    }
    const Surface surface(std::move(pairs), sea->choppiness, fold_search(budget),
                          map_error(budget, 0));
    std::mt19937 random(6);
    std::uniform_real_distribution<double> place(-5e3, 5e3);
    for (int i = 0; i < 500; ++i)
        EXPECT_EQ(surface.answer({place(random), place(random), 0}).flags & answer_folded, 0u);
}

// How far other sheets are looked for: over shallow water orbits are flat, and reach further.
TEST(Sheets, the_reach_of_a_cascade_is_that_of_its_displacements_at_any_depth) {
    for (const double depth_m : {deep_water_m, 10.0, 1.0}) {
        CascadeModes modes = tests::random_cascade(100.0, 64, 9, 60, 0.04, 5);
        modes.depth_m = depth_m;
        const DirectSum sum(tests::make_sea({modes}));
        const DirectSum::Moment moment = sum.at_time(moment_us);
        double squares = 0; // over the nodes of a lattice that holds the waves: exact
        for (int y = 0; y < 32; ++y)
            for (int x = 0; x < 32; ++x) {
                const LagrangianPoint p = moment.at(x * 100.0 / 32, y * 100.0 / 32);
                squares +=
                    p.displacement_x * p.displacement_x + p.displacement_y * p.displacement_y;
            }
        const double rms_m = std::sqrt(squares / (32 * 32));
        // Six standard deviations of waves of random phases (sea/waves/reference.h).
        EXPECT_NEAR(moment.patch_scale(0).displacement_m, 6 * rms_m, 1e-9 * rms_m) << depth_m;
    }
}

// Phases that a scene gives may agree: the amplitudes of such waves add up, in deep water those of their
// heights. Beside each of them in its pair, to the east or to the west, lies one of a random phase or none.
TEST(Sheets, the_reach_of_waves_whose_phases_are_given_is_the_sum_of_their_amplitudes) {
    struct Wave {
        int nx, ny;
        double amplitude_m;
        bool given;
    };
    CascadeModes modes = tests::calm_cascade(100.0, 64);
    modes.given.resize(modes.h0.size());
    double given_m = 0, variance_m2 = 0;
    for (const Wave& wave : {Wave{3, 5, 0.4, true},
                             {-3, 5, 0.3, false},
                             {-9, 2, 0.2, true},
                             {9, 2, 0.5, false},
                             {6, 0, 0.7, true},
                             {0, 11, 0.6, false},
                             {-12, -7, 0.8, true}}) {
        tests::add_wave(modes, wave.nx, wave.ny, wave.amplitude_m, 0.3 * wave.nx);
        modes.given[static_cast<std::size_t>((wave.ny + 64) % 64 * 64 + (wave.nx + 64) % 64)] =
            wave.given;
        (wave.given ? given_m : variance_m2) +=
            wave.given ? wave.amplitude_m : 0.5 * wave.amplitude_m * wave.amplitude_m;
    }
    const DirectSum sum(tests::make_sea({modes}));
    const double reach_m = given_m + 6 * std::sqrt(variance_m2);
    for (const TimeUs t : {TimeUs{0}, moment_us})
        EXPECT_NEAR(sum.at_time(t).patch_scale(0).displacement_m, reach_m, 1e-13 * reach_m);
}

TEST(Sheets, a_patch_of_the_exact_sum_is_the_exact_sum) {
    const FoldingSea& sea = folding_sea();
    MomentSheets sheets(sea.moment, {sea.sea->choppiness, 1e-9, {}});
    const Vec2 x{1234.5, -777.7};
    const std::optional<Box> box = sheets.others(x, nullptr, true);
    ASSERT_TRUE(box);
    for (double share = 0; share <= 1; share += 0.05) {
        const Vec2 X{box->low.x + share * (box->high.x - box->low.x),
                     box->high.y - share * share * (box->high.y - box->low.y)};
        const LagrangianPoint exact = sea.moment.at(X.x, X.y);
        const LagrangianPoint patch = sheets.displaced(X);
        EXPECT_NEAR(patch.displacement_x, exact.displacement_x, sheets.blur_m() / 2.2);
        EXPECT_NEAR(patch.displacement_y, exact.displacement_y, sheets.blur_m() / 2.2);
        // One order of q = 0.14 pi at most is lost.
        EXPECT_NEAR(patch.strain_xx, exact.strain_xx, 20 * sheets.blur_m());
        EXPECT_NEAR(patch.strain_yy, exact.strain_yy, 20 * sheets.blur_m());
        EXPECT_NEAR(patch.strain_xy, exact.strain_xy, 20 * sheets.blur_m());
    }
    EXPECT_LT(sheets.blur_m(), 0.01);
}

} // namespace
} // namespace seaway::sea
