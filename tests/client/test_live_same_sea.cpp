// SPDX-License-Identifier: Apache-2.0
// Which sea a client that comes back finds: that of before, another one, or that of a server that lags behind.
#include <atomic>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/client.h"
#include "tests/client/wave_server.h"
#include "tests/support/fault_proxy.h"

namespace seaway::client {
namespace {

using tests::eventually;
using tests::FaultProxy;

class LiveSameSea : public tests::WaveServer {
  protected:
    std::unique_ptr<FaultProxy> line;
    std::string url;

    void SetUp() override {
        WaveServer::SetUp();
        line = std::make_unique<FaultProxy>(net->port());
        url = "ws://127.0.0.1:" + std::to_string(line->port());
    }
};

// As of a journal that was put back: the sea of before would go on at this client, and at nobody else.
TEST_F(LiveSameSea, a_server_that_does_not_know_the_sea_that_should_run_has_another) {
    for (const bool begun : {true, false}) {
        std::atomic<int> told = 0;
        const auto client = Client::connect({.url = url, .timeout_s = 60},
                                            {.on_sea_state = [&](const SeaStatePtr&) { ++told; }});
        ASSERT_TRUE(client) << client.error().message;
        const sea::TimeUs start_us = sea.sea_time_us() + (begun ? -1'000'000 : 3'600'000'000);
        announce(sea.epoch + 2, start_us);
        ASSERT_TRUE(eventually([&] { return told == 2; }));
        line->cut();
        ASSERT_TRUE(eventually([&] { return told == 3; }));
        ASSERT_TRUE(eventually([&] { return (*client)->status().connections == 2; }));
        EXPECT_EQ((*client)->sea_state(start_us + 1'000'000)->epoch,
                  begun ? sea.epoch : sea.epoch + 2);
        EXPECT_EQ((*client)->status().seas, begun ? 2 : 1) << (*client)->status().reason;
    }
}

// Naive: one span of time that was missed is remembered, and a second one makes the first one known.
TEST_F(LiveSameSea, what_was_missed_in_one_outage_is_not_known_after_the_next) {
    const auto client = Client::connect({.url = url, .timeout_s = 60});
    ASSERT_TRUE(client) << client.error().message;
    const sea::TimeUs begin_us = sea.sea_time_us();
    const auto miss_a_change = [&](std::uint32_t epoch, int connections) {
        line->stall(true); // nobody is let back in before the change is there
        line->cut();
        EXPECT_TRUE(eventually([&] { return (*client)->status().state != LinkState::connected; }));
        const sea::TimeUs now_us = sea.sea_time_us();
        sea.told_epoch = epoch;
        sea.told_from_us = now_us + 300'000;
        line->stall(false);
        EXPECT_TRUE(eventually([&] { return (*client)->status().connections == connections; }));
        EXPECT_TRUE(eventually([&] { return (*client)->now_us() > now_us + 600'000; }));
        return now_us + 200'000;
    };
    const sea::TimeUs first_us = miss_a_change(sea.epoch + 1, 2);
    EXPECT_TRUE((*client)->knows_sea_of(begin_us - 500'000));
    EXPECT_FALSE((*client)->knows_sea_of(first_us)) << "it is to be asked for";
    const auto knows_of_now = [&] { return (*client)->knows_sea_of((*client)->now_us()); };
    EXPECT_TRUE(eventually(knows_of_now)); // a busy machine's answers are late
    const sea::TimeUs second_us = miss_a_change(sea.epoch + 2, 3);
    ASSERT_EQ((*client)->status().seas, 1) << (*client)->status().reason;
    EXPECT_FALSE((*client)->knows_sea_of(first_us));
    EXPECT_FALSE((*client)->knows_sea_of(second_us));
    EXPECT_TRUE(eventually(knows_of_now));
}

// What it does not know of cannot have been taken back: its log has not been heard since before.
TEST_F(LiveSameSea, a_server_that_lags_behind_its_log_is_not_taken_for_another) {
    sea.told_from_us = -60'000'000;
    for (const bool lags : {true, false}) {
        sea.told_epoch = sea.epoch + 2;
        sea.unsure_us = 0;
        const auto client = Client::connect({.url = url, .timeout_s = 60});
        ASSERT_TRUE(client) << client.error().message;
        sea.told_epoch = sea.epoch;
        sea.unsure_us = lags ? sea.sea_time_us() + 120'000'000 : 0;
        line->cut();
        ASSERT_TRUE(eventually([&] { return (*client)->status().connections == 2; }));
        EXPECT_EQ((*client)->status().seas, lags ? 1 : 2) << (*client)->status().reason;
        // And once it is sure of what it knows it is another one after all.
        sea.unsure_us = 0;
        EXPECT_TRUE(eventually([&] { return (*client)->status().seas == 2; }));
        EXPECT_EQ((*client)->sea_state(0)->epoch, sea.epoch);
    }
}

// Of a journal that was put back there is time to tell only once it should have begun.
TEST_F(LiveSameSea, what_was_announced_and_does_not_begin_is_forgotten) {
    std::atomic<int> told = 0;
    const auto client = Client::connect({.url = url, .timeout_s = 60},
                                        {.on_sea_state = [&](const SeaStatePtr&) { ++told; }});
    ASSERT_TRUE(client) << client.error().message;
    const sea::TimeUs start_us = sea.sea_time_us() + 3'000'000;
    announce(sea.epoch + 1, start_us);
    ASSERT_TRUE(eventually([&] { return told == 2; }));
    line->cut();
    ASSERT_TRUE(eventually([&] { return told == 3; }));
    EXPECT_TRUE(eventually([&] { return (*client)->status().seas == 2; }));
    EXPECT_GT(sea.sea_time_us(), start_us);
    EXPECT_EQ((*client)->sea_state(start_us + 1)->epoch, sea.epoch);
    EXPECT_THAT((*client)->status().reason, testing::HasSubstr("earlier epoch"));
    announce(sea.epoch + 1, sea.sea_time_us() + 1'000'000); // its number is given anew
    EXPECT_TRUE(eventually(
        [&] { return (*client)->sea_state((*client)->now_us())->epoch == sea.epoch + 1; }));
    EXPECT_EQ((*client)->status().seas, 2);
}

// Naive: the pace that held when it was sure last is not told of any more, and so taken for lost.
TEST_F(LiveSameSea, a_server_in_doubt_tells_of_the_pace_that_holds_now) {
    const auto client = Client::connect({.url = url, .timeout_s = 60});
    ASSERT_TRUE(client) << client.error().message;
    const sea::TimeUs now_us = sea.sea_time_us();
    const auto at_pace = [&](sea::TimeUs ago_us, int permille) {
        net->announce(std::make_shared<const protocol::Bytes>(
            protocol::pace(sea::Pace{now_us - ago_us, now_us - ago_us, permille})));
    };
    at_pace(100'000'000, 999);
    at_pace(5'000'000, sea::pace_unit);
    ASSERT_TRUE(eventually([&] { return (*client)->now_us() > now_us + 10'000; }));
    sea.unsure_us = 50'000'000;
    sea.told_pace = sea::Pace{now_us - 5'000'000, now_us - 5'000'000, sea::pace_unit};
    line->cut();
    ASSERT_TRUE(eventually([&] { return (*client)->status().connections == 2; }));
    EXPECT_EQ((*client)->status().seas, 1) << (*client)->status().reason;
}

// Naive: now never goes back, so who missed a pause, or that the sea slowed down, stands until the sea has come to where it has
// run on: for the whole of the pause.
TEST_F(LiveSameSea, a_pace_that_was_missed_does_not_keep_a_client_in_another_time) {
    for (const int missed_permille : {0, int{sea::pace_unit}}) {
        sea.told_pace = {};
        const auto client = Client::connect({.url = url, .timeout_s = 60});
        ASSERT_TRUE(client) << client.error().message;
        const int connections = (*client)->status().connections;
        const sea::TimeUs from_us = sea.sea_time_us();
        net->announce(std::make_shared<const protocol::Bytes>(
            protocol::pace(sea::Pace{from_us, from_us, sea::pace_permille_max})));
        // Shown ahead of where the sea will be for two seconds.
        ASSERT_TRUE(eventually([&] { return (*client)->now_us() > from_us + 2'500'000; }));
        const sea::Pace pace{from_us + 1, from_us + 10, missed_permille};
        sea.told_pace = pace;
        line->cut();
        ASSERT_TRUE(eventually([&] { return (*client)->status().connections > connections; }));
        EXPECT_TRUE(eventually([&] { return (*client)->status().seas == 2; }));
        const sea::TimeUs before_us = pace.sea_time(sea.sea_time_us());
        const sea::TimeUs now_us = (*client)->now_us();
        const sea::TimeUs after_us = pace.sea_time(sea.sea_time_us());
        const ClockStatus clock = (*client)->clock();
        const auto off_us =
            static_cast<sea::TimeUs>(clock.error_us + std::abs(clock.slew_us)) + 50'000;
        EXPECT_GE(now_us, before_us - off_us) << "of the clocks' errors";
        EXPECT_LE(now_us, after_us + off_us);
    }
}

// A quarter of a second is waited for: time goes on, and what is held counts.
TEST_F(LiveSameSea, a_pace_that_was_heard_of_a_little_late_does_not_put_time_back) {
    const auto client = Client::connect({.url = url, .timeout_s = 60});
    ASSERT_TRUE(client) << client.error().message;
    sea::TimeUs shown_us = (*client)->now_us();
    const sea::TimeUs from_us = sea.sea_time_us() - 500'000;
    net->announce(std::make_shared<const protocol::Bytes>(
        protocol::pace(sea::Pace{from_us, from_us, sea::pace_unit / 2})));
    EXPECT_TRUE(eventually([&] {
        const sea::TimeUs now_us = (*client)->now_us();
        EXPECT_GE(now_us, std::exchange(shown_us, now_us));
        return now_us > from_us + 700'000;
    }));
    EXPECT_EQ((*client)->status().seas, 1);
}

// Naive: its sea stands for ever, while that of everybody else goes on.
TEST_F(LiveSameSea, a_server_that_does_not_know_of_a_pause_has_another_sea) {
    const auto client = Client::connect({.url = url, .timeout_s = 60});
    ASSERT_TRUE(client) << client.error().message;
    const sea::TimeUs now_us = sea.sea_time_us();
    net->announce(
        std::make_shared<const protocol::Bytes>(protocol::pace(sea::Pace{now_us, now_us, 0})));
    const auto stands = [&] {
        const sea::TimeUs before_us = (*client)->now_us();
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        return (*client)->now_us() == before_us;
    };
    ASSERT_TRUE(eventually(stands));
    line->cut();
    EXPECT_TRUE(eventually([&] { return (*client)->status().seas == 2; }));
    EXPECT_THAT((*client)->status().reason, testing::HasSubstr("pace"));
    EXPECT_TRUE(eventually([&] { return !stands(); }));
}

} // namespace
} // namespace seaway::client
