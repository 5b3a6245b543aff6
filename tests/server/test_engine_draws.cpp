// SPDX-License-Identifier: Apache-2.0
// What examples/engine.md tells engines of a real sea: maps drawn as a GPU samples them are the sea that is sampled, foam is put together
// of them, a grant holds on level water, and waves that move nothing sideways say so.
#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "client/seaway.hpp"
#include "client/seaway_engine.h"
#include "tests/support/eventually.h"
#include "tests/support/server_process.h"

namespace seaway {
namespace {

/// A sea of the real server, and a client of it.
struct Served {
    tests::ServerProcess server;
    std::string url;
    Sea sea;

    explicit Served(const std::string& scene)
        : server({scene, "--listen", "127.0.0.1:0", "--device", "native"}),
          url(server.wait_until_ready()), sea(url, patient()) {}

    /// Maps and the points beside them are of one time, however long they take on a busy machine.
    static seaway_connect_options patient() {
        seaway_connect_options options{};
        options.look_back_s = 30;
        return options;
    }
};

std::vector<seaway_point> places(int count, std::int64_t time_us) {
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> place(-2000, 2000);
    std::vector<seaway_point> made;
    for (int i = 0; i < count; ++i)
        made.push_back({place(random), place(random), time_us});
    return made;
}

double root_mean_square(const std::vector<double>& values) {
    double sum = 0;
    for (const double value : values)
        sum += value * value;
    return std::sqrt(sum / static_cast<double>(values.size()));
}

// ---- what is drawn ---------------------------------------------------------------------------

enum Channel { east, north, height, foam, channels };
using Texel = std::array<double, channels>;
/// Of the four texels around a share of one, along an axis.
using Filter = std::array<double, 4> (*)(double share);

std::array<double, 4> linear(double f) {
    return {0, 1 - f, f, 0};
}
std::array<double, 4> catmull_rom(double f) {
    return {-0.5 * f + f * f - 0.5 * f * f * f, 1 - 2.5 * f * f + 1.5 * f * f * f,
            0.5 * f + 2 * f * f - 1.5 * f * f * f, -0.5 * f * f + 0.5 * f * f * f};
}

/// A map in the memory of a GPU: the centre of texel i lies at (i + 0.5) / grid, and u repeats at 1.
struct Texture {
    seaway_map map = SEAWAY_SIZED(seaway_map);
    seaway_cascade cascade = SEAWAY_SIZED(seaway_cascade);
    std::vector<float> texels;

    Texture(const Sea& sea, std::uint32_t index, std::int64_t time_us) {
        seaway_map_wish wish = SEAWAY_SIZED(seaway_map_wish);
        wish.cascade = index;
        wish.time_us = time_us;
        wish.channels = channels;
        wish.field[east] = SEAWAY_DISPLACEMENT_X;
        wish.field[north] = SEAWAY_DISPLACEMENT_Y;
        wish.field[height] = SEAWAY_HEIGHT;
        wish.field[foam] = SEAWAY_FOAM;
        EXPECT_EQ(seaway_get_cascade(sea.handle(), time_us, index, &cascade), SEAWAY_OK);
        texels.resize(std::size_t{channels} * cascade.grid * cascade.grid);
        EXPECT_EQ(
            seaway_get_map(sea.handle(), &wish, texels.data(), texels.size() * sizeof(float), &map),
            SEAWAY_OK)
            << seaway_last_error();
    }
    Texel at(double u, double v, Filter filter) const {
        const auto grid = static_cast<double>(map.grid);
        const double x = u * grid - 0.5, y = v * grid - 0.5;
        const auto along_x = filter(x - std::floor(x)), along_y = filter(y - std::floor(y));
        const auto place = [&](double at, int step) {
            const double index = std::floor(at) - 1 + step;
            return static_cast<std::size_t>(index - std::floor(index / grid) * grid);
        };
        Texel sum{};
        for (int j = 0; j < 4; ++j)
            for (int i = 0; i < 4; ++i)
                for (std::size_t c = 0; c < channels; ++c)
                    sum[c] += along_x[static_cast<std::size_t>(i)] *
                              along_y[static_cast<std::size_t>(j)] *
                              static_cast<double>(
                                  texels[(place(y, j) * map.grid + place(x, i)) * channels + c]);
        return sum;
    }
};

class EngineDraws : public testing::Test {
  protected:
    Served gale{"scenes/north_sea_gale.toml"};
    Sea& sea = gale.sea;
    std::int64_t now_us = 0;
    std::vector<Texture> textures;

    void SetUp() override {
        seaway_wish wish = SEAWAY_SIZED(seaway_wish);
        wish.fields = SEAWAY_SURFACE_FIELDS | SEAWAY_BIT(SEAWAY_FOAM);
        wish.timeout_s = 300; // however busy the machine is
        ASSERT_EQ(seaway_subscribe_to(sea.handle(), &wish, nullptr), SEAWAY_OK)
            << seaway_last_error();
        now_us = sea.now_us();
        for (std::uint32_t c = 0; c < sea.at(now_us).cascades; ++c)
            textures.emplace_back(sea, c, now_us);
    }

    struct Vertex {
        seaway_point point;
        double height_m;
        double coverage; ///< that is white
    };
    /// Where the undisplaced points of a grid go, by the formulas of the page; `texels` is what is added to u and v.
    std::vector<Vertex> drawn(Filter filter, double texels) const {
        std::vector<Vertex> vertices;
        for (const seaway_point& from : places(2000, now_us)) {
            double x_m = from.x_m, y_m = from.y_m, height_m = 0, product = 2;
            for (const Texture& texture : textures) {
                const seaway_map& map = texture.map;
                const double u = from.x_m / map.length_m + texels / map.grid;
                const double v = from.y_m / map.length_m + texels / map.grid;
                const Texel texel = texture.at(u, v, filter);
                x_m += texture.cascade.choppiness_x * texel[east];
                y_m += texture.cascade.choppiness_y * texel[north];
                height_m += texel[height];
                product *= (1 + texture.at(u, v, linear)[foam]) / 2;
            }
            const double coverage = textures[0].map.foam_mean * (product - 1);
            vertices.push_back({{x_m, y_m, now_us}, height_m, std::clamp(coverage, 0.0, 1.0)});
        }
        return vertices;
    }
    /// From the surface that is sampled there; the underside of a fold is not that.
    std::vector<double> off_m(Filter filter, double texels) const {
        std::vector<double> off;
        for (const Vertex& vertex : drawn(filter, texels)) {
            const seaway_answer water = sea.sample(vertex.point);
            if (!(water.flags & SEAWAY_FOLDED))
                off.push_back(vertex.height_m - water.height_m);
        }
        return off;
    }
};

// The filters' own errors, as the page says them: 3.4 mm and 3.3 cm rms of this sea. Half a texel beside, which is what "texel i is the
// point i" looks like to a GPU, it would be a quarter of a metre.
TEST_F(EngineDraws, the_sea_that_it_samples) {
    EXPECT_LT(root_mean_square(off_m(catmull_rom, 0.5)), 0.005);
    EXPECT_NEAR(root_mean_square(off_m(linear, 0.5)), 0.033, 0.01);
    EXPECT_GT(root_mean_square(off_m(linear, 0)), 0.15);
}

// What is drawn and what is sampled lie some millimetres apart (above), and foam varies by all of itself over a texel of 0.2 m or so.
TEST_F(EngineDraws, the_foam_that_it_samples) {
    std::vector<double> off, white;
    for (const Vertex& vertex : drawn(catmull_rom, 0.5)) {
        seaway_water water{};
        ASSERT_EQ(
            seaway_sample_water(sea.handle(), nullptr, &vertex.point, 1, &water, sizeof water),
            SEAWAY_OK)
            << seaway_last_error();
        if (water.answer.flags & SEAWAY_FOLDED)
            continue;
        off.push_back(vertex.coverage - water.foam);
        white.push_back(water.foam);
    }
    EXPECT_LT(root_mean_square(off), 0.003);
    EXPECT_GT(root_mean_square(white), 0.04) << "four parts of a hundred are white";
}

// Of level water, and the place of the answer is met to 2 % of the budget beside; on slopes displacements count, too. A stream that
// has just begun is of rates that are as wrong as its heights, and states up to a quarter more until differences have settled.
TEST_F(EngineDraws, no_more_than_the_grant_states_on_level_water_and_more_on_slopes) {
    seaway_wish wish = SEAWAY_SIZED(seaway_wish);
    seaway_grant grant = SEAWAY_SIZED(seaway_grant);
    wish.error_m = 1;
    wish.timeout_s = 300;
    Sea coarse(gale.url); // it holds nothing finer
    ASSERT_EQ(seaway_subscribe_to(coarse.handle(), &wish, &grant), SEAWAY_OK)
        << seaway_last_error();
    const double most_m = grant.error_m + 0.02 * sea.at(now_us).height_error_m;
    struct Stated {
        int level = 0, steep = 0;
        double level_most_m = 0, level_sum_m = 0, steep_sum_m = 0;
    };
    const auto stated = [&] {
        Stated now;
        for (const seaway_answer& water : coarse.sample(places(5000, coarse.now_us()))) {
            if (water.flags != 0)
                continue;
            const double slope = std::hypot(water.normal[0], water.normal[1]) / water.normal[2];
            if (slope < 0.01) {
                ++now.level;
                now.level_sum_m += water.error_m;
                now.level_most_m = std::max(now.level_most_m, water.error_m);
            } else if (slope > 0.1) {
                ++now.steep;
                now.steep_sum_m += water.error_m;
            }
        }
        return now;
    };
    EXPECT_LE(stated().level_most_m, 1.25 * most_m);
    Stated settled;
    EXPECT_TRUE(tests::eventually([&] {
        settled = stated();
        return settled.level > 5 && settled.level_most_m <= most_m;
    })) << settled.level_most_m
        << " m where " << most_m << " are granted";
    ASSERT_GT(settled.steep, 100);
    EXPECT_GT(settled.steep_sum_m / settled.steep, 1.01 * settled.level_sum_m / settled.level);
}

// ---- waves that are no modes -----------------------------------------------------------------

/// Gerstner's waves, which are modes, on one tile, and sharp crests of no theory on another.
class StylisedWaves : public testing::Test {
  protected:
    static std::string scene() {
        const std::string path = testing::TempDir() + "seaway_stylised.toml";
        std::ofstream(path) << R"(
[sea]
seed = 7
[[sea.system]]
type = "sines"
shape = "gerstner"
length_m = 301.0
count = 3
amplitude_m = 0.8
wavelength_m = 75.0
from_deg = 250
[[sea.system]]
type = "sines"
shape = "exponential"
length_m = 43.0
count = 1
amplitude_m = 0.3
wavelength_m = 21.5
from_deg = 270
[[cascade]]
length_m = 301.0
size = 64
[[cascade]]
length_m = 43.0
size = 64
)";
        return path;
    }
    Served served{scene()};
    Sea& sea = served.sea;
    seaway_looking modes = SEAWAY_SIZED(seaway_looking), sharp = modes;
    std::vector<seaway_point> asked;
    std::vector<double> z_m;

    void SetUp() override {
        modes.cascades = 1;
        sharp.cascades = 2;
        seaway_subscription patient{};
        patient.timeout_s = 300;
        sea.subscribe(patient);
        asked = places(50, sea.now_us());
        z_m.assign(asked.size(), -2.0);
    }
    static void expect(const std::vector<seaway_answer>& answers, bool vertical) {
        for (const seaway_answer& water : answers)
            EXPECT_EQ((water.flags & SEAWAY_VERTICAL_VELOCITY) != 0, vertical);
    }
    std::vector<seaway_answer> sampled(const seaway_looking* looking) const {
        std::vector<seaway_answer> answers(asked.size());
        seaway_sampling how = SEAWAY_SIZED(seaway_sampling);
        how.looking = looking;
        EXPECT_EQ(seaway_sample_as(sea.handle(), &how, asked.data(), asked.size(), answers.data()),
                  SEAWAY_OK)
            << seaway_last_error();
        return answers;
    }
    std::vector<seaway_answer> queried(const seaway_looking* looking, int exact) {
        std::vector<seaway_answer> answers(asked.size());
        EXPECT_EQ(seaway_query_some(sea.handle(), looking, asked.data(), asked.size(), exact, 300,
                                    answers.data()),
                  SEAWAY_OK)
            << seaway_last_error();
        return answers;
    }
    void everywhere(const seaway_looking* looking, bool vertical) {
        expect(sampled(looking), vertical);
        expect(queried(looking, 0), vertical);
        expect(queried(looking, 1), vertical);
    }
    /// Here, or by the server.
    std::vector<seaway_below> below(const seaway_looking* looking, bool here) {
        std::vector<seaway_below> water(asked.size());
        const seaway_code code =
            here ? seaway_sample_below(sea.handle(), looking, asked.data(), z_m.data(),
                                       asked.size(), water.data(), sizeof(seaway_below))
                 : seaway_query_below(sea.handle(), looking, asked.data(), z_m.data(), asked.size(),
                                      300, water.data(), sizeof(seaway_below));
        EXPECT_EQ(code, SEAWAY_OK) << seaway_last_error();
        return water;
    }
};

TEST_F(StylisedWaves, have_a_vertical_velocity_and_say_so_from_whatever_answers) {
    for (const bool of_waves : {false, true}) {
        if (of_waves) {
            ASSERT_EQ(seaway_rebuild(sea.handle(), asked[0].time_us), SEAWAY_OK)
                << seaway_last_error();
        }
        everywhere(nullptr, true);
        everywhere(&sharp, true);
        everywhere(&modes, false);
        double sideways_mps = 0, upwards_mps = 0;
        for (const seaway_answer& water : sampled(&sharp)) {
            sideways_mps = std::max(sideways_mps, std::abs(water.velocity_mps[0]));
            upwards_mps = std::max(upwards_mps, std::abs(water.velocity_mps[2]));
        }
        EXPECT_EQ(sideways_mps, 0);
        EXPECT_GT(upwards_mps, 0.1);
    }
}

TEST_F(StylisedWaves, have_no_water_below_them_and_say_so) {
    ASSERT_EQ(seaway_rebuild(sea.handle(), asked[0].time_us), SEAWAY_OK) << seaway_last_error();
    for (const bool here : {false, true}) {
        const auto all = below(nullptr, here), crests = below(&sharp, here),
                   rest = below(&modes, here);
        double pressure_m2ps2 = 0;
        for (std::size_t i = 0; i < asked.size(); ++i) {
            EXPECT_TRUE(all[i].surface.flags & SEAWAY_VERTICAL_VELOCITY);
            EXPECT_TRUE(crests[i].surface.flags & SEAWAY_VERTICAL_VELOCITY);
            EXPECT_FALSE(rest[i].surface.flags & SEAWAY_VERTICAL_VELOCITY);
            EXPECT_EQ(crests[i].pressure_m2ps2, 0);
            pressure_m2ps2 = std::max(pressure_m2ps2, std::abs(all[i].pressure_m2ps2));
        }
        EXPECT_GT(pressure_m2ps2, 0.1) << "of the waves beside them";
    }
}

} // namespace
} // namespace seaway
