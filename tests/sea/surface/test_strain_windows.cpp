// SPDX-License-Identifier: Apache-2.0
// Windows of strains: what tells without a search that a place has one sheet.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <random>
#include <tuple>
#include <utility>

#include <gtest/gtest.h>

#include "sea/surface/maps/spline_map.h"
#include "tests/sea/surface/folding_sea.h"

namespace seaway::sea {
namespace {

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

// How far a map is carried is told by some of its places. Naive: every eighth of every eighth row, where such a wave is everywhere the
// same; carried by anything from nothing to minutes it is bounded by hundreds of times what it is.
TEST(Sheets, windows_of_waves_as_long_as_some_cells_are_as_near_as_any_others) {
    constexpr int size = 128;
    constexpr double strain = 0.3, omega_radps = 2;
    for (const auto& [waves_x, waves_y] : {std::pair(16, 0), {0, 16}, {16, 16}, {32, 0}, {8, 24}})
        for (double phase = 0; phase < two_pi; phase += 0.1) {
            Keyframe map{0, 0, 0, size, double{size}, surface_fields, {}};
            map.values.resize(6 * map.plane_size());
            const double k_radpm = two_pi / size * std::hypot(waves_x, waves_y);
            for (std::size_t i = 0; i < map.plane_size(); ++i) {
                const double at = two_pi / size *
                                      (static_cast<double>(i % size) * waves_x +
                                       static_cast<double>(i / size) * waves_y) +
                                  phase;
                const double along = strain / k_radpm / std::hypot(waves_x, waves_y);
                for (const auto& [to, rate, share] :
                     {std::tuple(Field::displacement_x, Field::displacement_x_rate, waves_x),
                      std::tuple(Field::displacement_y, Field::displacement_y_rate, waves_y)}) {
                    map.plane(to)[i] = static_cast<float>(along * share * std::sin(at));
                    map.plane(rate)[i] =
                        static_cast<float>(along * share * omega_radps * std::cos(at));
                }
            }
            const SplineMap spline(map);
            ASSERT_NEAR(spline.windows().carried_s(), 0.25 / omega_radps, 0.05)
                << waves_x << " " << waves_y << " " << phase;
            ASSERT_GT(static_cast<double>(spline.windows().whole_tile().strain_min()), -2 * strain);
        }
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

} // namespace
} // namespace seaway::sea
