// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <tuple>

#include <gtest/gtest.h>

#include "sea/basics/cascade.h"
#include "sea/basics/constants.h"
#include "sea/surface/maps/regrid.h"
#include "tests/support/largest_difference.h"

namespace seaway::sea {
namespace {

/// A sum of waves, at any grid.
struct Waves {
    struct Wave {
        int nx, ny;
        double amplitude, phase;
    };
    std::vector<Wave> waves;

    double at(double x, double y) const { // in tiles
        double sum = 0;
        for (const Wave& wave : waves)
            sum += wave.amplitude *
                   std::cos(2.0 * std::numbers::pi * (wave.nx * x + wave.ny * y) + wave.phase);
        return sum;
    }
    std::vector<float> map(int size) const {
        std::vector<float> map;
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x)
                map.push_back(static_cast<float>(
                    at(static_cast<double>(x) / size, static_cast<double>(y) / size)));
        return map;
    }
    double rms() const {
        double variance = 0;
        for (const Wave& wave : waves)
            variance += 0.5 * wave.amplitude * wave.amplitude;
        return std::sqrt(variance);
    }
};

/// Waves with |n| < reach, the finest ones among them, steep like a sea's (k^-2 a mode).
Waves waves_within(double reach, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> any(-1.0, 1.0);
    Waves sea;
    const int finest = static_cast<int>(std::ceil(reach)) - 1;
    for (int i = 0; i < 60; ++i) {
        const int nx = i == 0 ? finest : static_cast<int>(any(random) * reach);
        const int ny = i == 1 ? -finest : i == 0 ? 0 : static_cast<int>(any(random) * reach);
        if (nx * nx + ny * ny < reach * reach)
            sea.waves.push_back(
                {nx, ny, 1.0 / (1.0 + 0.1 * (nx * nx + ny * ny)), 3.0 * any(random)});
    }
    return sea;
}

// Sides with every radix, odd and even, to smaller and to larger grids; two maps at once, which do not mix.
TEST(Regrid, waves_of_both_grids_are_the_same_sum_of_waves_on_either) {
    for (const auto& [from, to] : {std::pair(256, 80),
                                   {80, 256},
                                   {256, 81},
                                   {75, 128},
                                   {128, 72},
                                   {64, 45},
                                   {512, 320},
                                   {16, 15},
                                   {15, 16},
                                   {27, 25},
                                   {64, 64}}) {
        const Waves sea = waves_within(0.5 * std::min(from, to), 1);
        Waves other = waves_within(0.5 * std::min(from, to), 2);
        for (Waves::Wave& wave : other.waves)
            wave.amplitude *= 1e-2;
        const std::vector<float> sea_from = sea.map(from), other_from = other.map(from);
        const std::vector<float> sea_to = sea.map(to), other_to = other.map(to);
        // Half of what both ways may cost; of the larger map, which the smaller one is rounded beside.
        const double bound = 0.5 * regrid_precision * 4.0 * sea.rms();
        for (const Instructions instructions : supported_instructions()) {
            std::vector<float> a(sea_to.size()), b(a.size());
            Regrid(from, to, instructions).maps(sea_from, other_from, a, b);
            EXPECT_LE(tests::largest_difference(a, sea_to), bound) << from << " to " << to;
            EXPECT_LE(tests::largest_difference(b, other_to), bound) << from << " to " << to;
        }
    }
}

TEST(Regrid, waves_beyond_the_disc_of_the_smaller_grid_are_left_out) {
    // 30^2 + 30^2 < 45^2, within the disc of 90; 35^2 + 35^2 is beyond, though each index alone is below 45.
    const Waves inside{{{30, 30, 1.0, 0.3}}}, outside{{{35, 35, 1.0, 0.3}}};
    std::vector<float> a(90 * 90), b(a.size());
    Regrid(256, 90).maps(inside.map(256), outside.map(256), a, b);
    EXPECT_LE(tests::largest_difference(a, inside.map(90)), 1e-5);
    EXPECT_LE(tests::largest_difference(b, std::vector<float>(b.size())), 1e-5);
}

// Rounding is even noise. What is left of it on the larger grid has the disc's share of its variance at grid
// points and between coarse ones alike, and a gradient of (pi / spacing)^2 / 4 of that along each axis.
TEST(Regrid, noise_of_the_smaller_grid_keeps_the_discs_share_of_its_variance_everywhere) {
    constexpr int small = 80, large = 240; // every third point stands on a coarse one
    std::mt19937 random(5);
    std::uniform_real_distribution<float> even(-1.0f, 1.0f);
    double on = 0, between = 0, slope = 0;
    const int draws = 8;
    for (int draw = 0; draw < draws; ++draw) {
        std::vector<float> a(small * small), b(a.size());
        for (std::size_t i = 0; i < a.size(); ++i) {
            a[i] = even(random);
            b[i] = even(random);
        }
        std::vector<float> wide_a(large * large), wide_b(wide_a.size());
        Regrid(small, large).maps(a, b, wide_a, wide_b);
        for (int y = 0; y < large; ++y)
            for (int x = 0; x < large; ++x) {
                const double value =
                    static_cast<double>(wide_a[static_cast<std::size_t>(y * large + x)]);
                (x % 3 == 0 && y % 3 == 0 ? on : between) += value * value;
                const double next = static_cast<double>(
                    wide_a[static_cast<std::size_t>(y * large + (x + 1) % large)]);
                slope += (next - value) * (next - value) * 9.0; // spacings of the coarse grid
            }
    }
    const double share = disc_share(small);
    EXPECT_NEAR(share, std::numbers::pi / 4.0, 0.01);
    // 51 200 independent numbers: a variance within 0.9 % (one standard deviation of those kept).
    const double coarse = draws * small * small;
    EXPECT_NEAR(on / coarse * 3.0, share, 0.03);
    EXPECT_NEAR(between / (8.0 * coarse) * 3.0, share, 0.03);
    // Differences over a third of a spacing see 0.93 of the gradient.
    EXPECT_NEAR(slope / (9.0 * coarse) * 3.0, 0.93 * share * std::pow(std::numbers::pi, 2) / 4.0,
                0.1);
}

// D = i k/|k| coth(k d) h (Tessendorf 2001; physics.md section 0): of a crest cos(k.x) it is -k/|k| coth(k d) sin(k.x).
TEST(Regrid, displacements_follow_from_heights_in_any_depth) {
    constexpr double length_m = 300.0;
    const Waves sea = waves_within(20, 6), rate = waves_within(20, 7);
    for (const double depth_m : {deep_water_m, 50.0, 4.0})
        for (const auto& [from, to] : {std::pair(40, 64), {45, 128}, {64, 64}}) {
            const Orbits orbits(std::min(from, to), length_m, depth_m);
            std::vector<float> maps[6];
            for (auto& map : maps)
                map.resize(static_cast<std::size_t>(to * to));
            const Regrid regrid(from, to);
            regrid.maps(sea.map(from), rate.map(from), orbits, {maps[0], maps[1]},
                        {maps[2], maps[3]}, {maps[4], maps[5]});
            EXPECT_LE(tests::largest_difference(maps[0], sea.map(to)),
                      0.5 * regrid_precision * 4.0 * sea.rms());
            for (const auto& [waves, x, y] :
                 {std::tuple(&sea, &maps[2], &maps[4]), {&rate, &maps[3], &maps[5]}}) {
                Waves along_x, along_y;
                for (Waves::Wave wave : waves->waves) {
                    const double index = std::hypot(wave.nx, wave.ny);
                    if (index == 0)
                        continue; // the mean moves nothing
                    const double aspect =
                        1.0 / std::tanh(2.0 * std::numbers::pi * index / length_m * depth_m);
                    wave.phase += 0.5 * std::numbers::pi; // cos(x + pi/2) = -sin(x)
                    for (auto& [moved, n] : {std::pair(&along_x, wave.nx), {&along_y, wave.ny}}) {
                        moved->waves.push_back(wave);
                        moved->waves.back().amplitude *= aspect * n / index;
                    }
                }
                // A map's own rounding, of waves that shallow water moves further than up and down.
                const double bound = regrid_precision * 4.0 * (along_x.rms() + along_y.rms());
                EXPECT_LE(tests::largest_difference(*x, along_x.map(to)), bound)
                    << from << " " << depth_m;
                EXPECT_LE(tests::largest_difference(*y, along_y.map(to)), bound)
                    << from << " " << depth_m;
            }
            std::vector<float> none, only(maps[2].size());
            regrid.maps(sea.map(from), rate.map(from), orbits, {}, {only, none}, {});
            EXPECT_EQ(only, maps[2]) << "what is not wanted changes nothing";
        }
}

// In deep water half of a wave's motion is along each axis; in water of 4 m long ones go several times as far.
TEST(Regrid, noise_of_heights_becomes_half_of_it_in_a_displacement_in_deep_water) {
    EXPECT_NEAR(Orbits(80, 2111.0, deep_water_m).gain(), 0.5, 1e-12);
    // Of 5000 waves four have kd = 0.28 and go 3.6 times as far, the next four 0.40 and 2.6 times.
    EXPECT_NEAR(Orbits(80, 2111.0, 95.0).gain(), 0.515, 0.005);
    const Orbits shallow(45, 300.0, 4.0);
    EXPECT_GT(shallow.gain(), 0.6);
    std::mt19937 random(8);
    std::uniform_real_distribution<float> even(-1.0f, 1.0f);
    double moved = 0, heights = 0;
    for (int draw = 0; draw < 20; ++draw) {
        std::vector<float> a(45 * 45), x(a.size()), y(a.size()), kept(a.size()), other(a.size());
        for (float& value : a)
            value = even(random);
        Regrid(45, 45).maps(a, a, shallow, {kept, other}, {x, {}}, {y, {}});
        for (std::size_t i = 0; i < a.size(); ++i) {
            heights += static_cast<double>(kept[i]) * static_cast<double>(kept[i]);
            moved += 0.5 * (static_cast<double>(x[i]) * static_cast<double>(x[i]) +
                            static_cast<double>(y[i]) * static_cast<double>(y[i]));
        }
    }
    // 40 000 numbers; the largest gains are of a few waves.
    EXPECT_NEAR(moved / heights, shallow.gain(), 0.05 * shallow.gain());
}

TEST(Regrid, the_smallest_grid_holds_the_finest_wave_and_is_a_product_of_2_3_and_5) {
    EXPECT_EQ(smallest_grid(40.0, 256),
              81); // a wave of index 40 on 80 points would be its own mirror
    EXPECT_EQ(smallest_grid(39.9, 256), 80);
    EXPECT_EQ(smallest_grid(76.8, 256), 160);
    EXPECT_EQ(smallest_grid(127.0, 256), 256);
    EXPECT_EQ(smallest_grid(0.0, 256), 1) << "flat water";
    for (const int size : {1, 2, 3, 5, 80, 81, 256, 1024, 3888})
        EXPECT_TRUE(Regrid::takes(size)) << size;
    for (const int size : {-4, 0, 7, 14, 77, 4097, 8192})
        EXPECT_FALSE(Regrid::takes(size)) << size;
}

TEST(Regrid, one_map_alone_and_many_of_a_keyframe_are_taken) {
    const Waves height = waves_within(20, 3), rate = waves_within(20, 4),
                slope = waves_within(20, 5);
    const FieldSet fields{Field::height, Field::height_rate, Field::slope_x};
    Keyframe keyframe{1, 0, 7, 64, 100.0, fields | FieldSet{Field::foam}, {}};
    for (const Waves* waves : {&height, &rate, &slope, &slope}) {
        const std::vector<float> map = waves->map(64);
        keyframe.values.insert(keyframe.values.end(), map.begin(), map.end());
    }
    Keyframe small{1, 0, 7, 45, 100.0, fields, {}};
    Regrid(64, 45).maps(keyframe, fields, small);
    ASSERT_EQ(small.values.size(), 3u * 45 * 45);
    const auto of = [&](Field field) {
        return std::vector<float>(small.plane(field).begin(), small.plane(field).end());
    };
    EXPECT_LE(tests::largest_difference(of(Field::height), height.map(45)), 1e-5);
    EXPECT_LE(tests::largest_difference(of(Field::height_rate), rate.map(45)), 1e-5);
    EXPECT_LE(tests::largest_difference(of(Field::slope_x), slope.map(45)), 1e-5);
}

} // namespace
} // namespace seaway::sea
