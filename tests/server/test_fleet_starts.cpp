// SPDX-License-Identifier: Apache-2.0
// How servers of a fleet start, or do not, and what of them can be changed while they run.
#include <array>
#include <filesystem>
#include <memory>
#include <thread>

#include <gtest/gtest.h>

#include "server/journal/nats_place.h"
#include "tests/server/fleet_bench.h"
#include "tests/support/eventually.h"
#include "tests/support/fault_proxy.h"

namespace seaway::changes {
namespace {

using tests::NatsServer;
using tests::ServerProcess;

TEST(Fleet, a_world_of_another_scene_and_wrong_options_are_named_at_the_start) {
    NatsServer nats;
    ServerProcess first(arguments_of(nats.url("w")));
    ASSERT_FALSE(first.wait_until_ready().empty()) << first.log();
    const auto fails = [](std::vector<std::string> words, const std::string& says) {
        ServerProcess server(std::move(words));
        EXPECT_EQ(server.wait_for_exit(std::chrono::seconds(60)), 2);
        EXPECT_NE(server.log().find(says), std::string::npos) << server.log();
    };
    std::vector<std::string> other = arguments_of(nats.url("w"));
    other[0] = "scenes/north_sea_gale.toml";
    fails(other, nats.url("w") + " is the journal of another sea");
    fails(arguments_of("nats://127.0.0.1:1/a.b"), "the world's name is");
    fails(arguments_of("nats://sea:pass@127.0.0.1/w"), "--journal-credentials");
    std::vector<std::string> both = arguments_of(nats.url("w"));
    both.insert(both.end(), {"--data-dir", tests::folder().file("both")});
    fails(both, "--data-dir and --journal both say where the journal is");
    std::vector<std::string> tls = arguments_of(tests::folder().file("folder"));
    tls.insert(tls.end(), {"--journal-tls-ca", "ca.pem"});
    fails(tls, "--journal-tls-ca goes with --journal nats://");
}

TEST(Fleet, a_hang_up_names_the_files_of_the_journal_and_says_when_they_hold) {
    const std::string file = tests::folder().write("hup.credentials", "sea:one\n");
    NatsServer nats("authorization { user: sea, password: \"one\" }");
    std::vector<std::string> words = arguments_of(nats.url("hup"));
    words.insert(words.end(), {"--journal-credentials", file});
    ServerProcess server(words);
    ASSERT_FALSE(server.wait_until_ready().empty()) << server.log();
    const auto says = [&](const std::string& outcome) {
        server.send(SIGHUP);
        return tests::eventually([&] {
            return server.log().find("option=\"--journal-credentials\" file=\"" + file +
                                     "\" outcome=" + outcome) != std::string::npos;
        });
    };
    EXPECT_TRUE(says("unchanged")) << server.log();
    tests::folder().write("hup.credentials", "sea:two\n");
    EXPECT_TRUE(says("next_connection why=\"is read whenever a connection to NATS is made"))
        << server.log();
    tests::folder().write("hup.credentials", "sea:two\nsea:three\n");
    EXPECT_TRUE(says("failed why=\"--journal-credentials " + file + ": neither NATS credentials"))
        << server.log();
    std::filesystem::remove(file);
    EXPECT_TRUE(says("failed why=\"cannot be read, and the next connection")) << server.log();
    EXPECT_EQ(server.log().find("sea:"), std::string::npos) << "what stands in a file";
}

// Who starts it again by its exit code (RestartPreventExitStatus=2) has to, here: NATS comes back.
TEST(Fleet, where_nats_is_away_a_server_ends_with_the_code_of_what_passes) {
    ServerProcess server(arguments_of(fmt::format("nats://127.0.0.1:{}/away", tests::free_port())));
    EXPECT_EQ(server.wait_for_exit(std::chrono::seconds(60)), 5);
    EXPECT_NE(server.log().find("NATS cannot be reached"), std::string::npos) << server.log();
}

// Each of them is waited for for a second, twice at once: for the log and for the other servers.
TEST(Fleet, a_server_of_which_all_hosts_of_nats_hang_ends_in_time_when_it_is_asked_to) {
    NatsServer nats;
    std::array<std::unique_ptr<tests::FaultProxy>, server::nats_servers_max> lines;
    std::string url;
    for (std::unique_ptr<tests::FaultProxy>& line : lines) {
        line = std::make_unique<tests::FaultProxy>(nats.port());
        url += fmt::format("{}127.0.0.1:{}", url.empty() ? "nats://" : ",", line->port());
    }
    ServerProcess server(arguments_of(url + "/hang"));
    const std::string at = server.wait_until_ready();
    ASSERT_FALSE(at.empty()) << server.log();
    for (const auto& line : lines) {
        line->stall(true);
        line->cut();
    }
    // Asked for before it is stale: the change waits for the log by then.
    Said said{};
    std::thread asks([&] {
        said = ctl(at, {"set", "systems.0.wind_speed_10m_mps=15", "--over", "10s"});
    });
    EXPECT_TRUE(tests::eventually([&] { return get(at, "/readyz").status != 200; }));
    server.send(SIGTERM);
    EXPECT_EQ(server.wait_for_exit(std::chrono::seconds(60)), 0) << server.log();
    asks.join();
    EXPECT_NE(said.code, 0) << said.words;
}

TEST(Fleet, a_folder_is_a_journal_under_either_name) {
    std::vector<std::string> words = arguments_of(tests::folder().file("named"));
    std::string epoch;
    for (const char* option : {"--journal", "--data-dir"}) {
        words[5] = option;
        ServerProcess server(words);
        const std::string url = server.wait_until_ready();
        ASSERT_FALSE(url.empty()) << server.log();
        const auto state = nlohmann::json::parse(get(url, "/v1/state").body);
        if (!epoch.empty()) {
            EXPECT_EQ(state["epoch_utc"], epoch);
        }
        epoch = state["epoch_utc"];
        EXPECT_EQ(state["journal"]["shared"], false);
        EXPECT_EQ(get(url, "/metrics").body.find("seaway_sea_stale"), std::string::npos);
        server.send(SIGTERM);
        EXPECT_EQ(server.wait_for_exit(std::chrono::seconds(20)), 0);
    }
}

} // namespace
} // namespace seaway::changes
