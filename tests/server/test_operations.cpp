// SPDX-License-Identifier: Apache-2.0
// What operators use, with the real program: --check, --config, --log json, a service manager, the dashboard.
#include <atomic>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>
#include <thread>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "client/client.h"
#include "server/journal/sqlite_journal.h"
#include "tests/server/net/clients.h"
#include "tests/support/eventually.h"
#include "tests/support/folder.h"
#include "tests/support/metrics_page.h"
#include "tests/support/process_status.h"
#include "tests/support/server_process.h"

namespace seaway {
namespace {

int exit_code_of(tests::ServerProcess& server) {
    return server.wait_for_exit(std::chrono::seconds(60)).value_or(-1);
}

TEST(Check, looks_at_scene_files_and_addresses_and_serves_nothing) {
    const std::string folder = tests::folder().file("checked");
    tests::ServerProcess fine({"scenes/north_sea_gale.toml", "--check", "--data-dir", folder});
    EXPECT_EQ(exit_code_of(fine), 0) << fine.log();
    EXPECT_FALSE(std::filesystem::exists(folder)) << "a look makes no journal";
    struct Wrong {
        std::vector<std::string> arguments;
        const char* says;
    };
    const Wrong wrong[] = {
        {{"tests/data/scenes/out_of_range.toml", "--check"}, "gamma"},
        {{"scenes/calm.toml", "--check", "--listen", "nowhere"}, "--listen nowhere"},
        {{"scenes/calm.toml", "--check", "--request-bytes-per-address", "1"},
         "--request-bytes-per-address 1"},
        {{"scenes/calm.toml", "--check", "--client-token-file", "/no/such/token"},
         "/no/such/token"},
        {{"scenes/calm.toml", "--check", "--tls-cert", "/no/cert", "--tls-key", "/no/key"},
         "--tls-cert /no/cert"}};
    for (const Wrong& w : wrong) {
        tests::ServerProcess server(w.arguments);
        EXPECT_EQ(exit_code_of(server), 2);
        EXPECT_NE(server.log().find(w.says), std::string::npos) << server.log();
    }
}

// What a start would find out, or would not: that everybody is an administrator.
TEST(Check, refuses_addresses_and_tokens_that_are_fine_alone) {
    const std::string token = tests::folder().write("both.token", "swordfish\n"),
                      same = tests::folder().write("same.token", "swordfish\n");
    struct Wrong {
        std::vector<std::string> arguments;
        const char* says;
        int code;
    };
    const Wrong wrong[] = {
        {{"--listen", "127.0.0.1:9430", "--health-listen", "127.0.0.1:9430"},
         "--health-listen 127.0.0.1:9430: --listen 127.0.0.1:9430 has that port already",
         2},
        {{"--listen", "0.0.0.0:9430", "--health-listen", "127.0.0.1:9430"}, "has that port", 2},
        {{"--client-token-file", token, "--admin-token-file", token},
         "which would make every client an administrator",
         2},
        {{"--client-token-file", token, "--admin-token-file", same},
         "same.token: the same token",
         2},
        // Of the addresses that are kept for documents (RFC 5737): no machine has one.
        {{"--listen", "192.0.2.1:9430"}, "this machine has no such address", 4},
        {{"--listen", "127.0.0.1:0", "--health-listen", "192.0.2.1:9431"}, "192.0.2.1:9431", 4}};
    for (const Wrong& w : wrong)
        for (const bool check : {true, false}) {
            std::vector<std::string> arguments{"scenes/calm.toml", "--device", "native"};
            arguments.insert(arguments.end(), w.arguments.begin(), w.arguments.end());
            if (check)
                arguments.push_back("--check");
            tests::ServerProcess server(arguments);
            EXPECT_EQ(exit_code_of(server), w.code) << server.log();
            EXPECT_NE(server.log().find(w.says), std::string::npos) << server.log();
        }
    tests::ServerProcess fine({"scenes/calm.toml", "--check", "--listen", "127.0.0.1:0",
                               "--health-listen", "127.0.0.1:0"});
    EXPECT_EQ(exit_code_of(fine), 0) << "each takes a port of its own: " << fine.log();
}

TEST(Config, a_file_says_what_the_command_line_does_not) {
    // A '#' in a name is no comment, and a list may have many lines.
    const std::string token = tests::folder().write("config#1.token", "swordfish\n");
    const std::string config = tests::folder().write(
        "server.toml", "# comments are fine\nlisten = \"127.0.0.1:1\"\ndevice = \"native\"\n"
                       "sessions-max = 17\nallow-origin = [\n  \"https://a.example\", # one\n  "
                       "\"https://b.example\",\n]\nclient-token-file = \"" +
                           token + "\"\n");
    tests::ServerProcess server(
        {"scenes/calm.toml", "--config", config, "--listen", "127.0.0.1:0"});
    const std::string url = server.wait_until_ready();
    ASSERT_FALSE(url.empty()) << server.log();
    EXPECT_NE(server.log().find("device=\"native"), std::string::npos) << server.log();
    const int port = tests::port_of(url);
    EXPECT_EQ(tests::ask_http(port, "/metrics", "GET").status, 401) << "the file's token";
    EXPECT_NE(tests::ask_http(port, "/metrics", "GET", "Bearer swordfish")
                  .body.find("seaway_net_sessions_max 17\n"),
              std::string::npos);
}

TEST(Config, what_is_wrong_in_it_is_named_in_one_line) {
    const auto says = [](const std::string& text) {
        tests::ServerProcess server(
            {"scenes/calm.toml", "--config", tests::folder().write("wrong.toml", text)});
        EXPECT_EQ(exit_code_of(server), 2) << text;
        const std::string log = server.log();
        EXPECT_EQ(std::count(log.begin(), log.end(), '\n'), 1) << log;
        return log;
    };
    EXPECT_NE(says("\n\nlisen = \"127.0.0.1:0\"\n").find("wrong.toml:3: lisen"), std::string::npos);
    EXPECT_NE(says("[net]\nlisten = \"127.0.0.1:0\"\n").find("wrong.toml:1: net"),
              std::string::npos);
    EXPECT_NE(says("data-dir\n").find("wrong.toml:1:"), std::string::npos);
    EXPECT_NE(says("\n'' = 1\n").find("wrong.toml:2: an option without a name"), std::string::npos);
    EXPECT_NE(says("data-dir = true\n").find("a value is expected"), std::string::npos);
    EXPECT_NE(says("check = 1\n").find("true or false"), std::string::npos);
    EXPECT_NE(says("listen = [\"a\", \"b\"]\n").find("one value"), std::string::npos);
    EXPECT_NE(says("data-dir = \"\"\n").find("empty word"), std::string::npos);
    EXPECT_NE(says("config = \"again.toml\"\n").find("config"), std::string::npos);
    EXPECT_NE(says("lisen = \"127.0.0.1:0\"\n").find("lisen"), std::string::npos);
    EXPECT_NE(says("sessions-max = \"many\"\n").find("many"), std::string::npos);
    EXPECT_NE(says("sessions-max = 0\n").find("wrong.toml:1: sessions-max"), std::string::npos);
    tests::ServerProcess missing({"scenes/calm.toml", "--config", "/no/such/file.toml"});
    EXPECT_EQ(exit_code_of(missing), 2);
    EXPECT_NE(missing.log().find("/no/such/file.toml"), std::string::npos) << missing.log();
}

TEST(JsonLogs, why_a_server_does_not_start_is_an_object_too) {
    tests::ServerProcess server(
        {"scenes/calm.toml", "--log", "json", "--data-dir", "/no/such/folder"});
    EXPECT_EQ(exit_code_of(server), 2);
    const auto object = nlohmann::json::parse(server.log(), nullptr, false);
    ASSERT_TRUE(object.is_object()) << server.log();
    EXPECT_NE(object["message"].get<std::string>().find("/no/such/folder"), std::string::npos);
}

// Whoever started it does not read its log: requests that are logged come without end, and it serves on, and stops.
TEST(Log, nobody_who_serves_waits_for_who_reads_it) {
    int unread[2];
    ASSERT_EQ(pipe(unread), 0);
    tests::ServerProcess server(
        {"scenes/calm.toml", "--device", "native", "--listen", "127.0.0.1:0"}, unread[1]);
    const std::string url = server.wait_until_ready();
    ASSERT_FALSE(url.empty());
    for (int i = 0; i < 2000; ++i) { // a pipe holds 64 KB, each of these is a line of 100 bytes
        tests::RawPeer peer(tests::port_of(url));
        peer.say("this is no request at all\r\n\r\n");
    }
    EXPECT_EQ(tests::ask_http(tests::port_of(url), "/healthz", "GET").body, "ok\n");
    server.send(SIGTERM);
    // Exit code 3 is that of one that hangs, which its service manager would start again.
    EXPECT_EQ(exit_code_of(server), 0);
    close(unread[0]);
    close(unread[1]);
}

TEST(JsonLogs, every_line_of_a_server_is_an_object) {
    tests::ServerProcess server(
        {"scenes/calm.toml", "--device", "native", "--listen", "127.0.0.1:0", "--log", "json"});
    const std::string url = server.wait_until_ready();
    ASSERT_FALSE(url.empty()) << server.log();
    ASSERT_TRUE(
        client::Client::connect({.url = url, .name = "a \"quoted\" client", .timeout_s = 60}));
    server.send(SIGTERM);
    EXPECT_EQ(exit_code_of(server), 0);
    std::istringstream lines(server.log());
    std::set<std::string> events;
    for (std::string line; std::getline(lines, line);) {
        const auto object = nlohmann::json::parse(line, nullptr, false);
        ASSERT_TRUE(object.is_object()) << line;
        for (const char* key : {"time", "level", "message"})
            EXPECT_TRUE(object.contains(key)) << line;
        if (object.contains("fields"))
            events.insert(object["fields"]["event"]);
    }
    EXPECT_TRUE(events.contains("session_open") && events.contains("session_closed"));
}

/// Where a service manager listens, and what it was told.
class Manager {
  public:
    Manager() : path_(tests::folder().fresh("notify")), socket_(socket(AF_UNIX, SOCK_DGRAM, 0)) {
        sockaddr_un address{.sun_family = AF_UNIX};
        path_.copy(address.sun_path, sizeof address.sun_path - 1);
        EXPECT_EQ(bind(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
        setenv("NOTIFY_SOCKET", path_.c_str(), 1);
        setenv("WATCHDOG_USEC", "200000", 1);
    }
    ~Manager() {
        unsetenv("NOTIFY_SOCKET");
        unsetenv("WATCHDOG_USEC");
        close(socket_);
    }
    /// What has been told so far.
    void forget() {
        char words[4096];
        while (recv(socket_, words, sizeof words, MSG_DONTWAIT) > 0)
            ;
    }
    /// Waits until it is told this; false after a minute.
    bool hears(const std::string& what) {
        for (int i = 0; i < 600; ++i) {
            char words[4096];
            timeval limit{0, 100'000};
            setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
            const auto count = recv(socket_, words, sizeof words, 0);
            if (count > 0 &&
                std::string(words, static_cast<std::size_t>(count)).find(what) != std::string::npos)
                return true;
        }
        return false;
    }

  private:
    std::string path_;
    int socket_;
};

TEST(ServiceManager, hears_that_it_serves_that_it_comes_on_and_that_it_stops) {
    Manager manager;
    tests::ServerProcess server(
        {"scenes/calm.toml", "--device", "native", "--listen", "127.0.0.1:0"});
    EXPECT_TRUE(manager.hears("READY=1\nSTATUS=ws://127.0.0.1:")) << server.log();
    for (int beat = 0; beat < 3; ++beat)
        EXPECT_TRUE(manager.hears("WATCHDOG=1"));
    // Also while it is asked to read its files again, again and again.
    std::atomic<bool> enough = false;
    std::thread asker([&] {
        while (!enough) {
            server.send(SIGHUP);
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
        }
    });
    manager.forget();
    for (int beat = 0; beat < 3; ++beat)
        EXPECT_TRUE(manager.hears("WATCHDOG=1"));
    enough = true;
    asker.join();
    server.send(SIGTERM);
    EXPECT_TRUE(manager.hears("STOPPING=1"));
    EXPECT_EQ(exit_code_of(server), 0);
}

// Naive: a log that is longer than TimeoutStartSec= is killed while it is played, again and again.
TEST(ServiceManager, hears_that_a_start_comes_on_while_it_plays_its_log) {
    const std::string folder = tests::folder().fresh("played");
    const std::vector<std::string> words{"scenes/calm.toml", "--device",   "native", "--listen",
                                         "127.0.0.1:0",      "--data-dir", folder};
    {
        tests::ServerProcess server(words);
        ASSERT_FALSE(server.wait_until_ready().empty()) << server.log();
        server.send(SIGTERM);
        EXPECT_EQ(exit_code_of(server), 0);
    }
    {
        auto journal = server::SqliteJournal::open(folder, {}).value();
        const std::string scene = journal->since(0).value().front().scene;
        ASSERT_TRUE(journal->append({2, 10'000'000, 20'000'000, scene}));
    }
    Manager manager;
    tests::ServerProcess server(words);
    EXPECT_TRUE(manager.hears("EXTEND_TIMEOUT_USEC=60000000")) << server.log();
    EXPECT_TRUE(manager.hears("READY=1")) << "and not before that: " << server.log();
}

TEST(ProcessMetrics, say_what_the_process_takes) {
    tests::ServerProcess server(
        {"scenes/calm.toml", "--device", "native", "--listen", "127.0.0.1:0"});
    const std::string url = server.wait_until_ready();
    ASSERT_FALSE(url.empty()) << server.log();
    const auto metrics = [&] {
        return tests::read_metrics(tests::ask_http(tests::port_of(url), "/metrics", "GET").body)
            .values;
    };
    auto before = metrics();
    // As the system counts them, a moment later: once it takes no more.
    EXPECT_TRUE(tests::eventually([&] {
        const double said = metrics().at("process_resident_memory_bytes");
        return std::abs(said / tests::memory_bytes(server.pid()) - 1) < 0.1;
    }));
    EXPECT_GT(before.at("process_cpu_seconds_total"), 0);
    tests::RawPeer one(tests::port_of(url)), two(tests::port_of(url));
    auto after = before;
    EXPECT_TRUE(tests::eventually([&] {
        after = metrics();
        return after.at("process_open_fds") == before.at("process_open_fds") + 2;
    })) << after.at("process_open_fds")
        << " and before " << before.at("process_open_fds");
    EXPECT_GE(after.at("process_cpu_seconds_total"), before.at("process_cpu_seconds_total"));
    EXPECT_GT(after.at("process_max_fds"), after.at("process_open_fds"));
}

TEST(Threads, have_names_that_say_what_they_do) {
    const std::string journal = tests::folder().file("named");
    tests::ServerProcess server({"scenes/calm.toml", "--device", "native", "--listen",
                                 "127.0.0.1:0", "--data-dir", journal, "--io-threads", "2"});
    ASSERT_FALSE(server.wait_until_ready().empty()) << server.log();
    const auto names = [&] {
        std::set<std::string> all;
        for (const auto& thread :
             std::filesystem::directory_iterator("/proc/" + std::to_string(server.pid()) + "/task"))
            all.insert(tests::status_of(thread.path(), "Name"));
        return all;
    };
    for (const char* const name : {"sea-network", "sea-simulation", "sea-answers", "sea-encoder",
                                   "sea-senders", "sea-director", "sea-log"})
        EXPECT_TRUE(tests::eventually([&] { return names().contains(name); })) // each names itself
            << name << " of " << testing::PrintToString(names());
}

TEST(MemoryBudget, one_that_the_scene_does_not_fit_into_is_refused_with_the_least_there_is) {
    const auto checks = [](const std::string& mib) {
        tests::ServerProcess server({"scenes/calm.toml", "--check", "--memory-mb", mib});
        const int code = exit_code_of(server);
        return std::pair(code, server.log());
    };
    const auto [code, log] = checks("20");
    EXPECT_EQ(code, 2);
    static const std::regex least("--memory-mb 20: .*calm.toml needs ([0-9]+) and more");
    std::smatch says;
    ASSERT_TRUE(std::regex_search(log, says, least)) << log;
    EXPECT_EQ(checks(says[1]).first, 0);
    EXPECT_EQ(checks(std::to_string(std::stoi(says[1]) - 1)).first, 2);
}

// Of a sea without waves, which is made in a second.
TEST(MemoryBudget, i10_eight_cascades_of_2048_are_refused_with_what_they_need) {
    std::string text = "[sea]\n";
    for (double length_m = 8000; length_m > 20; length_m /= 2.3)
        text += fmt::format("[[cascade]]\nlength_m = {:.0f}\nsize = 2048\n", length_m);
    tests::ServerProcess server(
        {tests::folder().write("eight_of_2048.toml", text), "--check", "--memory-mb", "1024"});
    EXPECT_EQ(exit_code_of(server), 2);
    static const std::regex least("--memory-mb 1024: .*eight_of_2048.toml needs ([0-9]+) and more");
    std::smatch says;
    const std::string log = server.log();
    ASSERT_TRUE(std::regex_search(log, says, least)) << log;
    // Two keyframes of each are held at least, of heights and their rates: 2^22 points of 4 bytes.
    EXPECT_GT(std::stoi(says[1]), 8 * 2 * 2 * 16);
}

// A name that the server does not have would be an empty panel for ever.
TEST(Dashboard, shows_only_metrics_that_the_server_has) {
    tests::ServerProcess server(
        {"scenes/calm.toml", "--device", "native", "--listen", "127.0.0.1:0"});
    const std::string url = server.wait_until_ready();
    ASSERT_FALSE(url.empty()) << server.log();
    const std::string page = tests::ask_http(tests::port_of(url), "/metrics", "GET").body;
    std::ifstream file(SEAWAY_SOURCE_DIR "/deploy/grafana.json");
    const auto dashboard = nlohmann::json::parse(file, nullptr, false);
    ASSERT_TRUE(dashboard.is_object());
    int shown = 0;
    for (const auto& panel : dashboard["panels"])
        for (const auto& target : panel.value("targets", nlohmann::json::array())) {
            const std::string query = target["expr"];
            static const std::regex name("(seaway|process)_\\w+");
            for (std::sregex_iterator at(query.begin(), query.end(), name), end; at != end; ++at) {
                EXPECT_NE(page.find("# TYPE " + at->str() + " "), std::string::npos) << query;
                ++shown;
            }
        }
    EXPECT_GT(shown, 20);
}

} // namespace
} // namespace seaway
