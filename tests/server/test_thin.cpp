// SPDX-License-Identifier: Apache-2.0
// What programs of the gale (three cascades of 256 x 256) have in memory: real ones, for as long as it takes to fill a ring of
// forty-eight keyframes a cascade, were there one. Resident size is a property, not a time: a busy machine makes it no larger.
#include <algorithm>
#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/server/net/clients.h"
#include "tests/support/eventually.h"
#include "tests/support/free_port.h"
#include "tests/support/metrics_page.h"
#include "tests/support/process_status.h"
#include "tests/support/server_process.h"

namespace seaway {
namespace {

/// In units of 2^20 bytes.
double resident_mb(pid_t process) {
    return tests::memory_bytes(process) / (1 << 20);
}

/// A client that asks for one point over and over.
class Asker {
  public:
    Asker(const std::string& url, const std::vector<std::string>& how) : process_(fork()) {
        if (process_ == 0) {
            const int nowhere = open("/dev/null", O_WRONLY);
            dup2(nowhere, STDOUT_FILENO);
            std::vector<const char*> call{"seaway-query", url.c_str(), "--at", "1,2"};
            for (const std::string& word : how)
                call.push_back(word.c_str());
            call.push_back(nullptr);
            execv(SEAWAY_BIN_DIR "/seaway-query", const_cast<char**>(call.data()));
            _exit(127);
        }
    }
    Asker(const Asker&) = delete;
    Asker& operator=(const Asker&) = delete;
    ~Asker() {
        kill(process_, SIGTERM);
        waitpid(process_, nullptr, 0);
    }
    pid_t process() const { return process_; }

  private:
    pid_t process_;
};

double metric(const std::string& url, const std::string& name) {
    return tests::figure_of(tests::ask_http(tests::port_of(url), "/metrics", "GET").body, name);
}

struct Most {
    double client_mb = 0, server_mb = 0;
};

/// Of a device once its kernels are made, and what made them has gone.
Most most_of(const std::vector<std::string>& how, const std::string& device = "native") {
    Most most;
    tests::ServerProcess server(
        {"scenes/north_sea_gale.toml", "--listen", "127.0.0.1:0", "--device", device});
    const std::string url = server.wait_until_ready();
    EXPECT_FALSE(url.empty()) << server.log();
    const Asker asker(url, how);
    if (device != "native") {
        EXPECT_TRUE(tests::eventually([&] { return metric(url, "seaway_keyframes_total") >= 12; }));
        std::this_thread::sleep_for(std::chrono::seconds(5));
    }
    for (int i = 0; i < 60; ++i) { // 15 s: some 110 keyframes
        std::this_thread::sleep_for(std::chrono::milliseconds(250));
        most.client_mb = std::max(most.client_mb, resident_mb(asker.process()));
        most.server_mb = std::max(most.server_mb, resident_mb(server.pid()));
    }
    EXPECT_GT(most.client_mb, 4) << "it runs";
    return most;
}

// Bounds of the issue. Eight splines of 2.4 MB, five sets of maps of 1.6, 8 of program and libraries, and what lies between
// blocks came to 43, and to 36 since blocks go back to the system; what held 48 keyframes a cascade had 280 after this time, and 565 later.
TEST(Thin, who_samples_the_gale_has_48_mb_and_its_server_120) {
    const Most most = most_of({"--watch=20", "--local"});
    EXPECT_LT(most.client_mb, 48);
    EXPECT_LT(most.server_mb, 120);
}

// Naive: 123, of which 46 are code of the compiler that made its kernels, at the start alone.
TEST(Thin, a_server_on_the_device_has_120_mb_once_its_kernels_are_made) {
    EXPECT_LT(most_of({"--watch=20", "--local"}, "0").server_mb, 120);
    EXPECT_LT(most_of({"--watch=20", "--format=csv"}, "0").server_mb, 120);
}

// Its waves are 5 MB, and what they are summed by. Naive: maps are made of them that one point never pays for, 35 MB, and what is made
// on the way to them.
TEST(Thin, who_samples_one_point_of_the_waves_of_the_gale_has_32_mb) {
    EXPECT_LT(most_of({"--watch=60", "--local", "--from=spectrum"}).client_mb, 32);
}

// Maps are made for these, three of a cascade as time runs on.
TEST(Thin, who_samples_many_points_of_the_waves_of_the_gale_has_48_mb) {
    std::vector<std::string> how{"--watch=60", "--local", "--from=spectrum"};
    for (int i = 0; i < 63; ++i)
        how.push_back(fmt::format("--at={},{}", 7 * i, 3 * i));
    EXPECT_LT(most_of(how).client_mb, 48);
}

// Naive: maps come from malloc, which keeps large blocks once one has been freed, and they lie between what lives longer: 213 MB of
// the hurricane, whose maps are of 512, and 343 of the gale after it, for good. It is 58, and 36.
TEST(Thin, who_has_seen_larger_maps_has_no_more_for_it) {
    const std::string port = std::to_string(tests::free_port());
    const auto serve = [&port](const char* scene) {
        return std::make_unique<tests::ServerProcess>(
            std::vector<std::string>{scene, "--listen", "127.0.0.1:" + port, "--device", "native"});
    };
    auto server = serve("scenes/hurricane.toml");
    const std::string url = server->wait_until_ready();
    ASSERT_FALSE(url.empty()) << server->log();
    const Asker asker(url, {"--watch=20", "--local"});
    const auto most_in = [&](int quarters) {
        double most_mb = 0;
        for (int i = 0; i < quarters; ++i) {
            std::this_thread::sleep_for(std::chrono::milliseconds(250));
            most_mb = std::max(most_mb, resident_mb(asker.process()));
        }
        return most_mb;
    };
    EXPECT_LT(most_in(40), 80);
    server->send(SIGKILL);
    server = nullptr; // and its port with it
    server = serve("scenes/north_sea_gale.toml");
    ASSERT_FALSE(server->wait_until_ready().empty()) << server->log();
    ASSERT_TRUE(
        tests::eventually([&] { return metric(url, "seaway_net_keyframes_sent_total") > 0; }));
    // It is another sea: what was held of the one before goes, once this one has come.
    EXPECT_TRUE(tests::eventually([&] { return most_in(4) < 48; }));
    EXPECT_LT(most_in(20), 48);
}

// Splines of half a second to a second lie on the server. Naive: their maps lie beside them, which nobody looks at any more.
TEST(Thin, who_asks_has_12_mb_and_its_server_120) {
    const Most most = most_of({"--watch=20", "--format=csv"});
    EXPECT_LT(most.client_mb, 12);
    EXPECT_LT(most.server_mb, 90) << "71, and 106 with their maps";
}

} // namespace
} // namespace seaway
