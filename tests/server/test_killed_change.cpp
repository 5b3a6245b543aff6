// SPDX-License-Identifier: Apache-2.0
// A server that is killed while it changes its sea.
#include <chrono>
#include <cmath>
#include <random>
#include <thread>

#include <gtest/gtest.h>

#include "client/client.h"
#include "tests/server/change_bench.h"

namespace seaway::changes {
namespace {

// Naive: between the journal and the answer lies a change of which nobody knows whether it is. It is there whole or not at all,
// and whoever was answered has it.
TEST(Changes, of_one_that_is_under_way_a_kill_leaves_all_or_nothing) {
    const std::vector<std::string> set{"set", "systems.0.wind_speed_10m_mps=14", "--over", "10s"};
    const sea::QueryPoint behind_all{3, 4, 1'000'000'000'000};
    const auto height_m = [&](client::Client& client) {
        const auto asked = client.ask({&behind_all, 1}, {.exact = true, .timeout_s = 60});
        EXPECT_TRUE(asked) << (asked ? "" : asked.error().message);
        return asked ? asked->front().height_m : std::nan("");
    };
    // One that is let live tells what there may be, and how soon.
    double old_m = 0, new_m = 0;
    std::chrono::steady_clock::duration takes{}; ///< a change, its program's start and end included
    {
        tests::ServerProcess server(arguments(tests::folder().fresh("lives")));
        const std::string url = server.wait_until_ready();
        const auto client = connect(url);
        ASSERT_TRUE(client) << server.log();
        old_m = height_m(*client);
        const auto begun = std::chrono::steady_clock::now();
        const Said said = ctl(url, set);
        takes = std::chrono::steady_clock::now() - begun;
        ASSERT_EQ(said.code, 0) << said.words;
        new_m = height_m(*client);
        ASSERT_NE(old_m, new_m);
    }
    std::mt19937 random(7);
    for (int round = 0; round < 12; ++round) {
        const std::string folder = tests::folder().fresh("killed_on_the_way");
        Said said{-1, ""};
        {
            tests::ServerProcess server(arguments(folder));
            const std::string url = server.wait_until_ready();
            std::thread changing([&] { said = ctl(url, set); });
            std::this_thread::sleep_for(takes * (random() % 120) /
                                        100); // before, within and a little after
            server.send(SIGKILL);
            EXPECT_TRUE(server.wait_for_exit(std::chrono::seconds(10)));
            changing.join();
        }
        tests::ServerProcess server(arguments(folder));
        const auto client = connect(server.wait_until_ready());
        ASSERT_TRUE(client) << server.log();
        const double m = height_m(*client);
        if (said.code == 0) {
            EXPECT_EQ(m, new_m) << "acknowledged: " << said.words;
        } else {
            EXPECT_TRUE(m == old_m || m == new_m) << m << ": " << old_m << " or " << new_m;
        }
    }
}

} // namespace
} // namespace seaway::changes
