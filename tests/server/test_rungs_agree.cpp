// SPDX-License-Identifier: Apache-2.0
// One question, four sources: what a client answers from tiles, from waves that were sent, from waves that it made itself, and
// what the server answers differ by no more than they say.
#include <cmath>
#include <map>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "client/seaway.hpp"
#include "client/seaway_engine.h"
#include "tests/support/server_process.h"

namespace seaway {
namespace {

class RungsAgree : public ::testing::Test {
  protected:
    std::unique_ptr<tests::ServerProcess> server;
    std::map<std::uint32_t, std::unique_ptr<Sea>> seas; ///< by SEAWAY_FROM_*
    std::mt19937_64 random{17};

    void SetUp() override {
        server = std::make_unique<tests::ServerProcess>(std::vector<std::string>{
            "scenes/north_sea_gale.toml", "--listen", "127.0.0.1:0", "--device", "native"});
        const std::string url = server->wait_until_ready();
        ASSERT_FALSE(url.empty()) << server->log();
        for (std::uint32_t from = SEAWAY_FROM_SERVER; from <= SEAWAY_FROM_PARAMETERS; ++from)
            seas[from] = std::make_unique<Sea>(url);
        seaway_subscription spectrum{};
        spectrum.rung = SEAWAY_SPECTRUM;
        spectrum.timeout_s = 300; // however busy the machine is
        seas[SEAWAY_FROM_SPECTRUM]->subscribe(spectrum);
        Sea& own = *seas[SEAWAY_FROM_PARAMETERS];
        ASSERT_EQ(seaway_rebuild(own.handle(), own.now_us()), SEAWAY_OK) << seaway_last_error();
    }

    /// Anywhere within 100 km, each at a time of its own within 50 ms of one between an hour before and a month after the
    /// epoch: tiles come by intervals.
    std::vector<seaway_point> points(int count) {
        std::uniform_real_distribution<double> place(-1e5, 1e5);
        const std::int64_t begin_us = std::uniform_int_distribution<std::int64_t>(
            -3'600'000'000, 30 * 86'400'000'000)(random);
        std::uniform_int_distribution<std::int64_t> moment_us(0, 50'000);
        std::vector<seaway_point> made;
        for (int i = 0; i < count; ++i)
            made.push_back({place(random), place(random), begin_us + moment_us(random)});
        std::vector<std::int64_t> times_us;
        for (const seaway_point& point : made)
            times_us.push_back(point.time_us);
        seas[SEAWAY_FROM_TILES]->hold(times_us, 300);
        for (const auto& [from, sea] : seas) {
            seaway_source source = SEAWAY_SIZED(seaway_source);
            EXPECT_EQ(seaway_get_source(sea->handle(), begin_us, &source), SEAWAY_OK);
            EXPECT_EQ(source.source, from) << source.why;
        }
        return made;
    }
};

/// Which sheet is the highest is open: the one thing that error_m is no bound of.
bool open_at(const seaway_answer& a, const seaway_answer& b) {
    return ((a.flags | b.flags) & SEAWAY_OPEN) != 0;
}

// Bounds of maps are five standard deviations: one of a million answers lies beyond, so none of these.
TEST_F(RungsAgree,
       at_10000_random_places_and_times_all_sources_agree_within_the_sum_of_their_bounds) {
    int compared = 0, open = 0;
    for (int interval = 0; interval < 25; ++interval) {
        const std::vector<seaway_point> asked = points(400);
        std::map<std::uint32_t, std::vector<seaway_answer>> answers;
        for (const auto& [from, sea] : seas)
            answers[from] =
                from == SEAWAY_FROM_SERVER ? sea->query(asked, false, 300) : sea->sample(asked);
        for (auto one = answers.begin(); one != answers.end(); ++one)
            for (auto other = std::next(one); other != answers.end(); ++other)
                for (std::size_t i = 0; i < asked.size(); ++i) {
                    const seaway_answer& a = one->second[i];
                    const seaway_answer& b = other->second[i];
                    ASSERT_EQ((a.flags | b.flags) & SEAWAY_EXTRAPOLATED, 0u);
                    ++compared;
                    if (open_at(a, b)) {
                        ++open;
                        continue;
                    }
                    EXPECT_LE(std::abs(a.height_m - b.height_m), a.error_m + b.error_m)
                        << one->first << " and " << other->first << " at " << asked[i].x_m << " "
                        << asked[i].y_m << " " << asked[i].time_us;
                }
    }
    EXPECT_EQ(compared, 6 * 10'000);
    EXPECT_LT(open, compared / 100) << "else nothing was compared";
}

/// From waves, each point summed.
std::vector<seaway_answer> summed(const Sea& sea, const std::vector<seaway_point>& points) {
    seaway_sampling how = SEAWAY_SIZED(seaway_sampling);
    how.from = SEAWAY_WAVES_SUMMED;
    std::vector<seaway_answer> answers(points.size());
    EXPECT_EQ(seaway_sample_as(sea.handle(), &how, points.data(), points.size(), answers.data()),
              SEAWAY_OK)
        << seaway_last_error();
    return answers;
}

// Six keyframes of 256 x 256 are some 20 ms, a sum 60 us: 3 points are summed, 2000 are worth maps.
TEST_F(RungsAgree, who_has_waves_sums_few_points_and_makes_maps_for_many_within_their_bounds) {
    std::vector<seaway_point> many = points(2000);
    for (seaway_point& point : many)
        point.time_us = many[0].time_us;
    const std::vector<seaway_point> few(many.begin(), many.begin() + 3);
    for (const std::uint32_t from : {SEAWAY_FROM_SPECTRUM, SEAWAY_FROM_PARAMETERS}) {
        Sea& sea = *seas[from];
        const std::vector<seaway_answer> truth = summed(sea, many);
        const std::vector<seaway_answer> first = sea.sample(few);
        for (std::size_t i = 0; i < few.size(); ++i)
            EXPECT_EQ(first[i].height_m, truth[i].height_m) << "to the bit: a sum itself";
        const std::vector<seaway_answer> answers = sea.sample(many);
        int maps = 0;
        for (std::size_t i = 0; i < many.size(); ++i) {
            EXPECT_EQ(answers[i].flags & SEAWAY_EXTRAPOLATED, 0u);
            if (open_at(answers[i], truth[i]))
                continue;
            EXPECT_LE(std::abs(answers[i].height_m - truth[i].height_m),
                      answers[i].error_m + truth[i].error_m);
            maps += answers[i].error_m > truth[i].error_m;
        }
        EXPECT_GT(maps, 1900) << "which cost more of the error, less of the time";
        EXPECT_EQ(sea.sample(few)[0].error_m, answers[0].error_m) << "and are there from then on";
    }
}

TEST_F(RungsAgree, whole_maps_and_all_that_is_known_of_points_come_of_waves_as_of_tiles) {
    std::vector<seaway_point> many = points(1000);
    for (seaway_point& point : many)
        point.time_us = many[0].time_us;
    std::map<std::uint32_t, std::vector<seaway_water>> water;
    std::map<std::uint32_t, std::vector<float>> texels;
    std::map<std::uint32_t, seaway_map> maps;
    for (const std::uint32_t from :
         {SEAWAY_FROM_TILES, SEAWAY_FROM_SPECTRUM, SEAWAY_FROM_PARAMETERS}) {
        seaway_client* client = seas[from]->handle();
        water[from].resize(many.size());
        ASSERT_EQ(seaway_sample_water(client, nullptr, many.data(), many.size(), water[from].data(),
                                      sizeof(seaway_water)),
                  SEAWAY_OK)
            << seaway_last_error();
        seaway_map_wish wish = SEAWAY_SIZED(seaway_map_wish);
        wish.cascade = 1;
        wish.time_us = many[0].time_us;
        wish.channels = 2;
        wish.field[0] = SEAWAY_HEIGHT;
        wish.field[1] = SEAWAY_DISPLACEMENT_Y;
        seaway_map& map = maps[from] = SEAWAY_SIZED(seaway_map);
        ASSERT_EQ(seaway_get_map(client, &wish, nullptr, 0, &map), SEAWAY_OK)
            << seaway_last_error();
        texels[from].resize(map.bytes / sizeof(float));
        ASSERT_EQ(seaway_get_map(client, &wish, texels[from].data(), map.bytes, &map), SEAWAY_OK)
            << seaway_last_error();
        EXPECT_EQ(map.flags, 0u);
    }
    const std::uint32_t tiles = SEAWAY_FROM_TILES;
    for (const std::uint32_t from : {SEAWAY_FROM_SPECTRUM, SEAWAY_FROM_PARAMETERS}) {
        for (std::size_t i = 0; i < many.size(); ++i) {
            const seaway_water &here = water[tiles][i], &there = water[from][i];
            if (open_at(here.answer, there.answer))
                continue;
            EXPECT_LE(std::abs(here.answer.height_m - there.answer.height_m),
                      here.answer.error_m + there.answer.error_m);
            for (int axis = 0; axis < 2; ++axis)
                EXPECT_LE(std::abs(here.displacement_m[axis] - there.displacement_m[axis]),
                          here.displacement_error_m + there.displacement_error_m);
        }
        ASSERT_EQ(texels[from].size(), texels[tiles].size());
        double largest_m = 0;
        for (std::size_t i = 0; i < texels[tiles].size(); i += 2) {
            const float *here = &texels[tiles][i], *there = &texels[from][i];
            EXPECT_LE(std::abs(here[0] - there[0]), maps[tiles].error_m + maps[from].error_m);
            EXPECT_LE(std::abs(here[1] - there[1]),
                      maps[tiles].displacement_error_m + maps[from].displacement_error_m);
            largest_m = std::max<double>(largest_m, std::abs(there[0]));
        }
        EXPECT_GT(largest_m, 0.3) << "a cascade of a gale";
    }
    EXPECT_GT(maps[SEAWAY_FROM_SPECTRUM].error_m, maps[SEAWAY_FROM_PARAMETERS].error_m)
        << "with what the spectrum left out";
}

// The gale's cascades end at bands; a ship of 60 m feels some of them.
TEST_F(RungsAgree, waves_that_are_too_short_are_left_out_alike_by_all_sources) {
    const std::vector<seaway_point> asked = points(400);
    seaway_looking looking = SEAWAY_SIZED(seaway_looking);
    looking.min_wavelength_m = 60;
    std::map<std::uint32_t, std::vector<seaway_water>> water;
    double left_out_m2 = 0;
    for (const auto& [from, sea] : seas) {
        if (from == SEAWAY_FROM_SERVER)
            continue;
        water[from].resize(asked.size());
        ASSERT_EQ(seaway_sample_water(sea->handle(), &looking, asked.data(), asked.size(),
                                      water[from].data(), sizeof(seaway_water)),
                  SEAWAY_OK)
            << seaway_last_error();
    }
    const std::vector<seaway_answer> whole = seas[SEAWAY_FROM_TILES]->sample(asked);
    const std::vector<seaway_water>& tiles = water[SEAWAY_FROM_TILES];
    for (const auto& [from, other] : water)
        for (std::size_t i = 0; i < asked.size(); ++i) {
            if (open_at(tiles[i].answer, other[i].answer))
                continue;
            EXPECT_LE(std::abs(tiles[i].answer.height_m - other[i].answer.height_m),
                      tiles[i].answer.error_m + other[i].answer.error_m);
            for (int axis = 0; axis < 2; ++axis)
                EXPECT_LE(std::abs(tiles[i].displacement_m[axis] - other[i].displacement_m[axis]),
                          tiles[i].displacement_error_m + other[i].displacement_error_m);
            if (from == SEAWAY_FROM_TILES)
                left_out_m2 += std::pow(tiles[i].answer.height_m - whole[i].height_m, 2);
        }
    for (const int exact : {0, 1}) {
        const std::size_t count = exact ? 50 : asked.size();
        std::vector<seaway_answer> served(count);
        ASSERT_EQ(seaway_query_some(seas[SEAWAY_FROM_SERVER]->handle(), &looking, asked.data(),
                                    count, exact, 300, served.data()),
                  SEAWAY_OK)
            << seaway_last_error();
        for (std::size_t i = 0; i < count; ++i)
            if (!open_at(tiles[i].answer, served[i])) {
                EXPECT_LE(std::abs(tiles[i].answer.height_m - served[i].height_m),
                          tiles[i].answer.error_m + served[i].error_m);
            }
    }
    // Waves below the second band's 30 m or so are some tenths of a metre of a gale.
    EXPECT_GT(left_out_m2 / static_cast<double>(asked.size()), 0.05 * 0.05)
        << "nothing was left out";
}

// The spectrum's waves are off by some mm; velocities by that times their frequencies, pressures times g. Probes and floats leave
// 1e-6 of what was rebuilt from parameters. The exact ones know the same waves: of a 10 m/s sea 1e-5.
TEST_F(RungsAgree, the_water_below_is_the_same_from_the_server_the_spectrum_and_the_parameters) {
    std::vector<seaway_point> asked = points(60);
    std::vector<double> z_m;
    for (std::size_t i = 0; i < asked.size(); ++i)
        z_m.push_back(-0.5 * static_cast<double>(i) + 3);
    std::map<std::uint32_t, std::vector<seaway_below>> below;
    for (const auto& [from, sea] : seas) {
        std::vector<seaway_below>& found = below[from];
        found.resize(asked.size());
        if (from == SEAWAY_FROM_TILES) {
            EXPECT_EQ(seaway_sample_below(sea->handle(), nullptr, asked.data(), z_m.data(),
                                          asked.size(), found.data(), sizeof(seaway_below)),
                      SEAWAY_NOT_HELD)
                << "maps know of the surface alone";
            continue;
        }
        const seaway_code code =
            from == SEAWAY_FROM_SERVER
                ? seaway_query_below(sea->handle(), nullptr, asked.data(), z_m.data(), asked.size(),
                                     300, found.data(), sizeof(seaway_below))
                : seaway_sample_below(sea->handle(), nullptr, asked.data(), z_m.data(),
                                      asked.size(), found.data(), sizeof(seaway_below));
        ASSERT_EQ(code, SEAWAY_OK) << seaway_last_error();
    }
    int wet = 0;
    for (const auto& [from, found] : below) {
        if (from == SEAWAY_FROM_TILES)
            continue;
        const bool coarse = from == SEAWAY_FROM_SPECTRUM;
        for (std::size_t i = 0; i < asked.size(); ++i) {
            const seaway_below& one = found[i];
            const seaway_below& other = below[SEAWAY_FROM_SERVER][i];
            // A crest may end between the depth and what two sources make of the surface.
            const double apart_m = one.surface.height_m - z_m[i];
            if (open_at(one.surface, other.surface) || std::abs(apart_m) < 0.05)
                continue;
            EXPECT_EQ(one.surface.flags & SEAWAY_DRY, other.surface.flags & SEAWAY_DRY);
            wet += (one.surface.flags & SEAWAY_DRY) == 0;
            const double near_mps = coarse ? 0.05 : 1e-4;
            for (int axis = 0; axis < 3; ++axis)
                EXPECT_NEAR(one.velocity_mps[axis], other.velocity_mps[axis], near_mps)
                    << from << " at " << z_m[i];
            EXPECT_NEAR(one.pressure_m2ps2, other.pressure_m2ps2, coarse ? 0.2 : 1e-3);
        }
    }
    EXPECT_GT(wet, 3 * 45) << "most of these are below water";
}

// A hull on the longest waves, on a thin line: what it leaves out is not sent, and what it cannot have it is told.
TEST_F(RungsAgree,
       who_subscribes_to_the_longest_waves_in_small_maps_samples_those_and_is_told_why) {
    Sea& sea = *seas[SEAWAY_FROM_SERVER];
    seaway_wish wish = SEAWAY_SIZED(seaway_wish);
    seaway_grant grant = SEAWAY_SIZED(seaway_grant);
    seaway_looking looking = SEAWAY_SIZED(seaway_looking);
    wish.fields = SEAWAY_SURFACE_FIELDS | SEAWAY_BIT(SEAWAY_FOAM);
    wish.cascades = looking.cascades = 1;
    wish.error_m = 1e-4; // finer than any map of 64 points
    wish.timeout_s = 300;
    std::uniform_real_distribution<double> place(-1e4, 1e4);
    for (const bool small : {false, true}) {
        wish.size_max = small ? 64 : 0;
        ASSERT_EQ(seaway_subscribe_to(sea.handle(), &wish, &grant), SEAWAY_OK)
            << seaway_last_error();
        EXPECT_EQ(grant.cascades, 1u);
        EXPECT_EQ(grant.size_max, wish.size_max);
        EXPECT_EQ((grant.fields & SEAWAY_BIT(SEAWAY_FOAM)) == 0, small) << "no sum of waves";
        EXPECT_EQ(std::string(grant.why).find("foam") != std::string::npos, small) << grant.why;

        const std::int64_t now_us = sea.now_us();
        std::vector<seaway_point> asked;
        for (int i = 0; i < 200; ++i)
            asked.push_back({place(random), place(random), now_us});
        std::map<Sea*, std::vector<seaway_water>> water;
        for (Sea* at : {&sea, seas[SEAWAY_FROM_PARAMETERS].get()}) {
            water[at].resize(asked.size());
            ASSERT_EQ(seaway_sample_water(at->handle(), &looking, asked.data(), asked.size(),
                                          water[at].data(), sizeof(seaway_water)),
                      SEAWAY_OK)
                << seaway_last_error();
        }
        for (std::size_t i = 0; i < asked.size(); ++i) {
            const seaway_water& thin = water[&sea][i];
            const seaway_answer& whole = water[seas[SEAWAY_FROM_PARAMETERS].get()][i].answer;
            if (thin.answer.flags & SEAWAY_EXTRAPOLATED)
                continue; // a machine so busy that the stream is behind
            EXPECT_LE(std::abs(thin.answer.height_m - whole.height_m),
                      thin.answer.error_m + whole.error_m);
            if (!small) {
                EXPECT_TRUE(thin.foam >= 0 && thin.foam <= 1) << thin.foam;
            }
        }
    }
    seaway_answer answer{};
    const seaway_point point{0, 0, sea.now_us()};
    EXPECT_EQ(seaway_sample(sea.handle(), &point, 1, &answer), SEAWAY_NOT_HELD)
        << "of the other cascades nothing came";
    seaway_sampling how = SEAWAY_SIZED(seaway_sampling);
    how.looking = &looking;
    seaway_water water{};
    ASSERT_EQ(seaway_sample_as(sea.handle(), &how, &point, 1, &answer), SEAWAY_OK)
        << "but who leaves them out needs none: " << seaway_last_error();
    ASSERT_EQ(seaway_sample_water(sea.handle(), &looking, &point, 1, &water, sizeof(water)),
              SEAWAY_OK);
    EXPECT_EQ(answer.height_m, water.answer.height_m);
}

} // namespace
} // namespace seaway
