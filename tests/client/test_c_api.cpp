// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "client/seaway.hpp"
#include "server/net/server.h"
#include "tests/client/wave_sea.h"

extern "C" seaway_code one_frame_in_c(const char* url, seaway_answer* water);

namespace seaway {
namespace {

class CInterface : public ::testing::Test {
  protected:
    tests::WaveSea sea_served;
    std::unique_ptr<server::NetServer> net;
    std::string url;

    void SetUp() override {
        server::NetOptions options;
        options.listen = "127.0.0.1:0";
        auto started = server::NetServer::start(options, sea_served);
        ASSERT_TRUE(started) << started.error().message;
        net = std::move(*started);
        url = net->url();
    }
};

TEST_F(CInterface, the_worked_example_of_the_header_works_in_c) {
    seaway_answer water{};
    ASSERT_EQ(one_frame_in_c(url.c_str(), &water), SEAWAY_OK) << seaway_last_error();
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

// While the server looks at its clock at the end of a trip of 60 ms, half of it is mistaken for the way
// back: 30 ms, until shorter trips come. Less than 10 s of them tell nothing of a drift.
TEST_F(CInterface, what_the_clock_has_to_make_up_is_told_apart_from_its_drift) {
    sea_served.late_ms = 60;
    Sea sea(url);
    const std::int64_t shown_us = sea.now_us();
    sea_served.late_ms = 0;
    ASSERT_TRUE(tests::eventually([&] { return sea.clock().slew_us < -10'000; }));
    const seaway_clock_status clock = sea.clock();
    EXPECT_LE(std::abs(clock.drift_ppm), 500);
    EXPECT_GT(clock.round_trip_us, 0);
    EXPECT_GE(clock.error_us, 0.5 * clock.round_trip_us);
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

TEST(CInterfaceAlone, says_the_version_it_was_built_with) {
    EXPECT_EQ(seaway_abi_version(), static_cast<std::uint32_t>(SEAWAY_ABI_VERSION));
}

} // namespace
} // namespace seaway
