// SPDX-License-Identifier: Apache-2.0
// A server to which the system gives no more memory and no more threads: requests are refused, sessions
// may end, the process goes on.
#include <filesystem>
#include <fstream>
#include <thread>

#include <gtest/gtest.h>
#include <sys/resource.h>

#include "protocol/messages.h"
#include "tests/server/net/clients.h"
#include "tests/support/metrics_page.h"
#include "tests/support/server_process.h"

namespace seaway {
namespace {

using tests::Client;

class Scarcity : public ::testing::Test {
  protected:
    Scarcity()
        : server({"scenes/north_sea_gale.toml", "--device", "native", "--listen", "127.0.0.1:0"}) {
        const std::string url = server.wait_until_ready();
        EXPECT_FALSE(url.empty()) << server.log();
        port = tests::port_of(url);
    }

    /// So much more than it has now.
    void may_take(std::size_t more_bytes) {
        std::ifstream status("/proc/" + std::to_string(server.pid()) + "/status");
        rlim_t has_bytes = 0;
        for (std::string line; std::getline(status, line);)
            if (line.starts_with("VmSize:"))
                has_bytes = 1024 * std::stoull(line.substr(7));
        const rlimit limit{has_bytes + more_bytes, RLIM_INFINITY};
        ASSERT_EQ(prlimit(server.pid(), RLIMIT_AS, &limit, nullptr), 0);
    }
    void may_take_all() {
        const rlimit none{RLIM_INFINITY, RLIM_INFINITY};
        ASSERT_EQ(prlimit(server.pid(), RLIMIT_AS, &none, nullptr), 0);
    }
    double metric(const std::string& name) {
        const std::string page = tests::ask_http(port, "/metrics", "GET").body;
        const std::size_t at = page.find("\n" + name);
        return at == std::string::npos ? 0 : std::stod(page.substr(page.find(' ', at + 1)));
    }
    /// A client that comes now is served, and the server ends when it is asked to.
    void serves_on() {
        const sea::QueryPoint point{1, 2, 3'000'000};
        bool answered = false;
        for (int i = 0; i < 100 && !answered; ++i) {
            Client client(port);
            answered = !client.connect() && client.greet() &&
                       !client.send(protocol::query(1, {&point, 1}, false)) &&
                       client.receive(wire::Body::QueryReply) != nullptr;
        }
        EXPECT_TRUE(answered) << server.log();
        EXPECT_EQ(tests::ask_http(port, "/healthz", "GET").body, "ok\n");
        server.send(SIGTERM);
        const auto code = server.wait_for_exit(std::chrono::seconds(30));
        ASSERT_TRUE(code) << "it does not end";
        EXPECT_EQ(*code, 0) << server.log();
    }

    tests::ServerProcess server;
    int port = 0;
};

TEST_F(Scarcity, without_memory_requests_are_refused_and_the_process_goes_on) {
    for (const std::size_t more_mib : {64, 24, 6}) {
        std::vector<std::unique_ptr<Client>> crowd;
        may_take(more_mib << 20);
        for (int i = 0; i < 12; ++i) {
            auto client = std::make_unique<Client>(port);
            if (client->connect() || !client->greet())
                continue; // it may be this one for which there is no memory
            std::vector<sea::QueryPoint> points(4096);
            for (std::size_t p = 0; p < points.size(); ++p)
                points[p] = {1.0 * static_cast<double>(p), 2.0 * i, (60 + i) * 1'000'000LL};
            for (std::uint32_t id = 1; id <= 16; ++id)
                (void)client->send(protocol::query(id, points, false));
            const sea::TimeUs times[] = {i * 3'600'000'000LL, i * 7'200'000'000LL};
            (void)client->send(
                protocol::fetch(17, times, {.fields = sea::FieldSet::from_bits(0x1fff)}));
            (void)client->send(
                protocol::subscribe(18, {.fields = sea::FieldSet::from_bits(0x1fff)}, 8));
            crowd.push_back(std::move(client));
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(500)); // of work under the limit
        may_take_all();
    }
    // Refused by name, or ended: some of it has been too much.
    EXPECT_GT(metric("seaway_net_requests_refused_total{code=\"too_many_requests\"}") +
                  metric("seaway_net_out_of_memory_total"),
              0);
    serves_on();
}

// A thread's stack takes 8 MiB of addresses.
TEST_F(Scarcity, a_map_for_which_there_is_no_thread_is_refused_and_the_process_goes_on) {
    const std::string map = "/v1/map?width_m=100&height_m=100&columns=64&rows=64&t_s=7";
    may_take(2u << 20); // before the first map: stacks of threads that have ended are kept
    for (int i = 0; i < 3; ++i)
        EXPECT_EQ(tests::ask_http(port, map, "GET").status, 503);
    may_take_all();
    int status = 503; // also for the moment in which the last one ends
    for (int i = 0; i < 100 && status == 503; ++i)
        status = tests::ask_http(port, map, "GET").status;
    EXPECT_EQ(status, 200);
    serves_on();
}

} // namespace
} // namespace seaway
