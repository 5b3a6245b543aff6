// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstring>
#include <set>
#include <sstream>
#include <tuple>

#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include "client/client.h"
#include "client/seaway.hpp"
#include "client/seaway_engine.h"
#include "server/net/server.h"
#include "tests/client/c_interface.h"
#include "tests/server/net/clients.h"
#include "tests/support/eventually.h"
#include "tests/support/metrics_page.h"

extern "C" seaway_code one_frame_in_c(const char* url, seaway_answer* water);

namespace seaway {
namespace {

TEST_F(CInterface, the_worked_example_of_the_header_works_in_c) {
    seaway_answer water{};
    // A quarter of a second is held: a machine that stands still for longer has it extrapolate, so of a few times once is enough.
    for (int i = 0; i < 5 && (i == 0 || water.flags == SEAWAY_EXTRAPOLATED); ++i) {
        ASSERT_EQ(one_frame_in_c(url.c_str(), &water), SEAWAY_OK) << seaway_last_error();
    }
    EXPECT_EQ(water.flags, 0u);
    EXPECT_GT(water.error_m, 0);
    EXPECT_NEAR(std::hypot(water.normal[0], water.normal[1], water.normal[2]), 1, 1e-6);
}

TEST_F(CInterface, both_ways_to_ask_agree_within_the_bound) {
    Sea sea(url);
    const seaway_point point{12, -40, sea.now_us() + 60'000'000};
    sea.hold({point.time_us});
    const seaway_answer local = sea.sample(point);
    const seaway_answer served = sea.query({point}, true).front();
    EXPECT_EQ(served.flags, static_cast<std::uint32_t>(SEAWAY_EXACT));
    EXPECT_LE(std::abs(local.height_m - served.height_m), local.error_m);
    EXPECT_EQ(sea.at(point.time_us).cascades, 2u);
    EXPECT_TRUE(sea.is_connected());
    EXPECT_GE(sea.clock().round_trip_us, 0);
}

TEST_F(CInterface, with_the_waves_any_time_is_sampled_without_a_question) {
    Sea sea(url);
    seaway_subscription wanted{};
    wanted.error_m = 0.001;
    wanted.rung = SEAWAY_SPECTRUM;
    sea.subscribe(wanted);
    for (const std::int64_t time_us :
         {std::int64_t{-5'000'000'000'001}, std::int64_t{0}, std::int64_t{900'000'000'000'000}}) {
        const seaway_answer own = sea.sample({12, -40, time_us});
        const sea::Answer truth = sea_served.truth({12, -40, time_us});
        EXPECT_LE(std::abs(own.height_m - truth.height_m), own.error_m);
        EXPECT_LE(own.error_m, 0.0015);
    }
    EXPECT_EQ(sea_served.queries, 0);
    wanted.rung = 2;
    EXPECT_EQ(seaway_subscribe(sea.handle(), &wanted), SEAWAY_BAD_ARGUMENT);
    EXPECT_NE(std::string(seaway_last_error()).find("rung"), std::string::npos);
}

// While the server looks at its clock at the end of a trip of 300 ms, half of it is mistaken for the way
// back: 150 ms, however late a busy machine's answer is, until shorter trips come. Less than 10 s of them tell nothing of a drift.
TEST_F(CInterface, what_the_clock_has_to_make_up_is_told_apart_from_its_drift) {
    sea_served.late_ms = 300;
    Sea sea(url);
    const std::int64_t shown_us = sea.now_us();
    sea_served.late_ms = 0;
    ASSERT_TRUE(tests::eventually([&] { return sea.clock().slew_us < -10'000; }));
    const seaway_clock_status clock = sea.clock();
    EXPECT_LE(std::abs(clock.drift_ppm), 500);
    EXPECT_GT(clock.round_trip_us, 0);
    EXPECT_GT(clock.error_us, 0);
    EXPECT_GE(sea.now_us(), shown_us) << "it never runs backwards";
}

TEST_F(CInterface, a_failure_has_a_code_and_a_reason_and_writes_nothing) {
    seaway_client* client = nullptr;
    EXPECT_EQ(seaway_connect("nonsense", nullptr, &client), SEAWAY_BAD_ARGUMENT);
    EXPECT_EQ(client, nullptr);
    EXPECT_NE(std::string(seaway_last_error()).find("ws://"), std::string::npos);

    Sea sea(url);
    EXPECT_STREQ(seaway_last_error(), "");
    const seaway_point point{};
    seaway_answer answer{};
    answer.height_m = 7;
    EXPECT_EQ(seaway_sample(sea.handle(), &point, 1, &answer), SEAWAY_NOT_HELD);
    EXPECT_EQ(answer.height_m, 7);
    EXPECT_EQ(seaway_query(sea.handle(), nullptr, 1, 0, 0, &answer), SEAWAY_BAD_ARGUMENT);
    EXPECT_EQ(seaway_query(sea.handle(), &point, 1, 0, std::nan(""), &answer), SEAWAY_BAD_ARGUMENT);
    const seaway_subscription too_much{0, 9, 0, 0};
    EXPECT_EQ(seaway_subscribe(sea.handle(), &too_much), SEAWAY_BAD_ARGUMENT);
    EXPECT_EQ(seaway_sample(nullptr, &point, 1, &answer), SEAWAY_BAD_ARGUMENT);
    seaway_disconnect(nullptr);
    net->stop();
    EXPECT_TRUE(tests::eventually([&] { return !sea.is_connected(); }));
    EXPECT_EQ(seaway_query(sea.handle(), &point, 1, 0, 0, &answer), SEAWAY_LOST);
    try {
        sea.subscribe();
        FAIL() << "a lost connection must throw";
    } catch (const SeaError& error) {
        EXPECT_EQ(error.code(), SEAWAY_LOST);
    }
}

TEST_F(CInterface, the_name_that_is_given_stands_in_the_log_of_the_server) {
    std::ostringstream text;
    const auto before = spdlog::default_logger();
    spdlog::set_default_logger(std::make_shared<spdlog::logger>(
        "test", std::make_shared<spdlog::sinks::ostream_sink_mt>(text)));
    {
        Sea named(url, {"a buoy", nullptr, nullptr, 0});
        Sea unnamed(url);
    }
    net->stop();
    spdlog::set_default_logger(before);
    EXPECT_NE(text.str().find("client=\"a buoy\""), std::string::npos) << text.str();
    EXPECT_NE(text.str().find("client=\"seaway-client/"), std::string::npos) << text.str();
}

/// Connects as the C++ client does, to hold one against the other.
std::unique_ptr<client::Client> cpp_client(const std::string& url) {
    auto connected = client::Client::connect({.url = url, .timeout_s = 60});
    EXPECT_TRUE(connected) << (connected ? "" : connected.error().message);
    return connected ? std::move(*connected) : nullptr;
}

void expect_same_answer(const seaway_answer& c, const sea::Answer& cpp) {
    EXPECT_EQ(c.height_m, cpp.height_m);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        EXPECT_EQ(c.normal[axis], cpp.normal[axis]) << axis;
        EXPECT_EQ(c.velocity_mps[axis], cpp.velocity_mps[axis]) << axis;
    }
    EXPECT_EQ(c.error_m, cpp.error_m);
    EXPECT_EQ(c.flags, cpp.flags);
    EXPECT_EQ(c.reserved, 0u);
}

TEST_F(CInterface, every_member_is_that_of_the_cpp_client) {
    Sea sea(url);
    const auto cpp = cpp_client(url);
    ASSERT_TRUE(cpp);
    const seaway_sea at = sea.at(5);
    const client::SeaStatePtr state = cpp->sea_state(5);
    EXPECT_EQ(at.start_time_us, state->start_time_us);
    EXPECT_EQ(at.hs_m, state->realised.hs_m);
    EXPECT_EQ(at.tp_s, state->realised.tp_s);
    EXPECT_EQ(at.tz_s, state->realised.tz_s);
    EXPECT_EQ(at.mean_from_deg, state->realised.mean_from_deg);
    EXPECT_EQ(at.height_error_m, state->height_error_m);
    EXPECT_EQ(at.epoch, state->epoch);
    EXPECT_EQ(at.cascades, state->cascades.size());
    const std::set<double> figures{static_cast<double>(at.start_time_us),
                                   at.hs_m,
                                   at.tp_s,
                                   at.tz_s,
                                   at.mean_from_deg,
                                   at.height_error_m,
                                   1.0 * at.epoch,
                                   1.0 * at.cascades};
    EXPECT_EQ(figures.size(), 8u) << "else they could be mixed up unseen";

    const seaway_point points[] = {{12, -40, 7'250'000}, {-3.5, 90, 7'250'000}, {60, 1, -90'000}};
    const sea::QueryPoint same[] = {{12, -40, 7'250'000}, {-3.5, 90, 7'250'000}, {60, 1, -90'000}};
    seaway_answer answers[3];
    for (const bool exact : {false, true}) {
        std::memset(answers, 0xff, sizeof answers);
        ASSERT_EQ(seaway_query(sea.handle(), points, 3, exact, 0, answers), SEAWAY_OK);
        const auto asked = cpp->ask(same, {.exact = exact});
        ASSERT_TRUE(asked);
        for (std::size_t i = 0; i < 3; ++i)
            expect_same_answer(answers[i], (*asked)[i]);
        EXPECT_EQ(answers[0].flags, exact ? 16u : 0u);
    }
    const std::int64_t times_us[] = {7'250'000, -90'000};
    ASSERT_EQ(seaway_hold(sea.handle(), times_us, 2, 0), SEAWAY_OK);
    ASSERT_TRUE(cpp->hold(times_us, 60));
    std::memset(answers, 0xff, sizeof answers);
    ASSERT_EQ(seaway_sample(sea.handle(), points, 3, answers), SEAWAY_OK);
    const auto sampled = cpp->sample(same);
    ASSERT_TRUE(sampled);
    for (std::size_t i = 0; i < 3; ++i)
        expect_same_answer(answers[i], (*sampled)[i]);
}

// Each argument at its limits, which pass, and beyond them, which is said by name; nothing is asked then.
TEST_F(CInterface, every_argument_is_taken_up_to_its_limit_and_refused_by_name_beyond_it) {
    Sea sea(url);
    const seaway_point point{1, 2, 3};
    const std::int64_t time_us = 3;
    seaway_answer answer{};
    const auto expect = [](seaway_code code, bool fine, const std::string& names) {
        EXPECT_EQ(code, fine ? SEAWAY_OK : SEAWAY_BAD_ARGUMENT) << names << seaway_last_error();
        const std::string said = seaway_last_error();
        EXPECT_EQ(said.find(names) != std::string::npos, !fine) << said;
    };
    for (const auto& [timeout_s, fine] :
         {std::pair(86400.0, true), {86400.5, false}, {-0.5, false}, {std::nan(""), false}}) {
        expect(seaway_query(sea.handle(), &point, 1, 0, timeout_s, &answer), fine,
               "seaway_query: timeout_s");
        expect(seaway_hold(sea.handle(), &time_us, 1, timeout_s), fine, "seaway_hold: timeout_s");
        const seaway_subscription patient{0, 0, 0, timeout_s};
        expect(seaway_subscribe(sea.handle(), &patient), fine,
               fmt::format("subscription.timeout_s is {}: it must be 0 to 86400", timeout_s));
        const seaway_connect_options options{"c", nullptr, nullptr, timeout_s};
        seaway_client* other = nullptr;
        expect(seaway_connect(url.c_str(), &options, &other), fine, "options.timeout_s is");
        EXPECT_EQ(other != nullptr, fine);
        seaway_disconnect(other);
    }
    for (const auto& [error_m, credit, names] :
         {std::tuple(0.0, 1u, ""),
          {1e6, 8u, ""},
          {0.25, 9u, "seaway_subscription.credit is 9: it must be 0 to 8"},
          {1.0001e6, 2u, "error_m"},
          {-0.1, 2u, "error_m"},
          {std::nan(""), 2u, "error_m"}}) {
        sea_served.wished_error_m = -1;
        const seaway_subscription wanted{error_m, credit, 0, 0};
        const bool fine = *names == '\0';
        expect(seaway_subscribe(sea.handle(), &wanted), fine, fine ? "seaway" : names);
        EXPECT_EQ(sea_served.wished_error_m, fine ? static_cast<float>(error_m) : -1.0f);
    }
    seaway_clock_status clock{};
    seaway_sea at{};
    seaway_client* other = nullptr;
    expect(seaway_connect(nullptr, nullptr, &other), false, "seaway_connect: url and client");
    expect(seaway_connect(url.c_str(), nullptr, nullptr), false, "seaway_connect: url and client");
    expect(seaway_clock(nullptr, &clock), false, "seaway_clock:");
    expect(seaway_clock(sea.handle(), nullptr), false, "seaway_clock:");
    expect(seaway_sea_at(nullptr, 0, &at), false, "seaway_sea_at:");
    expect(seaway_sea_at(sea.handle(), 0, nullptr), false, "seaway_sea_at:");
    expect(seaway_query(nullptr, &point, 1, 0, 0, &answer), false, "seaway_query:");
    expect(seaway_query(sea.handle(), &point, 1, 0, 0, nullptr), false, "seaway_query:");
    expect(seaway_query(sea.handle(), nullptr, 0, 0, 0, nullptr), true, "seaway_query:");
    expect(seaway_subscribe(nullptr, nullptr), false, "seaway_subscribe:");
    expect(seaway_unsubscribe(nullptr), false, "seaway_unsubscribe:");
    expect(seaway_hold(nullptr, &time_us, 1, 0), false, "seaway_hold:");
    expect(seaway_hold(sea.handle(), nullptr, 1, 0), false, "seaway_hold:");
    expect(seaway_hold(sea.handle(), nullptr, 0, 0), true, "seaway_hold:");
    expect(seaway_sample(sea.handle(), nullptr, 1, &answer), false, "seaway_sample:");
    expect(seaway_sample(sea.handle(), &point, 1, nullptr), false, "seaway_sample:");
    expect(seaway_sample(sea.handle(), nullptr, 0, nullptr), true, "seaway_sample:");
    EXPECT_EQ(seaway_is_connected(nullptr), 0);
    EXPECT_EQ(seaway_now_us(nullptr), 0);
}

TEST_F(CInterface, a_name_and_a_token_are_as_long_as_a_server_takes) {
    for (const std::size_t bytes : {1024u, 1025u})
        for (const bool token : {false, true}) {
            const std::string text(bytes, 'x');
            seaway_connect_options options{};
            (token ? options.token : options.name) = text.c_str();
            seaway_client* client = nullptr;
            EXPECT_EQ(seaway_connect(url.c_str(), &options, &client),
                      bytes == 1024 ? SEAWAY_OK : SEAWAY_BAD_ARGUMENT);
            if (bytes > 1024) {
                EXPECT_NE(std::string(seaway_last_error()).find("has 1025 bytes: it may have 1024"),
                          std::string::npos);
            }
            seaway_disconnect(client);
        }
}

// Naive: of what is filled in the size need not be sensible.
TEST_F(CInterface, a_struct_to_fill_in_whose_size_was_not_set_is_refused) {
    Sea sea(url);
    seaway_state state{};
    for (const uint32_t size : {3u, 4097u, 0xffffffffu}) {
        state.size = size;
        EXPECT_EQ(seaway_get_state(sea.handle(), &state), SEAWAY_BAD_ARGUMENT) << size;
        EXPECT_NE(std::string(seaway_last_error()).find("sizeof"), std::string::npos);
        seaway_status status{};
        status.size = size;
        EXPECT_EQ(seaway_get_status(sea.handle(), &status), SEAWAY_BAD_ARGUMENT) << size;
        EXPECT_NE(std::string(seaway_last_error()).find("sizeof"), std::string::npos);
    }
}

// 0 stands for ten seconds: a server that takes a look or two at the deadlines is no failure. It is late for
// pings too, of which ten come a second.
TEST_F(CInterface, a_timeout_of_zero_is_the_default_for_every_question) {
    seaway_client* client = nullptr;
    ASSERT_EQ(seaway_connect(url.c_str(), nullptr, &client), SEAWAY_OK);
    sea_served.late_ms = 90;
    const seaway_point point{1, 2, 5'010'000};
    seaway_answer answer{};
    EXPECT_EQ(seaway_query(client, &point, 1, 0, 0, &answer), SEAWAY_OK) << seaway_last_error();
    EXPECT_EQ(seaway_hold(client, &point.time_us, 1, 0), SEAWAY_OK) << seaway_last_error();
    const seaway_subscription wanted{};
    EXPECT_EQ(seaway_subscribe(client, &wanted), SEAWAY_OK) << seaway_last_error();
    sea_served.late_ms = 0;
    seaway_disconnect(client);
}

// Naive: as a float it is 0, which is the server's choice.
TEST_F(CInterface, a_bound_that_no_float_is_as_small_as_is_wished_for_as_the_smallest) {
    Sea sea(url);
    const seaway_subscription wanted{1e-60, 2, 0, 0};
    ASSERT_EQ(seaway_subscribe(sea.handle(), &wanted), SEAWAY_OK);
    EXPECT_EQ(sea_served.wished_error_m, std::numeric_limits<float>::min());
}

TEST_F(CInterface, limits_of_a_stream_are_taken_up_to_their_own_and_refused_by_name_beyond_them) {
    Sea sea(url);
    for (const auto& [rate_hz, size, fine] : {std::tuple(1.0, 32u, true),
                                              {1000.0, 2048u, true},
                                              {0.5, 0u, false},
                                              {std::nan(""), 0u, false},
                                              {1001.0, 0u, false},
                                              {0.0, 31u, false},
                                              {0.0, 2049u, false}}) {
        const seaway_subscription wanted{0, 0, 0, 0, rate_hz, size, 0};
        const seaway_code code = seaway_subscribe(sea.handle(), &wanted);
        EXPECT_EQ(code, fine ? SEAWAY_OK : SEAWAY_BAD_ARGUMENT) << rate_hz << ' ' << size;
        const std::string said =
            fine        ? ""
            : size == 0 ? fmt::format("rate_hz_max is {}: it must be 0 or 1 to 1000", rate_hz)
                        : fmt::format("size_max is {}: it must be 0 or 32 to 2048", size);
        EXPECT_NE(std::string(seaway_last_error()).find(said), std::string::npos);
    }
    for (const uint32_t rung : {SEAWAY_TILES, SEAWAY_SPECTRUM}) {
        const seaway_subscription wanted{0, 0, rung, 0, 0, 0, 7};
        EXPECT_EQ(seaway_subscribe(sea.handle(), &wanted), SEAWAY_BAD_ARGUMENT);
        EXPECT_NE(std::string(seaway_last_error()).find("reserved is 7"), std::string::npos);
    }
}

// Who lets eight keyframes be under way never makes one of the first eight wait; where the server knew of
// the default's two only, most would.
TEST_F(CInterface, as_many_keyframes_are_under_way_as_credit_says) {
    const auto count = [&](const std::string& name) {
        return tests::figure_of(tests::ask_http(net->port(), "/metrics", "GET").body,
                                "seaway_net_keyframes_" + name + "_total");
    };
    const auto settled = [&] { return count("sent") + count("replaced") + count("dropped"); };
    for (int trial = 0; trial < 10; ++trial) {
        Sea sea(url);
        const seaway_subscription wanted{0, 8, 0, 0};
        ASSERT_EQ(seaway_subscribe(sea.handle(), &wanted), SEAWAY_OK) << seaway_last_error();
        const double before = settled();
        for (std::int64_t n = 0; n < 8; ++n)
            net->publish(sea_served.keyframe(1, 1000 + n, seaway::sea::surface_fields));
        ASSERT_TRUE(tests::eventually([&] { return settled() >= before + 8; }));
    }
    EXPECT_GT(count("sent"), 10);
    EXPECT_EQ(count("awaiting_credit"), 0);
}

TEST(CInterfaceAlone, says_the_version_it_was_built_with) {
    EXPECT_EQ(seaway_abi_version(), static_cast<std::uint32_t>(SEAWAY_ABI_VERSION));
}

} // namespace
} // namespace seaway
