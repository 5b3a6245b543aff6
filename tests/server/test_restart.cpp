// SPDX-License-Identifier: Apache-2.0
// A server that is killed and started again, with real programs: the same sea at the same time.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <random>
#include <regex>
#include <set>
#include <sstream>

#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "client/client.h"
#include "server/journal/sea_clock.h"
#include "tests/server/change_bench.h"
#include "tests/support/eventually.h"
#include "tests/support/folder.h"
#include "tests/support/free_port.h"
#include "tests/support/read_file.h"
#include "tests/support/server_process.h"
#include "tests/support/times_in.h"

namespace seaway {
namespace {

using changes::small_sea;
using client::Client;

/// At a port of its own (tests::free_port()) where another one comes in its place; 0: any.
std::vector<std::string> arguments(const std::string& data_dir,
                                   const std::string& scene = small_sea, int port = 0) {
    return {scene,        "--listen", fmt::format("127.0.0.1:{}", port), "--device", "native",
            "--data-dir", data_dir};
}

std::unique_ptr<Client> connect(tests::ServerProcess& server) {
    const std::string url = server.wait_until_ready();
    EXPECT_FALSE(url.empty()) << server.log();
    Result<std::unique_ptr<Client>> client = Client::connect({.url = url, .timeout_s = 60});
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
    double ahead_s = 0, ahead_error_s = 0; // of sea time before UTC, as the first server had it
    for (int start = 0; start < 6; ++start) {
        tests::ServerProcess server(arguments(folder));
        const auto client = connect(server);
        ASSERT_TRUE(client);
        const auto answers = client->ask(points, {.exact = true, .timeout_s = 60});
        ASSERT_TRUE(answers) << answers.error().message;
        double ahead = 0;
        sea::TimeUs took_us = 1'000'000; // the shortest of some looks at both clocks
        for (int i = 0; i < 100; ++i) {
            const sea::TimeUs utc_us = server::SeaClock::utc_now_us();
            const sea::TimeUs now_us = client->now_us();
            const sea::TimeUs after_us = server::SeaClock::utc_now_us();
            if (after_us - utc_us < std::exchange(took_us, std::min(took_us, after_us - utc_us)))
                ahead = 1e-6 * static_cast<double>(now_us - utc_us);
        }
        const double error_s = 1e-6 * client->clock().error_us;
        if (start == 0) {
            uninterrupted = *answers;
            epoch = epoch_of(server);
            ahead_s = ahead;
            ahead_error_s = error_s;
            EXPECT_NE(epoch, "");
        }
        EXPECT_EQ(epoch_of(server), epoch);
        // Two clients each know sea time to half a round trip.
        EXPECT_NEAR(ahead, ahead_s, 0.05 + error_s + ahead_error_s) << "start " << start;
        for (std::size_t i = 0; i < points.size(); ++i)
            EXPECT_EQ((*answers)[i].height_m, uninterrupted[i].height_m) << i;
        std::this_thread::sleep_for(std::chrono::milliseconds(random() % 150));
        server.send(SIGKILL);
        EXPECT_EQ(server.wait_for_exit(std::chrono::seconds(10)), 128 + SIGKILL);
    }
}

/// A process that watches the height at the origin, 20 times a second.
pid_t watch(const std::string& url, const std::string& rows, const std::string& words,
            const char* patience_s) {
    const pid_t watcher = fork();
    if (watcher == 0) {
        const int out = open(rows.c_str(), O_WRONLY | O_CREAT, 0600);
        const int err = open(words.c_str(), O_WRONLY | O_CREAT, 0600);
        dup2(out, STDOUT_FILENO);
        dup2(err, STDERR_FILENO);
        execl(SEAWAY_BIN_DIR "/seaway-query", "seaway-query", url.c_str(), "--at", "0,0", "--watch",
              "20", "--format", "csv", "--timeout", patience_s, nullptr);
        _exit(127);
    }
    return watcher;
}

// The server of a watcher is killed and comes again on the same port: rows go on, at the sea's times.
TEST(Restart, a_watcher_goes_on_with_the_server_that_comes_back) {
    const std::string folder = tests::folder().file("watched");
    const std::string rows = tests::folder().file("rows.csv"),
                      words = tests::folder().file("words");
    const std::vector<std::string> at_one_port = arguments(folder, small_sea, tests::free_port());
    auto server = std::make_unique<tests::ServerProcess>(at_one_port);
    const std::string url = server->wait_until_ready();
    ASSERT_FALSE(url.empty()) << server->log();
    const pid_t watcher = watch(url, rows, words, "10");
    const auto more_rows_come = [&] {
        const auto count = [&] { return tests::times_in(tests::read_file(rows), "\n"); };
        const auto before = count();
        return tests::eventually([&] { return count() >= before + 5; });
    };
    EXPECT_TRUE(more_rows_come());
    // It hangs for a while: the watch gives its connection up, and has another one afterwards.
    server->send(SIGSTOP);
    EXPECT_TRUE(tests::eventually([&] {
        return tests::read_file(words).find("did not answer in time; trying again") !=
               std::string::npos;
    })) << tests::read_file(words);
    server->send(SIGCONT);
    EXPECT_TRUE(more_rows_come()) << tests::read_file(words);
    server->send(SIGKILL);
    EXPECT_TRUE(server->wait_for_exit(std::chrono::seconds(10)));
    server = std::make_unique<tests::ServerProcess>(at_one_port);
    ASSERT_FALSE(server->wait_until_ready().empty()) << server->log();
    EXPECT_TRUE(more_rows_come()) << tests::read_file(words);
    kill(watcher, SIGTERM);
    int status = 0;
    ASSERT_EQ(waitpid(watcher, &status, 0), watcher);
    EXPECT_EQ(WEXITSTATUS(status), 0);
    EXPECT_NE(tests::read_file(words).find("trying again"), std::string::npos)
        << tests::read_file(words);
    // One head, and times that only grow: the same clock before and after.
    std::istringstream lines(tests::read_file(rows));
    std::string line;
    std::getline(lines, line);
    double last_s = 0;
    while (std::getline(lines, line)) {
        const double t_s = std::stod(line.substr(line.find(',', line.find(',') + 1) + 1));
        EXPECT_GT(t_s, last_s);
        last_s = t_s;
    }
}

/// Of each line of the log with this event its time, ms of the day.
std::vector<double> times_of(const std::string& log, const std::string& event) {
    std::vector<double> times_ms;
    const std::regex line("T(\\d\\d):(\\d\\d):(\\d\\d\\.\\d+)\\S* info [^\\n]*event=" + event);
    for (std::sregex_iterator at(log.begin(), log.end(), line), end; at != end; ++at)
        times_ms.push_back(3.6e6 * std::stod((*at)[1]) + 6e4 * std::stod((*at)[2]) +
                           1e3 * std::stod((*at)[3]));
    return times_ms;
}

/// Processes that are ended with it.
struct Watchers {
    std::vector<pid_t> processes;
    ~Watchers() {
        for (const pid_t process : processes) {
            kill(process, SIGTERM);
            waitpid(process, nullptr, 0);
        }
    }
};

// The server is stopped and started again at once: it is there long before any of its watchers may come.
TEST(Restart, watchers_stay_away_for_as_long_as_they_are_told_and_come_back_one_by_one) {
    constexpr int count = 20;
    constexpr double wait_s = 6;
    std::vector<std::string> words =
        arguments(tests::folder().file("told"), small_sea, tests::free_port());
    words.insert(words.end(), {"--retry-after", fmt::format("{}", wait_s)});
    auto server = std::make_unique<tests::ServerProcess>(words);
    const std::string url = server->wait_until_ready();
    ASSERT_FALSE(url.empty()) << server->log();
    Watchers watchers;
    const auto file = [](const char* kind, int i) {
        return tests::folder().file(fmt::format("told_{}_{}", kind, i));
    };
    for (int i = 0; i < count; ++i)
        watchers.processes.push_back(watch(url, file("rows", i), file("words", i), "60"));
    const auto all_open = [&] {
        return tests::eventually(
            [&] { return times_of(server->log(), "session_open").size() == count; });
    };
    ASSERT_TRUE(all_open()) << server->log();
    server->send(SIGTERM);
    ASSERT_EQ(server->wait_for_exit(std::chrono::seconds(20)), 0) << server->log();
    const std::vector<double> stopped_ms = times_of(server->log(), "stopping");
    ASSERT_EQ(stopped_ms.size(), 1u) << server->log();
    server = std::make_unique<tests::ServerProcess>(words);
    ASSERT_FALSE(server->wait_until_ready().empty()) << server->log();
    ASSERT_TRUE(all_open()) << server->log();
    for (const double back_ms : times_of(server->log(), "session_open")) {
        constexpr double day_ms = 8.64e7; // midnight may have been between
        EXPECT_GE(std::fmod(back_ms - stopped_ms[0] + day_ms, day_ms), 1e3 * wait_s);
    }
    std::set<std::string> waits;
    for (int i = 0; i < count; ++i) {
        const std::string text = tests::read_file(file("words", i));
        std::smatch found;
        ASSERT_TRUE(std::regex_search(
            text, found, std::regex("\\(shutting_down\\): .*; trying again in ([0-9.]+) s")))
            << text;
        EXPECT_GE(std::stod(found[1]), wait_s);
        EXPECT_LE(std::stod(found[1]), 2 * wait_s);
        waits.insert(found[1]);
    }
    EXPECT_GT(waits.size(), 5u) << "by lot: of 60 tenths of a second, twenty";
}

TEST(Restart, without_a_data_folder_a_sea_begins_with_its_process) {
    const auto before = server::SeaClock::utc_now_us();
    tests::ServerProcess server({small_sea, "--listen", "127.0.0.1:0", "--device", "native"});
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
        EXPECT_NE(server.log().find("event=sea_begins journal=\"" + folder), std::string::npos)
            << server.log();
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
    const std::string calm = changes::small_sea_text();
    const std::string text = std::regex_replace(calm, std::regex("seed = \\d+"), "seed = 424242");
    ASSERT_NE(text.find("424242"), std::string::npos);
    refused(tests::folder().write("changed.toml", text), "424242");
    // The same sea in other words and another place goes on.
    tests::ServerProcess server(
        arguments(folder, tests::folder().write("same.toml", "# the same\n" + calm)));
    EXPECT_FALSE(server.wait_until_ready().empty()) << server.log();
    EXPECT_NE(server.log().find("event=sea_goes_on journal=\"" + folder), std::string::npos)
        << server.log();
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
    // Nor where somebody has removed what the first one holds.
    ASSERT_TRUE(std::filesystem::remove(folder + "/lock"));
    tests::ServerProcess third(arguments(folder));
    EXPECT_EQ(third.wait_for_exit(std::chrono::seconds(60)), 2) << third.log();
    EXPECT_NE(third.log().find("another process works in it"), std::string::npos) << third.log();
}

} // namespace
} // namespace seaway
