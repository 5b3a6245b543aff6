// SPDX-License-Identifier: Apache-2.0
// What signals do to the real server, and what its log and its pages say of the machine.
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <csignal>

#include <gtest/gtest.h>

#include "client/client.h"
#include "server/stop_signal.h"
#include "tests/server/net/clients.h"
#include "tests/support/eventually.h"
#include "tests/support/folder.h"
#include "tests/support/process_status.h"
#include "tests/support/program.h"
#include "tests/support/read_file.h"
#include "tests/support/server_process.h"
#include "tests/support/times_in.h"

namespace seaway {
namespace {

bool comes_in(const std::string& url, const std::string& token) {
    return client::Client::connect({.url = url, .name = "knocks", .token = token, .timeout_s = 60})
        .has_value();
}

// Naive: threads of a library that has begun before the signals are blocked take them, and what waits for them hears nothing.
TEST(StopSignalDeathTest, is_heard_by_who_waits_however_many_threads_began_before_it) {
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    for (const bool fails : {false, true})
        EXPECT_EXIT(
            {
                server::StopSignal::end_at_once(3);
                std::vector<std::thread> before;
                for (int i = 0; i < 4; ++i)
                    before.emplace_back([] {
                        for (;;)
                            std::this_thread::sleep_for(std::chrono::hours(1));
                    });
                const server::StopSignal stop;
                for (std::thread& thread : before)
                    pthread_kill(thread.native_handle(), SIGTERM);
                if (fails)
                    server::StopSignal::fail();
                const bool asked = stop.wait([] {}, std::chrono::hours(1), [] {});
                std::_Exit(asked ? 42 : 43);
            },
            testing::ExitedWithCode(fails ? 43 : 42), "");
}

TEST(Signals, a_hang_up_reads_the_tokens_again_and_others_change_nothing) {
    const tests::Folder& folder = tests::folder();
    const std::string file = folder.write("signals.token", "old\n");
    tests::ServerProcess server({"scenes/calm.toml", "--device", "native", "--listen",
                                 "127.0.0.1:0", "--client-token-file", file,
                                 "--wrong-tokens-per-address", "0"});
    const std::string url = server.wait_until_ready();
    ASSERT_FALSE(url.empty()) << server.log();
    for (const int signal : {SIGUSR1, SIGUSR2, SIGPIPE})
        server.send(signal);
    ASSERT_TRUE(comes_in(url, "old")) << server.log();
    folder.write("signals.token", "new\n");
    server.send(SIGHUP);
    ASSERT_TRUE(tests::eventually([&] { return comes_in(url, "new"); })) << server.log();
    EXPECT_FALSE(comes_in(url, "old"));
    EXPECT_EQ(server.log().find("new\n"), std::string::npos) << "no secrets";
    folder.write("signals.token", "\xEF\xBB\xBFnewest\n");
    server.send(SIGHUP);
    ASSERT_TRUE(tests::eventually([&] {
        return server.log().find("event=reload_refused why=\"" + file + ": begins with a byte") !=
               std::string::npos;
    })) << server.log();
    ASSERT_TRUE(comes_in(url, "new")) << "a broken file keeps the old ones";
    server.send(SIGTERM);
    EXPECT_EQ(server.wait_for_exit(std::chrono::seconds(20)), 0) << server.log();
}

/// Lines of a log that say what became of a file, once there are so many reloads in it; without what stands before them.
std::vector<std::string> files_read_again(tests::ServerProcess& server, std::size_t reloads) {
    const auto count = [&server] {
        return static_cast<std::size_t>(tests::times_in(server.log(), " event=reload"));
    };
    EXPECT_TRUE(tests::eventually([&] { return count() == reloads; })) << server.log();
    std::vector<std::string> lines;
    std::istringstream in(server.log());
    for (std::string line; std::getline(in, line);) {
        if (line.find(" event=reload") != std::string::npos && --reloads > 0)
            lines.clear();
        if (const std::size_t at = line.find("event=file_read_again"); at != std::string::npos)
            lines.push_back(line.substr(at));
    }
    return lines;
}

// Naive: "reloaded", and an operator who has changed the file of options, or the token in the wrong folder, goes on
// believing that it holds.
TEST(Signals, a_hang_up_says_of_each_file_whether_it_was_read_again_and_why_not) {
    const tests::Folder& folder = tests::folder();
    const auto file = [&](const std::string& option, const std::string& name,
                          const std::string& outcome) {
        return "event=file_read_again " + (option.empty() ? "" : "option=\"" + option + "\" ") +
               "file=\"" + folder.file(name) + "\" outcome=" + outcome;
    };
    std::filesystem::copy_file(SEAWAY_SOURCE_DIR "/scenes/calm.toml", folder.file("hup.toml"));
    folder.write("hup.client", "secret-one\n");
    folder.write("hup.admin", "secret-two\n");
    const std::string config =
        folder.write("hup.options", "client-token-file = \"" + folder.file("hup.client") +
                                        "\"\nadmin-token-file = \"" + folder.file("hup.admin") +
                                        "\"\ndevice = \"native\"\nlisten = \"127.0.0.1:0\"\n");
    tests::ServerProcess server({folder.file("hup.toml"), "--config", config});
    ASSERT_FALSE(server.wait_until_ready().empty()) << server.log();
    server.send(SIGHUP);
    EXPECT_EQ(files_read_again(server, 1),
              (std::vector{file("--client-token-file", "hup.client", "unchanged"),
                           file("--admin-token-file", "hup.admin", "unchanged"),
                           file("", "hup.toml", "unchanged"),
                           file("--config", "hup.options", "unchanged")}));
    folder.write("hup.client", "secret-three\n");
    std::ofstream(folder.file("hup.toml"), std::ios::app) << "# another one\n";
    std::filesystem::remove(config);
    server.send(SIGHUP);
    EXPECT_EQ(files_read_again(server, 2),
              (std::vector{file("--client-token-file", "hup.client", "read_again"),
                           file("--admin-token-file", "hup.admin", "unchanged"),
                           file("", "hup.toml", "needs_restart") +
                               " why=\"is read at the start alone; `seaway-ctl load` takes the sea "
                               "over to a scene while it runs\"",
                           file("--config", "hup.options", "failed") +
                               " why=\"cannot be read, and a restart needs it\""}));
    folder.write("hup.client", "secret-four\n");
    folder.write("hup.admin", "\n");
    server.send(SIGHUP);
    const std::vector<std::string> broken = files_read_again(server, 3);
    ASSERT_EQ(broken.size(), 4u);
    EXPECT_EQ(broken[0], file("--client-token-file", "hup.client", "kept") +
                             " why=\"--admin-token-file failed, and all are taken or none\"");
    EXPECT_EQ(broken[1].find(file("--admin-token-file", "hup.admin", "failed") + " why=\""), 0u)
        << broken[1];
    EXPECT_NE(server.log().find("event=reload_refused why="), std::string::npos);
    EXPECT_EQ(server.log().find("secret"), std::string::npos) << "what stands in a file";
}

// A scene with a sea and a timetable that take a while to look through.
TEST(Signals, who_is_asked_to_stop_before_the_scene_has_been_read_stops_with_exit_code_0) {
    std::string scene = tests::read_file(SEAWAY_SOURCE_DIR "/scenes/north_sea_gale.toml");
    for (int hour = 1; hour <= 64; ++hour)
        scene += "\n[[weather]]\nat_s = " + std::to_string(3600 * hour) +
                 "\nover_s = 600\nset = { sea.system.0.wind_speed_10m_mps = " +
                 std::to_string(12 + hour % 7) + " }\n";
    for (const int signal : {SIGTERM, SIGINT}) {
        tests::ServerProcess server({tests::folder().write("long.toml", scene), "--device",
                                     "native", "--listen", "127.0.0.1:0"});
        // It is past the loader: SIGUSR1 is passed over from the first line on.
        ASSERT_TRUE(tests::eventually([&] {
            const std::string process = "/proc/" + std::to_string(server.pid());
            return (tests::signals_in(process, "SigIgn") >> (SIGUSR1 - 1) & 1) == 1;
        }));
        server.send(signal);
        EXPECT_EQ(server.wait_for_exit(std::chrono::seconds(60)), 0) << server.log();
    }
}

// 2026-11-22T23:27:58.723+0100: without the zone a line says nothing beside those of another machine.
TEST(Signals, each_line_of_the_log_has_its_time_with_the_zone) {
    tests::ServerProcess server(
        {"scenes/calm.toml", "--device", "native", "--listen", "127.0.0.1:0"});
    ASSERT_FALSE(server.wait_until_ready().empty()) << server.log();
    const std::string log = server.log();
    EXPECT_TRUE(std::regex_search(
        log, std::regex(R"((^|\n)\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}[+-]\d\d:?\d\d info )")))
        << log;
}

TEST(State, says_which_scene_runs_and_not_where_its_file_lies) {
    const std::filesystem::path scene =
        std::filesystem::path(tests::folder().file("secret place")) / "my calm.toml";
    std::filesystem::create_directories(scene.parent_path());
    std::filesystem::copy_file(SEAWAY_SOURCE_DIR "/scenes/calm.toml", scene);
    tests::ServerProcess server({scene.string(), "--device", "native", "--listen", "127.0.0.1:0"});
    const std::string url = server.wait_until_ready();
    ASSERT_FALSE(url.empty()) << server.log();
    const std::string state = tests::ask_http(tests::port_of(url), "/v1/state", "GET").body;
    EXPECT_NE(state.find("\"scene\": \"my calm.toml\""), std::string::npos) << state;
    for (const char* page : {"/", "/v1/state", "/v1/plan", "/metrics", "/healthz", "/none"})
        EXPECT_EQ(tests::ask_http(tests::port_of(url), page, "GET").body.find("secret place"),
                  std::string::npos)
            << page;
}

TEST(Start, fewer_open_files_than_connections_is_exit_code_2) {
    const tests::Output ran = tests::run_program(
        "seaway-server", SEAWAY_SOURCE_DIR "/scenes/calm.toml --device native --listen 127.0.0.1:0",
        {}, "ulimit -n 100; exec");
    EXPECT_EQ(ran.status, 2);
    EXPECT_NE(
        ran.err.find("--connections-max 1280: 1344 open files are needed and 100 are allowed"),
        std::string::npos)
        << ran.err;
}

} // namespace
} // namespace seaway
