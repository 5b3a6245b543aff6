// SPDX-License-Identifier: Apache-2.0
// What seaway_sample_terms says an error is made of, and what the clock does to who asks about now (decision 0062).
#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "sea/basics/deviations.h"
#include "sea/surface/surface.h"
#include "tests/client/engine.h"
#include "tests/support/allocations.h"
#include "tests/support/eventually.h"

namespace seaway {
namespace {

class ErrorTerms : public tests::Engine {
  protected:
    static seaway_sampling times_of(std::uint32_t times) {
        seaway_sampling how = SEAWAY_SIZED(seaway_sampling);
        how.times = times;
        return how;
    }
    static std::vector<seaway_terms> terms_of(const Sea& client, const seaway_sampling* how,
                                              const std::vector<seaway_point>& points) {
        std::vector<seaway_terms> terms(points.size());
        EXPECT_EQ(seaway_sample_terms(client.handle(), how, points.data(), points.size(),
                                      terms.data(), sizeof(seaway_terms)),
                  SEAWAY_OK)
            << seaway_last_error();
        return terms;
    }
    static double sum_m(const seaway_terms& one) {
        return std::sqrt(one.codec_m * one.codec_m + one.time_m * one.time_m +
                         one.space_m * one.space_m) +
               one.inverse_m + one.rounding_m + one.clock_m + one.stale_m;
    }
    double off_m(const seaway_answer& answer, const seaway_point& point, sea::TimeUs time_us) {
        return std::abs(answer.height_m - sea.truth({point.x_m, point.y_m, time_us}).height_m);
    }
};

TEST_F(ErrorTerms, add_up_to_the_error_of_the_answers_that_sampling_gives) {
    const std::vector<seaway_point> points = places(300);
    for (const bool tiles : {true, false}) {
        Sea client(net->url());
        hold_sea(client, tiles);
        const std::vector<seaway_answer> answers = client.sample(points);
        const std::vector<seaway_terms> terms = terms_of(client, nullptr, points);
        for (std::size_t i = 0; i < points.size(); ++i) {
            EXPECT_EQ(terms[i].answer.height_m, answers[i].height_m);
            EXPECT_EQ(terms[i].answer.velocity_mps[0], answers[i].velocity_mps[0]);
            EXPECT_EQ(terms[i].answer.error_m, answers[i].error_m);
            // Sums of the same numbers in another order.
            EXPECT_NEAR(sum_m(terms[i]), answers[i].error_m, 1e-14 * answers[i].error_m);
            EXPECT_GT(terms[i].codec_m, 0);
            // This server does not tell its parts of interpolation; waves have none of it.
            EXPECT_EQ(terms[i].rounding_m >= 0.0004, tiles);
            EXPECT_EQ(terms[i].clock_m, 0);
            EXPECT_EQ(terms[i].stale_m, 0);
        }
    }
}

TEST_F(ErrorTerms, of_coding_are_true_of_the_tiles_that_came) {
    Sea client(net->url());
    hold_sea(client, true);
    std::vector<sea::SplinePair> pairs; // of the maps that the server coded
    for (int c = 0; c < 2; ++c) {
        const std::int64_t n = asked_us / tests::wave_intervals_us[c];
        const auto map = [&](std::int64_t of) {
            return std::make_shared<sea::SplineMap>(
                *sea.keyframe(c, of, sea::surface_fields).keyframe);
        };
        pairs.push_back({map(n), map(n + 1)});
    }
    const sea::Surface whole(pairs, {}, {.reach_m = 5.0}, {}, 1e-6);
    const std::vector<seaway_point> points = places(1000);
    const std::vector<seaway_terms> terms = terms_of(client, nullptr, points);
    double largest = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const double off =
            std::abs(terms[i].answer.height_m -
                     whole.answer({points[i].x_m, points[i].y_m, points[i].time_us}).height_m);
        // Maps of the same waves, a double's and a float's rounding of a metre beside it.
        EXPECT_LE(off, terms[i].codec_m + terms[i].inverse_m + 2e-6);
        largest = std::max(largest, off / terms[i].codec_m);
    }
    EXPECT_GT(largest, 0.25) << "coding does something";
}

// The server looks at its clock 200 ms after the question and answers at once: to the client both ways are of 100 ms.
TEST_F(ErrorTerms, of_the_clock_are_true_where_the_clock_is_off_and_none_of_stated_times) {
    for (const bool tiles : {true, false}) {
        sea.late_ms = 200;
        Sea client(net->url());
        if (!tiles)
            hold_sea(client, false);
        sea.late_ms = 0;
        const auto [truly_us, now_us] = both_times(client);
        ASSERT_GT(std::abs(now_us - truly_us), 5'000) << "the clock is off";
        if (tiles)
            client.hold({now_us - 200'000, now_us, now_us + 200'000});
        std::vector<seaway_point> points = places(500);
        for (seaway_point& point : points)
            point.time_us = now_us;
        const seaway_sampling of_now = times_of(SEAWAY_TIMES_OF_NOW);
        const seaway_sampling stated = times_of(SEAWAY_STATED_TIMES);
        // The clock of the client goes on meanwhile, and what it may be off by with it: the question is asked at once.
        const std::vector<seaway_terms> terms = terms_of(client, &of_now, points);
        const std::vector<seaway_terms> without = terms_of(client, &stated, points);
        std::vector<seaway_answer> answers(points.size());
        ASSERT_EQ(seaway_sample_as(client.handle(), &of_now, points.data(), points.size(),
                                   answers.data()),
                  SEAWAY_OK);
        int beyond = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            EXPECT_LE(off_m(terms[i].answer, points[i], truly_us), terms[i].answer.error_m);
            EXPECT_NEAR(sum_m(terms[i]), terms[i].answer.error_m, 1e-14);
            EXPECT_EQ(terms[i].answer.height_m, without[i].answer.height_m);
            EXPECT_GT(terms[i].clock_m, 0);
            EXPECT_EQ(without[i].clock_m, 0);
            EXPECT_LE(off_m(without[i].answer, points[i], now_us), without[i].answer.error_m)
                << "of its own time it is true";
            EXPECT_GT(answers[i].error_m, without[i].answer.error_m) << "without terms as well";
            beyond += off_m(without[i].answer, points[i], truly_us) > without[i].answer.error_m;
        }
        EXPECT_GT(beyond, 250) << "of now it is not";
    }
}

TEST_F(ErrorTerms, of_the_clock_are_what_the_water_moves_meanwhile) {
    sea.late_ms = 40;
    Sea client(net->url());
    hold_sea(client, false);
    (void)client.now_us();
    const std::vector<seaway_point> points = places(500);
    const seaway_sampling of_now = times_of(SEAWAY_TIMES_OF_NOW);
    const auto off_s_now = [&] {
        const seaway_clock_status clock = client.clock();
        return 1e-6 * (clock.error_us + std::abs(clock.slew_us));
    };
    // The server's answers come meanwhile, and each may leave less of it: a tenth for those between.
    const double before_s = off_s_now();
    const std::vector<seaway_terms> terms = terms_of(client, &of_now, points);
    const double after_s = off_s_now();
    const double off_s = 1.1 * std::max(before_s, after_s);
    ASSERT_GT(off_s, 0.02) << "half of 40 ms";
    double largest = 0;
    for (const seaway_terms& one : terms) {
        // The amplitudes times their frequencies are 1.26 m/s, up and sideways; slopes are 0.16 at most, and water that is
        // squeezed so much passes a place 1 / (1 - 0.16) as steep.
        EXPECT_LT(one.clock_m, 1.26 * (1 + 0.16 / 0.84) * off_s);
        largest = std::max(largest, one.clock_m);
    }
    EXPECT_GT(largest, 0.55 * std::min(before_s, after_s))
        << "the largest wave alone moves by 0.74 m/s";
}

// Waves of 0.8 s, between whose ends there is a crest or more: the ends alone say nothing of it.
TEST(ClockTerms, are_true_of_every_moment_that_a_clock_off_by_a_third_of_a_second_may_mean) {
    tests::WaveSea sea(tests::known_waves(
        {160.0, 8.0}, 20.0, {{0, 2, 1, 0.05, 0.3}, {1, 8, 2, 0.015, 1.0}, {1, 9, -3, 0.01, 4.0}}));
    sea.state_change = [](protocol::SeaStateValues& state) {
        // Of k 6.5 and 7.5 rad/m: what sums of squares of k a and k^2 a, halved, come to.
        state.rms_slope = state.rms_strain = 0.087;
        state.curvature_per_m = sea::bound_sigmas * 0.6;
        state.realised.hs_m = 4 * 0.038;
    };
    sea.late_ms = 700; // to the client both ways are of 350 ms
    const auto net = tests::serve(sea);
    ASSERT_TRUE(net);
    Sea client(net->url());
    seaway_subscription spectrum{};
    spectrum.rung = SEAWAY_SPECTRUM;
    client.subscribe(spectrum);
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> place(-100, 100);
    std::vector<seaway_point> points(100);
    const sea::TimeUs now_us = client.now_us();
    for (seaway_point& point : points)
        point = {place(random), place(random), now_us};
    seaway_sampling of_now = SEAWAY_SIZED(seaway_sampling);
    of_now.times = SEAWAY_TIMES_OF_NOW;
    std::vector<seaway_terms> terms(points.size());
    const double before_us = client.clock().error_us;
    ASSERT_EQ(seaway_sample_terms(client.handle(), &of_now, points.data(), points.size(),
                                  terms.data(), sizeof(seaway_terms)),
              SEAWAY_OK)
        << seaway_last_error();
    // Answers that come meanwhile leave less of it, and without any it grows by 1.5 ms a second.
    const double off_us = 0.99 * std::min(before_us, client.clock().error_us);
    ASSERT_GT(off_us, 250'000);
    int crests = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto off_m = [&](double by_us) {
            return std::abs(
                terms[i].answer.height_m -
                sea.truth({points[i].x_m, points[i].y_m, points[i].time_us + std::llround(by_us)})
                    .height_m);
        };
        double furthest_m = 0;
        for (int moment = -20; moment <= 20; ++moment)
            furthest_m = std::max(furthest_m, off_m(off_us * moment / 20));
        EXPECT_LE(furthest_m, terms[i].answer.error_m);
        crests += furthest_m > 0.005 + std::max(off_m(-off_us), off_m(off_us));
    }
    EXPECT_GT(crests, 10) << "the ends alone do not tell";
}

TEST_F(ErrorTerms, of_who_hears_nothing_say_what_may_have_changed) {
    Sea client(net->url());
    hold_sea(client, false);
    const sea::TimeUs now_us = client.now_us();
    net.reset();
    ASSERT_TRUE(tests::eventually([&] { return client.status().state != SEAWAY_CONNECTED; }));
    const std::vector<seaway_point> points = {{3, 4, now_us + 8'000'000},
                                              {3, 4, now_us - 8'000'000},
                                              {std::nan(""), 4, now_us + 8'000'000}};
    const std::vector<seaway_terms> terms = terms_of(client, nullptr, points);
    EXPECT_TRUE(terms[0].answer.flags & SEAWAY_STALE);
    EXPECT_GT(terms[0].stale_m, 0.1) << "a sea of 2.4 m may be another one by then";
    EXPECT_NEAR(sum_m(terms[0]), terms[0].answer.error_m, 1e-14);
    EXPECT_EQ(terms[1].answer.flags & SEAWAY_STALE, 0u) << "what was is known";
    EXPECT_EQ(terms[1].stale_m, 0);
    EXPECT_EQ(terms[2].answer.flags, static_cast<std::uint32_t>(SEAWAY_INVALID) |
                                         static_cast<std::uint32_t>(SEAWAY_STALE));
    EXPECT_EQ(terms[2].stale_m, 0) << "no point, no error of it";
}

TEST_F(ErrorTerms, are_as_many_as_there_are_points_and_allocate_nothing) {
    Sea client(net->url());
    hold_sea(client, true);
    const seaway_sampling of_now = times_of(SEAWAY_TIMES_OF_NOW);
    EXPECT_TRUE(terms_of(client, nullptr, {}).empty());
    const std::vector<seaway_point> points = places(64);
    std::vector<seaway_terms> terms(points.size() + 1);
    for (int call = 0; call < 3; ++call) {
        terms.back().codec_m = 7;
        const tests::Allocations asked;
        const seaway_code code = seaway_sample_terms(client.handle(), &of_now, points.data(),
                                                     points.size(), terms.data(), sizeof(terms[0]));
        const std::size_t times = asked.count();
        ASSERT_EQ(code, SEAWAY_OK) << seaway_last_error();
        if (call > 0) {
            EXPECT_EQ(times, 0u);
        }
        EXPECT_EQ(terms.back().codec_m, 7) << "nothing is written behind them";
    }
}

// A client that takes the waves for what tiles have not, as the water below, need not sum them up where tiles will do.
TEST_F(ErrorTerms, of_who_has_both_are_of_keyframes_where_these_are_preferred_and_cover_the_time) {
    Sea both(net->url()), tiles(net->url()), waves(net->url());
    hold_sea(both, true);
    hold_sea(both, false);
    hold_sea(tiles, true);
    hold_sea(waves, false);
    std::vector<seaway_point> points = places(60);
    seaway_sampling how = times_of(SEAWAY_STATED_TIMES);
    const auto same = [&](const Sea& other) {
        std::vector<seaway_answer> answers(points.size());
        EXPECT_EQ(
            seaway_sample_as(both.handle(), &how, points.data(), points.size(), answers.data()),
            SEAWAY_OK);
        const std::vector<seaway_answer> expected = other.sample(points);
        for (std::size_t i = 0; i < points.size(); ++i)
            if (answers[i].height_m != expected[i].height_m ||
                answers[i].error_m != expected[i].error_m || answers[i].flags != expected[i].flags)
                return false;
        return true;
    };
    EXPECT_TRUE(same(waves));
    how.from = SEAWAY_TILES_FIRST;
    EXPECT_TRUE(same(tiles));
    how.times = SEAWAY_TIMES_OF_NOW;
    const auto terms = terms_of(both, &how, points);
    EXPECT_GT(terms[0].rounding_m, 0.0004) << "which maps alone have";
    how.times = SEAWAY_STATED_TIMES;
    const std::vector<seaway_point> covered = points;
    for (seaway_point& point : points)
        point.time_us += 3'600'000'000; // of which nothing is held but the waves
    EXPECT_TRUE(same(waves));
    // Whatever stands beside it, and in which order.
    std::vector<seaway_point> mixed{points[0], covered[0], covered[1], points[1], covered[2]};
    std::vector<seaway_answer> answers(mixed.size());
    ASSERT_EQ(seaway_sample_as(both.handle(), &how, mixed.data(), mixed.size(), answers.data()),
              SEAWAY_OK);
    const std::vector<seaway_answer> by_tiles = tiles.sample(covered),
                                     by_waves = waves.sample(points);
    const seaway_answer* expected[] = {&by_waves[0], &by_tiles[0], &by_tiles[1], &by_waves[1],
                                       &by_tiles[2]};
    for (std::size_t i = 0; i < mixed.size(); ++i)
        EXPECT_EQ(answers[i].error_m, expected[i]->error_m) << i;
}

TEST_F(ErrorTerms, are_given_to_programs_of_other_headers_and_refused_by_name) {
    Sea client(net->url());
    hold_sea(client, true);
    const std::vector<seaway_point> points = places(1);
    seaway_terms one{};
    // A program from before there were times: its struct ends with the probe.
    seaway_sampling how = times_of(7);
    how.size = offsetof(seaway_sampling, times);
    EXPECT_EQ(seaway_sample_terms(client.handle(), &how, points.data(), 1, &one, sizeof(one)),
              SEAWAY_OK)
        << seaway_last_error();
    how.size = sizeof(how);
    const auto refused = [&](const char* what, std::size_t stride = sizeof(seaway_terms)) {
        const seaway_code code =
            seaway_sample_terms(client.handle(), &how, points.data(), 1, &one, stride);
        EXPECT_NE(refusal(code).find(what), std::string::npos) << seaway_last_error();
    };
    refused("times is 7: it must be 0 or 1");
    how = times_of(0);
    how.from = 3;
    refused("from is 3: it must be 0 to 2");
    how.from = 0;
    refused("stride is 71: it must be sizeof(seaway_terms)", 71);
    EXPECT_NE(refusal(seaway_sample_terms(client.handle(), &how, points.data(), 1, nullptr, 128))
                  .find("terms must not be null"),
              std::string::npos);
    seaway_answer answer{};
    EXPECT_EQ(seaway_sample_terms(client.handle(), &how, points.data(), 1,
                                  reinterpret_cast<seaway_terms*>(&answer), sizeof(answer)),
              SEAWAY_OK);
    EXPECT_EQ(answer.height_m, client.sample(points[0]).height_m);
}

} // namespace
} // namespace seaway
