// SPDX-License-Identifier: Apache-2.0
// What the watchdog hears of a server that stands still, and what its log says.
#include <chrono>

#include <gtest/gtest.h>

#include "server/progress.h"
#include "server/world.h"
#include "tests/server/net/net_fixture.h"

namespace seaway::server {
namespace {

using std::chrono::milliseconds;

TEST(Progress, the_watchdog_hears_of_it_while_both_the_sea_and_its_sockets_come_on) {
    const tests::LogCapture log;
    const Health fine, stuck = health_of(true, stuck_after);
    Progress progress;
    EXPECT_TRUE(progress.comes_on(fine, milliseconds(0)));
    EXPECT_TRUE(progress.comes_on(fine, stuck_after - milliseconds(1)));
    EXPECT_FALSE(progress.comes_on(fine, stuck_after));
    EXPECT_TRUE(progress.comes_on(fine, milliseconds(0)));
    EXPECT_FALSE(progress.comes_on(stuck, milliseconds(0)));
    EXPECT_FALSE(progress.comes_on(health_of(false, milliseconds(0)), milliseconds(0)));
    EXPECT_TRUE(progress.comes_on({.live = true, .why = "not sure of its log", .ready = false},
                                  milliseconds(0)))
        << "not ready is not stuck";
}

TEST(Progress, the_log_says_once_that_a_server_stands_still_and_once_that_it_goes_on) {
    const tests::LogCapture log;
    Progress progress;
    for (int second = 31; second < 60; ++second)
        EXPECT_FALSE(
            progress.comes_on(health_of(true, std::chrono::seconds(second)), milliseconds(0)));
    EXPECT_EQ(log.lines_with("event=stuck", "the simulation has not come on for 31 s").size(), 1u);
    EXPECT_EQ(log.lines_with("event=").size(), 1u);
    for (int second = 0; second < 3; ++second)
        EXPECT_TRUE(progress.comes_on({}, milliseconds(0)));
    EXPECT_EQ(log.lines_with("event=comes_on_again").size(), 1u);
    EXPECT_EQ(log.lines_with("event=").size(), 2u);
    EXPECT_FALSE(progress.comes_on({}, std::chrono::seconds(33)));
    EXPECT_EQ(log.lines_with("event=stuck", "the sockets have not come on for 33 s").size(), 1u);
}

} // namespace
} // namespace seaway::server
