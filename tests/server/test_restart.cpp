// SPDX-License-Identifier: Apache-2.0
// A server that is killed and started again, with real programs: the same sea at the same time.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <regex>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "client/client.h"
#include "server/journal/sea_clock.h"
#include "tests/support/folder.h"
#include "tests/support/server_process.h"

namespace seaway {
namespace {

using client::Client;

std::vector<std::string> arguments(const std::string& data_dir,
                                   const std::string& scene = "scenes/calm.toml") {
    return {scene, "--listen", "127.0.0.1:0", "--device", "native", "--data-dir", data_dir};
}

std::unique_ptr<Client> connect(tests::ServerProcess& server) {
    const std::string url = server.wait_until_ready();
    EXPECT_FALSE(url.empty()) << server.log();
    client::ConnectOptions options;
    options.url = url;
    Result<std::unique_ptr<Client>> client = Client::connect(options);
    EXPECT_TRUE(client) << (client ? "" : client.error().message);
    return client ? std::move(*client) : nullptr;
}

/// Of the log: "epoch=2026-11-22T23:17:09.000250Z".
std::string epoch_of(const tests::ServerProcess& server) {
    std::smatch found;
    const std::string log = server.log();
    return std::regex_search(log, found, std::regex("epoch=(\\S+Z)")) ? found[1].str() : "";
}

std::vector<sea::QueryPoint> hundred_points() {
    std::mt19937_64 random(88);
    std::uniform_real_distribution<double> place(-3000, 3000);
    std::vector<sea::QueryPoint> points;
    for (int i = 0; i < 100; ++i)
        points.push_back({place(random), place(random), 1'000'000L * (i - 30)});
    return points;
}

TEST(Restart, killed_at_any_instant_it_serves_the_same_sea_at_the_time_that_it_would_have) {
    const std::string folder = tests::folder().file("sea");
    const std::vector<sea::QueryPoint> points = hundred_points();
    std::mt19937 random(9);
    std::vector<sea::Answer> uninterrupted;
    std::string epoch;
    double ahead_s = 0; // of sea time before UTC, as the first server had it
    for (int start = 0; start < 6; ++start) {
        tests::ServerProcess server(arguments(folder));
        const auto client = connect(server);
        ASSERT_TRUE(client);
        const auto answers = client->ask(points, {.exact = true});
        ASSERT_TRUE(answers) << answers.error().message;
        const double ahead =
            1e-6 * static_cast<double>(client->now_us() - server::SeaClock::utc_now_us());
        if (start == 0) {
            uninterrupted = *answers;
            epoch = epoch_of(server);
            ahead_s = ahead;
            EXPECT_NE(epoch, "");
        }
        EXPECT_EQ(epoch_of(server), epoch);
        // Two clients each know sea time to half a round trip, on a busy machine some ten milliseconds.
        EXPECT_NEAR(ahead, ahead_s, 0.25) << "start " << start;
        for (std::size_t i = 0; i < points.size(); ++i)
            EXPECT_EQ((*answers)[i].height_m, uninterrupted[i].height_m) << i;
        std::this_thread::sleep_for(std::chrono::milliseconds(random() % 150));
        server.send(SIGKILL);
        EXPECT_EQ(server.wait_for_exit(std::chrono::seconds(10)), 128 + SIGKILL);
    }
}

TEST(Restart, without_a_data_folder_a_sea_begins_with_its_process) {
    tests::ServerProcess server(
        {"scenes/calm.toml", "--listen", "127.0.0.1:0", "--device", "native"});
    const auto before = server::SeaClock::utc_now_us();
    const auto client = connect(server);
    ASSERT_TRUE(client);
    const sea::TimeUs now_us = client->now_us();
    EXPECT_GE(now_us, -100'000);
    // Not before the process was there; the slack is a clock known to half a round trip.
    EXPECT_LE(now_us, server::SeaClock::utc_now_us() - before + 1'000'000);
}

TEST(Restart, a_journal_of_another_sea_is_named_with_what_differs_and_kept) {
    const std::string folder = tests::folder().file("other");
    {
        tests::ServerProcess server(arguments(folder));
        ASSERT_FALSE(server.wait_until_ready().empty()) << server.log();
        server.send(SIGTERM);
        EXPECT_EQ(server.wait_for_exit(std::chrono::seconds(10)), 0);
    }
    const auto refused = [&](const std::string& scene, const std::string& says) {
        tests::ServerProcess server(arguments(folder, scene));
        EXPECT_EQ(server.wait_until_ready(), "");
        EXPECT_EQ(server.wait_for_exit(std::chrono::seconds(60)), 2);
        const std::string log = server.log();
        EXPECT_NE(log.find(folder + "/journal.sqlite is the journal of another sea"),
                  std::string::npos)
            << log;
        EXPECT_NE(log.find(says), std::string::npos) << log;
    };
    refused("scenes/north_sea_gale.toml", "the scene says");
    // One number of it is another.
    std::ifstream file(SEAWAY_SOURCE_DIR "/scenes/calm.toml");
    std::string text{std::istreambuf_iterator<char>(file), {}};
    text = std::regex_replace(text, std::regex("seed = \\d+"), "seed = 424242");
    ASSERT_NE(text.find("424242"), std::string::npos);
    refused(tests::folder().write("changed.toml", text), "424242");
    // The same sea in other words and another place goes on.
    std::ifstream again(SEAWAY_SOURCE_DIR "/scenes/calm.toml");
    const std::string same =
        "# the same\n" + std::string(std::istreambuf_iterator<char>(again), {});
    tests::ServerProcess server(arguments(folder, tests::folder().write("same.toml", same)));
    EXPECT_FALSE(server.wait_until_ready().empty()) << server.log();
}

TEST(Restart, a_data_folder_in_use_is_named) {
    const std::string folder = tests::folder().file("used");
    tests::ServerProcess first(arguments(folder));
    ASSERT_FALSE(first.wait_until_ready().empty()) << first.log();
    tests::ServerProcess second(arguments(folder));
    EXPECT_EQ(second.wait_until_ready(), "");
    EXPECT_EQ(second.wait_for_exit(std::chrono::seconds(60)), 2);
    EXPECT_NE(second.log().find("--data-dir " + folder + ": another process works in it"),
              std::string::npos)
        << second.log();
}

} // namespace
} // namespace seaway
