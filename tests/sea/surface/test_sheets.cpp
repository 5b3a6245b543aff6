// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <random>
#include <tuple>
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

/// Smallest and largest eigenvalue of the symmetric part of grad D, or of its time rate.
std::array<double, 2> strains_of(const SplineSample& s, int x, int y) {
    const auto of = [](float value) { return static_cast<double>(value); };
    const double mean = 0.5 * (of(s.d_dx[x]) + of(s.d_dy[y]));
    const double gap =
        std::hypot(0.5 * (of(s.d_dx[x]) - of(s.d_dy[y])), 0.5 * (of(s.d_dy[x]) + of(s.d_dx[y])));
    return {mean - gap, mean + gap};
}

/// A place of a map that its time rates carry on for so long, in its values.
SplineSample carried(SplineSample sample, double by_s) {
    for (auto* of : {&sample.value, &sample.d_dx, &sample.d_dy})
        for (int c = 0; c < spline_channel::values; ++c)
            (*of)[c] += static_cast<float>(by_s) * (*of)[c + spline_channel::rate];
    return sample;
}

/// At places within the radius: strains and displacements, carried on, back, and as they are; and rates.
void windows_bound(const SplineMap& map, double x, double y, double radius_m,
                   std::mt19937& random) {
    std::uniform_real_distribution<double> share(-1, 1);
    const StrainBounds& bounds = map.windows().around(x, y, radius_m);
    for (int k = 0; k < 60; ++k) {
        const SplineSample s =
            map.sample(x + share(random) * radius_m, y + share(random) * radius_m);
        constexpr double rounding = 1e-5;
        const auto [slowest, fastest] = strains_of(s, 5, 6);
        ASSERT_LE(std::max(-slowest, fastest), static_cast<double>(bounds.strain_rate) + rounding);
        const SplineSample there = map.sample(x, y);
        ASSERT_LE(std::hypot(s.value[5] - there.value[5], s.value[6] - there.value[6]),
                  static_cast<double>(bounds.range_rate) + rounding);
        const double carried_s = map.windows().carried_s();
        for (const auto& [by_s, strain_min, range_m] :
             {std::tuple(carried_s, bounds.strain_on, bounds.range_on_m),
              std::tuple(-carried_s, bounds.strain_back, bounds.range_back_m),
              std::tuple(0.0, bounds.strain_min(), bounds.range_m())}) {
            const SplineSample to = carried(s, by_s), from = carried(there, by_s);
            ASSERT_GE(strains_of(to, 1, 2)[0], static_cast<double>(strain_min) - rounding);
            ASSERT_LE(std::hypot(to.value[1] - from.value[1], to.value[2] - from.value[2]),
                      static_cast<double>(range_m) + rounding);
        }
    }
}

// What is proved to be one to one is not searched: a window that is too small would go unseen.
TEST(Sheets, windows_bound_strains_and_displacements_within_their_radius) {
    const RealizationPtr sea = tests::make_sea({tests::random_cascade(100.0, 64, 18, 80, 0.03, 4)});
    const KeyframePtr waves = tests::exact_keyframe(sea, 0, 0);
    // Carried on it is calmer than carried back by half as much again and more: bounds of the one would not do for the other.
    Keyframe dies_down = *waves;
    std::ranges::transform(waves->plane(Field::displacement_x),
                           dies_down.plane(Field::displacement_x_rate).begin(), std::negate());
    std::ranges::transform(waves->plane(Field::displacement_y),
                           dies_down.plane(Field::displacement_y_rate).begin(), std::negate());
    const SplineMap map(*waves), calmer(dies_down);
    std::mt19937 random(4);
    std::uniform_real_distribution<double> place(-300, 300);
    for (int i = 0; i < 300; ++i) {
        const double x = place(random), y = place(random);
        const double radius_m = 0.5 * std::pow(2.0, i % 8);
        windows_bound(map, x, y, radius_m, random);
        windows_bound(calmer, x, y, radius_m, random);
    }
    const auto smallest = [](const SplineMap& of, double by_s) { // of four places a cell each way
        double least = 1e9;
        for (double y = 0; y < 100; y += 100.0 / 256)
            for (double x = 0; x < 100; x += 100.0 / 256)
                least = std::min(least, strains_of(carried(of.sample(x, y), by_s), 1, 2)[0]);
        return least;
    };
    const auto near = [](float bound, double least) {
        const auto low = static_cast<double>(bound);
        return low <= least + 1e-5 && low > 1.6 * least;
    };
    // Differences of coefficients exceed the slope of the finest waves here, of q = 0.56 pi a cell, by
    // 1 / (3/4 + cos(q)/4) = 1.42; and xx, yy and xy are smallest and largest at different places of a cell.
    const char* const why = "a bound that nothing comes near would search everywhere";
    EXPECT_PRED2(near, map.windows().whole_tile().strain_min(), smallest(map, 0)) << why;
    const StrainBounds& of_calmer = calmer.windows().whole_tile();
    const double carried_s = calmer.windows().carried_s();
    EXPECT_PRED2(near, of_calmer.strain_on, smallest(calmer, carried_s)) << why;
    EXPECT_PRED2(near, of_calmer.strain_back, smallest(calmer, -carried_s)) << why;
    EXPECT_NEAR(of_calmer.range_back_m / of_calmer.range_on_m, 1.25 / 0.75, 1e-3)
        << "a quarter of it comes or goes meanwhile";
}

// Naive: cells are bounded four at a time, and beyond the last one lies what is no sea. Sizes that are no multiple of four.
TEST(Sheets, windows_of_a_map_of_any_size_hold_its_waves_and_nothing_else) {
    for (const int size : {50, 51, 53, 64}) {
        const RealizationPtr sea = tests::make_sea(
            {tests::random_cascade(100.0, size, 3, 12, 0.03, 4)}); // long: far from 0, nearly flat
        const SplineMap map(*tests::exact_keyframe(sea, 0, 0));
        double smallest = 1e9;
        for (double y = 0; y < 100; y += 100.0 / 200)
            for (double x = 0; x < 100; x += 100.0 / 200)
                smallest = std::min(smallest, strains_of(map.sample(x, y), 1, 2)[0]);
        const auto bound = static_cast<double>(map.windows().whole_tile().strain_min());
        EXPECT_LE(bound, smallest + 1e-5) << size;
        EXPECT_LT(bound / smallest, 1.4) << size;
    }
}

// One coefficient among none: whatever a window leaves out shows in full. Naive: the spline at a place
// depends on the grid points beside it alone, and a radius may be as long as a block.
TEST(Sheets, windows_hold_whatever_a_spline_within_their_radius_depends_on) {
    for (const int lone : {15, 16, 17, 18}) { // wherever in its block
        Keyframe keyframe;
        keyframe.size = 32;
        keyframe.length_m = 32.0;
        keyframe.fields = surface_fields;
        keyframe.values.resize(6 * keyframe.plane_size());
        for (int iy = -1; iy <= 1; ++iy)
            for (int ix = -1; ix <= 1; ++ix) {
                // A cubic B-spline of its own: at its node and beside it.
                const float share = (ix == 0 ? 4.0f : 1.0f) * (iy == 0 ? 4.0f : 1.0f) / 36.0f;
                const auto node = static_cast<std::size_t>((lone + iy) * 32 + lone + ix);
                keyframe.plane(Field::displacement_x)[node] = share;
                keyframe.plane(Field::displacement_y)[node] = share;
            }
        const SplineMap map(keyframe);
        for (double place_m = 0; place_m < 32; place_m += 0.5)
            for (double radius_m = 0.25; radius_m < 16; radius_m += 0.25) {
                const StrainBounds& east = map.windows().around(place_m, lone, radius_m);
                const StrainBounds& north = map.windows().around(lone, place_m, radius_m);
                constexpr double rounding = 1e-5;
                const SplineSample here = map.sample(place_m, lone);
                for (double off_m = -radius_m; off_m <= radius_m; off_m += 0.25) {
                    const SplineSample there = map.sample(place_m + off_m, lone);
                    ASSERT_GE(strains_of(there, 1, 2)[0],
                              static_cast<double>(east.strain_min()) - rounding)
                        << lone << " " << place_m << " " << radius_m << " " << off_m;
                    ASSERT_LE(
                        std::hypot(there.value[1] - here.value[1], there.value[2] - here.value[2]),
                        static_cast<double>(east.range_m()) + rounding)
                        << lone << " " << place_m << " " << radius_m << " " << off_m;
                    ASSERT_GE(strains_of(map.sample(lone, place_m + off_m), 1, 2)[0],
                              static_cast<double>(north.strain_min()) - rounding)
                        << lone << " " << place_m << " " << radius_m << " " << off_m;
                }
            }
    }
}

TEST(Sheets, a_map_says_how_many_bytes_it_holds) {
    for (const int size : {16, 32, 64}) {
        const RealizationPtr sea =
            tests::make_sea({tests::random_cascade(50, size, 4, 5, 0.01, 1)});
        const SplineMap map(*tests::exact_keyframe(sea, 0, 0));
        EXPECT_EQ(StrainWindows::bytes_of(size), map.windows().bytes());
        EXPECT_EQ(SplineMap::bytes_of(size),
                  map.coefficients().size() * sizeof(float) + map.windows().bytes());
        EXPECT_EQ(map.bytes(), SplineMap::bytes_of(size));
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
