// SPDX-License-Identifier: Apache-2.0
// What seaway_engine.h promises, against the real net server on loopback and a sea whose truth is known.
#include <cmath>
#include <cstring>

#include <gtest/gtest.h>

#include "tests/client/engine.h"

namespace seaway {
namespace {

using tests::Engine;

float value_of_half(std::uint16_t half) {
    const int exponent = half >> 10 & 31;
    const float fraction = static_cast<float>(half & 1023) / 1024.0f;
    const float size =
        exponent == 0 ? std::ldexp(fraction, -14) : std::ldexp(1.0f + fraction, exponent - 15);
    return half & 0x8000 ? -size : size;
}

TEST_F(Engine, a_subscription_gets_the_fields_cascades_and_limits_that_it_names) {
    Sea client(net->url());
    seaway_wish wish = SEAWAY_SIZED(seaway_wish);
    seaway_grant grant = SEAWAY_SIZED(seaway_grant);
    EXPECT_EQ(seaway_get_grant(client.handle(), &grant), SEAWAY_NOT_HELD);
    wish.fields = SEAWAY_SURFACE_FIELDS | SEAWAY_BIT(SEAWAY_SLOPE_X) | SEAWAY_BIT(SEAWAY_FOAM);
    wish.cascades = 1;
    wish.error_m = 0.25;
    wish.credit = 3;
    ASSERT_EQ(seaway_subscribe_to(client.handle(), &wish, &grant), SEAWAY_OK)
        << seaway_last_error();
    EXPECT_EQ(grant.fields, SEAWAY_SURFACE_FIELDS | SEAWAY_BIT(SEAWAY_SLOPE_X))
        << "what the server has not is left out";
    EXPECT_EQ(grant.cascades, 1u);
    EXPECT_EQ(grant.credit, 3u);
    EXPECT_EQ(sea.wished_error_m, 0.25f);
    EXPECT_NEAR(grant.error_m, 0.01, 1e-9) << "as granted, not as asked: a float of it";
    seaway_grant later = SEAWAY_SIZED(seaway_grant);
    ASSERT_EQ(seaway_get_grant(client.handle(), &later), SEAWAY_OK);
    EXPECT_EQ(later.fields, grant.fields);
    EXPECT_EQ(std::string(later.why), grant.why);
}

TEST_F(Engine, what_cannot_be_subscribed_to_is_named_with_its_value_and_range) {
    Sea client(net->url());
    const auto refused = [&](auto change) {
        seaway_wish wish = SEAWAY_SIZED(seaway_wish);
        change(wish);
        return refusal(seaway_subscribe_to(client.handle(), &wish, nullptr));
    };
    EXPECT_NE(refused([](auto& w) { w.fields = 1u << 20; }).find("field 20"), std::string::npos);
    EXPECT_NE(refused([](auto& w) { w.cascades = 5; }).find("cascade 2"), std::string::npos);
    EXPECT_NE(refused([](auto& w) { w.error_m = -1; }).find("error_m is -1"), std::string::npos);
    EXPECT_NE(refused([](auto& w) { w.size_max = 31; }).find("32 to 2048"), std::string::npos);
    EXPECT_NE(refused([](auto& w) { w.rate_hz_max = 0.5; }).find("rate_hz_max is 0.5"),
              std::string::npos);
    EXPECT_NE(refused([](auto& w) { w.credit = 9; }).find("credit is 9"), std::string::npos);
    EXPECT_NE(refused([](auto& w) { w.reserved = 1; }).find("reserved is 1"), std::string::npos);
    EXPECT_EQ(sea.fetches, 0) << "nothing was asked of the server";
}

TEST_F(Engine, a_program_of_another_header_is_understood_or_told) {
    Sea client(net->url());
    struct Newer {
        seaway_wish known;
        std::uint64_t unknown;
    } newer{};
    newer.known.size = sizeof(newer);
    EXPECT_EQ(seaway_subscribe_to(client.handle(), &newer.known, nullptr), SEAWAY_OK)
        << "what it does not use it need not know";
    newer.unknown = 1;
    EXPECT_NE(refusal(seaway_subscribe_to(client.handle(), &newer.known, nullptr)).find("byte 48"),
              std::string::npos);

    // An older one: of its structs the end is missing, and what lies behind them is not theirs.
    seaway_wish wish = SEAWAY_SIZED(seaway_wish);
    wish.size = offsetof(seaway_wish, error_m);
    wish.error_m = -1;
    seaway_grant grant{};
    std::memset(&grant, 0x5a, sizeof(grant));
    grant.size = offsetof(seaway_grant, rate_hz_max);
    ASSERT_EQ(seaway_subscribe_to(client.handle(), &wish, &grant), SEAWAY_OK)
        << seaway_last_error();
    EXPECT_EQ(grant.size, offsetof(seaway_grant, rate_hz_max));
    EXPECT_EQ(grant.fields, SEAWAY_SURFACE_FIELDS);
    EXPECT_EQ(grant.credit, 0x5a5a5a5au) << "nothing is written beyond what it has";
    wish.size = 3;
    EXPECT_NE(refusal(seaway_subscribe_to(client.handle(), &wish, nullptr)).find("sizeof"),
              std::string::npos);

    // Answers of a program whose seaway_water ends after the answer.
    client.hold({asked_us});
    std::vector<seaway_answer> two(2);
    std::memset(two.data(), 0x5a, 2 * sizeof(seaway_answer));
    const std::vector<seaway_point> points = places(1);
    ASSERT_EQ(seaway_sample_water(client.handle(), nullptr, points.data(), 1,
                                  reinterpret_cast<seaway_water*>(two.data()),
                                  sizeof(seaway_answer)),
              SEAWAY_OK);
    EXPECT_EQ(two[0].height_m, client.sample(points[0]).height_m);
    EXPECT_EQ(two[1].flags, 0x5a5a5a5au);
}

TEST_F(Engine, a_map_is_the_cascade_at_its_texels_within_the_stated_bounds) {
    Sea client(net->url());
    client.hold({asked_us});
    const sea::DirectSum truth = only(1);
    const sea::DirectSum::Moment moment = truth.at_time(asked_us);
    for (const bool halves : {false, true}) {
        seaway_map_wish wish = map_wish();
        wish.type = halves ? SEAWAY_HALF : SEAWAY_FLOAT;
        const std::size_t texel = 4 * (halves ? 2 : 4), row = tests::wave_map_size * texel;
        wish.row_stride = row + 12;
        std::vector<unsigned char> bytes((tests::wave_map_size - 1) * wish.row_stride + row, 0x5a);
        seaway_map map = SEAWAY_SIZED(seaway_map);
        ASSERT_EQ(seaway_get_map(client.handle(), &wish, bytes.data(), bytes.size(), &map),
                  SEAWAY_OK)
            << seaway_last_error();
        EXPECT_EQ(map.bytes, bytes.size());
        EXPECT_EQ(map.grid, static_cast<std::uint32_t>(tests::wave_map_size));
        EXPECT_EQ(map.length_m, 29);
        EXPECT_EQ(map.time_us, asked_us);
        EXPECT_EQ(map.flags, 0u);
        // A bound that says nothing is none: waves of 7 cm, coded to half a millimetre.
        EXPECT_LT(map.error_m, 0.02);
        for (std::size_t y = 0; y < map.grid; ++y) {
            for (std::size_t x = 0; x < map.grid; ++x) {
                float value[4];
                const unsigned char* at = bytes.data() + y * wish.row_stride + x * texel;
                for (std::size_t c = 0; c < 4; ++c) {
                    std::uint16_t half = 0;
                    std::memcpy(halves ? static_cast<void*>(&half) : &value[c], at + c * texel / 4,
                                texel / 4);
                    if (halves)
                        value[c] = value_of_half(half);
                }
                const sea::LagrangianPoint point =
                    moment.at(static_cast<double>(x) * 29 / 32, static_cast<double>(y) * 29 / 32);
                EXPECT_LE(std::abs(static_cast<double>(value[0]) - point.displacement_x),
                          map.displacement_error_m);
                EXPECT_EQ(value[1], 0);
                EXPECT_LE(std::abs(static_cast<double>(value[2]) - point.height), map.error_m);
                // No bound is stated: strains miss some per cent of 0.06 at ten points a wave.
                EXPECT_NEAR(static_cast<double>(value[3]),
                            sea::jacobian(point, tests::few_waves()->choppiness), 0.01);
            }
            if (y + 1 < map.grid) {
                EXPECT_EQ(bytes[y * wish.row_stride + row], 0x5a) << "between rows is the caller's";
            }
        }
    }
}

TEST_F(Engine, a_map_that_cannot_be_had_says_why_and_writes_nothing) {
    Sea client(net->url());
    seaway_map_wish wish = map_wish();
    seaway_map map = SEAWAY_SIZED(seaway_map);
    std::vector<float> texels(4 * 32 * 32, 7.0f);
    const std::size_t bytes = texels.size() * sizeof(float);
    const auto refused = [&](seaway_code code) {
        return refusal(seaway_get_map(client.handle(), &wish, texels.data(), bytes, &map), code);
    };
    EXPECT_NE(refused(SEAWAY_NOT_HELD).find("cascade 1"), std::string::npos);
    client.hold({asked_us});
    ASSERT_EQ(seaway_get_map(client.handle(), &wish, nullptr, 0, &map), SEAWAY_OK);
    EXPECT_EQ(map.bytes, bytes) << "without memory it says how much it takes";
    EXPECT_NE(refusal(seaway_get_map(client.handle(), &wish, texels.data(), bytes - 1, &map))
                  .find(std::to_string(bytes)),
              std::string::npos);
    wish.field[3] = SEAWAY_FOAM;
    EXPECT_NE(refused(SEAWAY_NOT_HELD).find("foam"), std::string::npos);
    wish = map_wish();
    wish.cascade = 2;
    EXPECT_NE(refused(SEAWAY_BAD_ARGUMENT).find("the sea has 2"), std::string::npos);
    wish = map_wish();
    wish.channels = 5;
    EXPECT_NE(refused(SEAWAY_BAD_ARGUMENT).find("channels is 5"), std::string::npos);
    wish = map_wish();
    wish.row_stride = 511;
    EXPECT_NE(refused(SEAWAY_BAD_ARGUMENT).find("a row has 512 bytes"), std::string::npos);
    EXPECT_EQ(texels, std::vector<float>(texels.size(), 7.0f));
}

TEST_F(Engine, water_at_a_point_was_moved_there_as_the_exact_sum_moves_it) {
    const sea::RealizationPtr waves = tests::few_waves();
    const sea::DirectSum truth(waves);
    const std::vector<seaway_point> points = places(200);
    for (const bool tiles : {true, false}) {
        Sea client(net->url());
        hold_sea(client, tiles);
        const std::vector<seaway_water> water = water_at(client, nullptr, points);
        const std::vector<seaway_answer> answers = client.sample(points);
        for (std::size_t i = 0; i < points.size(); ++i) {
            const sea::DirectSum::Moment moment = truth.at_time(points[i].time_us);
            sea::Vec2 place{};
            (void)sea::surface_at({points[i].x_m, points[i].y_m, points[i].time_us},
                                  {waves->choppiness, 1e-9, sea::FoldSearch{}},
                                  sea::LagrangianField(moment), nullptr, &place);
            EXPECT_EQ(water[i].answer.height_m, answers[i].height_m) << "as seaway_sample";
            const double off_x = water[i].displacement_m[0] - (points[i].x_m - place.x);
            const double off_y = water[i].displacement_m[1] - (points[i].y_m - place.y);
            EXPECT_LE(std::max(std::abs(off_x), std::abs(off_y)), water[i].displacement_error_m);
            EXPECT_LT(water[i].displacement_error_m, 0.1) << "a bound of 1 m says nothing";
            // No bound is stated: a strain of 0.1 misses some per cent at the finest waves.
            EXPECT_NEAR(water[i].jacobian,
                        sea::jacobian(moment.at(place.x, place.y), waves->choppiness), 0.01);
            EXPECT_TRUE(std::isnan(water[i].foam)) << "none was sent";
        }
    }
}

TEST_F(Engine, a_time_at_which_there_is_no_sea_is_refused_by_name_whatever_is_held) {
    seaway_state state = SEAWAY_SIZED(seaway_state);
    for (const bool tiles : {true, false}) {
        Sea client(net->url());
        hold_sea(client, tiles);
        ASSERT_EQ(seaway_get_state(client.handle(), &state), SEAWAY_OK);
        for (const std::int64_t time_us :
             {state.time_max_us + 1, -state.time_max_us - 1, INT64_MAX, INT64_MIN}) {
            const seaway_point points[] = {{0, 0, asked_us}, {0, 0, time_us}};
            const std::string named = "time_us is " + std::to_string(time_us);
            seaway_answer answers[2];
            seaway_water water[2];
            EXPECT_NE(refusal(seaway_sample(client.handle(), points, 2, answers)).find(named),
                      std::string::npos);
            EXPECT_NE(refusal(seaway_sample_water(client.handle(), nullptr, points, 2, water,
                                                  sizeof(seaway_water)))
                          .find(named),
                      std::string::npos);
            EXPECT_NE(refusal(seaway_hold(client.handle(), &time_us, 1, 0)).find(named),
                      std::string::npos);
            seaway_map_wish wish = map_wish();
            seaway_map map = SEAWAY_SIZED(seaway_map);
            wish.time_us = time_us;
            EXPECT_NE(refusal(seaway_get_map(client.handle(), &wish, nullptr, 0, &map)).find(named),
                      std::string::npos);
        }
        for (const std::int64_t time_us : {state.time_max_us, -state.time_max_us}) {
            const seaway_answer far = client.sample({0, 0, time_us});
            EXPECT_TRUE(std::isfinite(far.height_m));
            EXPECT_EQ((far.flags & SEAWAY_EXTRAPOLATED) != 0, tiles);
        }
    }
}

// Naive: at 1e15 m a double has steps of 0.1 m, and no bound knows of them.
TEST_F(Engine, a_place_beyond_those_that_a_server_answers_is_refused_by_name_whatever_is_held) {
    seaway_state state = SEAWAY_SIZED(seaway_state);
    for (const bool tiles : {true, false}) {
        Sea client(net->url());
        hold_sea(client, tiles);
        ASSERT_EQ(seaway_get_state(client.handle(), &state), SEAWAY_OK);
        for (const double beyond_m : {state.place_max_m + 1, -1e15})
            for (const seaway_point& there :
                 {seaway_point{beyond_m, 0, asked_us}, {0, beyond_m, asked_us}}) {
                const seaway_point points[] = {{0, 0, asked_us}, there};
                seaway_answer answers[2];
                seaway_water water[2];
                EXPECT_NE(refusal(seaway_sample(client.handle(), points, 2, answers))
                              .find("must be -1e+09 to 1e+09"),
                          std::string::npos);
                EXPECT_NE(refusal(seaway_sample_water(client.handle(), nullptr, points, 2, water,
                                                      sizeof(seaway_water)))
                              .find("coordinate"),
                          std::string::npos);
            }
        for (const double place_m : {state.place_max_m, -state.place_max_m})
            EXPECT_EQ(client.sample({place_m, place_m, asked_us}).flags, 0u);
    }
}

TEST_F(Engine, heights_alone_are_those_of_the_answers_that_have_velocities) {
    const std::vector<seaway_point> points = places(300);
    for (const bool tiles : {true, false}) {
        Sea client(net->url());
        hold_sea(client, tiles);
        std::vector<seaway_answer> all(points.size()), heights(points.size());
        ASSERT_EQ(
            seaway_sample_as(client.handle(), nullptr, points.data(), points.size(), all.data()),
            SEAWAY_OK)
            << seaway_last_error();
        seaway_sampling how = SEAWAY_SIZED(seaway_sampling);
        how.parts = SEAWAY_HEIGHT_ALONE;
        ASSERT_EQ(
            seaway_sample_as(client.handle(), &how, points.data(), points.size(), heights.data()),
            SEAWAY_OK)
            << seaway_last_error();
        bool moves = false;
        for (std::size_t i = 0; i < points.size(); ++i) {
            EXPECT_EQ(heights[i].height_m, all[i].height_m);
            EXPECT_EQ(heights[i].error_m, all[i].error_m);
            EXPECT_EQ(heights[i].flags, all[i].flags);
            EXPECT_EQ(heights[i].normal[0], all[i].normal[0]);
            EXPECT_EQ(heights[i].velocity_mps[2], 0);
            moves = moves || all[i].velocity_mps[2] != 0;
        }
        EXPECT_TRUE(moves);
    }
}

TEST_F(Engine, a_probe_answers_step_after_step_as_who_remembers_nothing) {
    Sea client(net->url());
    hold_sea(client, true);
    std::vector<seaway_point> hull = places(40);
    seaway_probe* probe = nullptr;
    ASSERT_EQ(seaway_open_probe(hull.size(), &probe), SEAWAY_OK) << seaway_last_error();
    seaway_sampling how = SEAWAY_SIZED(seaway_sampling);
    how.probe = probe;
    for (int step = 0; step < 20; ++step) {
        std::vector<seaway_answer> with(hull.size()), without(hull.size());
        ASSERT_EQ(seaway_sample_as(client.handle(), &how, hull.data(), hull.size(), with.data()),
                  SEAWAY_OK)
            << seaway_last_error();
        ASSERT_EQ(seaway_sample(client.handle(), hull.data(), hull.size(), without.data()),
                  SEAWAY_OK);
        for (std::size_t i = 0; i < hull.size(); ++i) {
            // A fiftieth of the budget of 1 cm along the surface, twice.
            EXPECT_NEAR(with[i].height_m, without[i].height_m, 2 * 0.02 * 0.01);
            EXPECT_EQ(with[i].flags, without[i].flags);
            hull[i].x_m += 0.02;
            hull[i].time_us += 500;
        }
    }
    seaway_close_probe(probe);
    seaway_close_probe(nullptr);
}

TEST_F(Engine, what_is_wrong_with_a_probe_is_named) {
    Sea client(net->url());
    seaway_probe* probe = nullptr;
    EXPECT_NE(refusal(seaway_open_probe(0, &probe)).find("count is 0: it must be 1 to 1000000"),
              std::string::npos);
    EXPECT_NE(refusal(seaway_open_probe(1'000'001, &probe)).find("1000001"), std::string::npos);
    EXPECT_NE(refusal(seaway_open_probe(1, nullptr)).find("probe must not be null"),
              std::string::npos);
    ASSERT_EQ(seaway_open_probe(1, &probe), SEAWAY_OK);
    seaway_sampling how = SEAWAY_SIZED(seaway_sampling);
    how.probe = probe;
    const std::vector<seaway_point> points = places(2);
    seaway_answer answers[2];
    EXPECT_NE(refusal(seaway_sample_as(client.handle(), &how, points.data(), 2, answers))
                  .find("2 points, and a probe for 1"),
              std::string::npos);
    how.parts = 2;
    EXPECT_NE(refusal(seaway_sample_as(client.handle(), &how, points.data(), 1, answers))
                  .find("parts is 2"),
              std::string::npos);
    seaway_close_probe(probe);
}

TEST_F(Engine, waves_that_are_left_out_are_missing_from_heights_and_from_nothing_else) {
    auto longest = std::make_shared<sea::Realization>(*tests::few_waves());
    longest->cascades.resize(1);
    const sea::DirectSum truth(longest);
    const std::vector<seaway_point> points = places(100);
    seaway_looking looking = SEAWAY_SIZED(seaway_looking);
    looking.cascades = 1;
    for (const bool tiles : {true, false}) {
        Sea client(net->url());
        hold_sea(client, tiles);
        const std::vector<seaway_water> water = water_at(client, &looking, points);
        for (std::size_t i = 0; i < points.size(); ++i) {
            const sea::Answer exact = sea::surface_at(
                {points[i].x_m, points[i].y_m, points[i].time_us},
                {longest->choppiness, 1e-9, sea::FoldSearch{}}, truth.at_time(points[i].time_us));
            EXPECT_LE(std::abs(water[i].answer.height_m - exact.height_m), water[i].answer.error_m);
        }
        // Of hulls the same, step after step; all waves asked about in between.
        seaway_sampling how = SEAWAY_SIZED(seaway_sampling);
        how.looking = &looking;
        std::vector<seaway_answer> answers(points.size());
        for (const bool some : {true, false, true}) {
            how.looking = some ? &looking : nullptr;
            ASSERT_EQ(seaway_sample_as(client.handle(), &how, points.data(), points.size(),
                                       answers.data()),
                      SEAWAY_OK)
                << seaway_last_error();
            const std::vector<seaway_answer> all = client.sample(points);
            EXPECT_NE(all[0].height_m, water[0].answer.height_m);
            for (std::size_t i = 0; i < points.size(); ++i)
                EXPECT_EQ(answers[i].height_m, some ? water[i].answer.height_m : all[i].height_m);
        }
    }
    looking.min_wavelength_m = -1;
    Sea client(net->url());
    seaway_sampling how = SEAWAY_SIZED(seaway_sampling);
    how.looking = &looking;
    EXPECT_NE(refusal(seaway_sample_as(client.handle(), &how, points.data(), 0, nullptr))
                  .find("min_wavelength_m is -1"),
              std::string::npos);
    EXPECT_NE(refusal(seaway_sample_water(client.handle(), &looking, points.data(), 0, nullptr,
                                          sizeof(seaway_water)))
                  .find("min_wavelength_m is -1"),
              std::string::npos);
}

// Of waves that are all too short: still water, whatever is held; a place that is none has none.
TEST_F(Engine, who_feels_nothing_lies_on_still_water) {
    seaway_looking looking = SEAWAY_SIZED(seaway_looking);
    looking = {sizeof looking, 2, 1e9}; // not the first cascade, whose waves have no longest
    seaway_sampling how = SEAWAY_SIZED(seaway_sampling);
    how.looking = &looking;
    std::vector<seaway_point> points = places(3);
    points[1].x_m = std::nan("");
    std::vector<seaway_terms> terms(points.size());
    Sea client(net->url());
    for (const int held : {0, 1, 2}) {
        if (held > 0)
            hold_sea(client, held == 1);
        for (const std::uint32_t times : {SEAWAY_STATED_TIMES, SEAWAY_TIMES_OF_NOW}) {
            how.times = times;
            ASSERT_EQ(seaway_sample_terms(client.handle(), &how, points.data(), points.size(),
                                          terms.data(), sizeof(seaway_terms)),
                      SEAWAY_OK)
                << seaway_last_error();
            for (const std::size_t i : {0, 2}) {
                EXPECT_EQ(terms[i].answer.height_m, 0);
                EXPECT_EQ(terms[i].answer.normal[2], 1);
                EXPECT_EQ(terms[i].answer.error_m, 0);
                EXPECT_EQ(terms[i].answer.flags, 0u);
                EXPECT_EQ(terms[i].clock_m, 0);
            }
            EXPECT_TRUE(std::isnan(terms[1].answer.height_m));
            EXPECT_TRUE(terms[1].answer.flags & SEAWAY_INVALID);
        }
    }
}

} // namespace
} // namespace seaway
