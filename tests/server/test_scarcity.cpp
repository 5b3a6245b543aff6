// SPDX-License-Identifier: Apache-2.0
// A server to which the system gives no more memory and no more threads: requests are refused, sessions
// may end, the process goes on.
#include <filesystem>
#include <iostream>
#include <system_error>
#include <thread>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/resource.h>

#include "base/processors.h"
#include "base/thread_pool.h"
#include "protocol/messages.h"
#include "tests/server/net/clients.h"
#include "tests/support/eventually.h"
#include "tests/support/metrics_page.h"
#include "tests/support/process_status.h"
#include "tests/support/server_process.h"

namespace seaway {
namespace {

class Scarcity : public ::testing::Test {
  protected:
    Scarcity()
        : server({"scenes/north_sea_gale.toml", "--device", "native", "--listen", "127.0.0.1:0"}) {
        const std::string url = server.wait_until_ready();
        EXPECT_FALSE(url.empty()) << server.log();
        port = tests::port_of(url);
    }

    void TearDown() override {
        if (!HasFailure())
            return;
        const auto code = server.wait_for_exit(std::chrono::seconds(1));
        std::cout << server.log()
                  << (code ? fmt::format("it ended with {}\n", *code) : "it runs\n");
    }

    /// So much more than it has now.
    void may_take(std::size_t more_bytes) {
        const auto has_bytes = static_cast<rlim_t>(tests::memory_bytes(server.pid(), "VmSize"));
        const rlimit limit{has_bytes + more_bytes, RLIM_INFINITY};
        ASSERT_EQ(prlimit(server.pid(), RLIMIT_AS, &limit, nullptr), 0);
    }
    void may_take_all() {
        const rlimit none{RLIM_INFINITY, RLIM_INFINITY};
        ASSERT_EQ(prlimit(server.pid(), RLIMIT_AS, &none, nullptr), 0);
    }
    /// 0 where there is none yet.
    double metric(const std::string& name) {
        return tests::read_metrics(tests::ask_http(port, "/metrics", "GET").body).values[name];
    }
    /// A client that comes now is served, and the server ends when it is asked to.
    void serves_on() {
        const sea::QueryPoint point{1, 2, 3'000'000};
        bool answered = false;
        for (int i = 0; i < 100 && !answered; ++i) {
            tests::Client client(port);
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
        std::vector<std::unique_ptr<tests::Client>> crowd;
        may_take(more_mib << 20);
        for (int i = 0; i < 12; ++i) {
            // Without memory it may be told nothing, for as long as that lasts.
            auto client = std::make_unique<tests::Client>(port, "", std::chrono::seconds(5));
            if (client->connect() || !client->greet())
                continue; // it may be this one for which there is no memory
            std::vector<sea::QueryPoint> points(4096);
            for (std::size_t p = 0; p < points.size(); ++p)
                points[p] = {1.0 * static_cast<double>(p), 2.0 * i, (60 + i) * 1'000'000LL};
            for (std::uint32_t id = 1; id <= 16; ++id)
                (void)client->send(protocol::query(id, points, false));
            const sea::TimeUs times[] = {i * 3'600'000'000LL, i * 7'200'000'000LL};
            (void)client->send(protocol::fetch(17, times, {.fields = sea::all_fields}));
            (void)client->send(protocol::subscribe(18, {.fields = sea::all_fields}, 8));
            // Each is encoded anew, for which zstd asks the system for some megabytes by itself.
            (void)client->send(protocol::subscribe_spectrum(
                19, {.error_m = 0.02f * static_cast<float>(i + 1), .slope_error = 0.05f}));
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
    EXPECT_TRUE(tests::eventually([&] {
        status = tests::ask_http(port, map, "GET").status;
        return status != 503;
    }));
    EXPECT_EQ(status, 200);
    serves_on();
}

/// This thread, and what it starts, has so many of its processors at most until the scope ends.
class FewProcessors {
  public:
    explicit FewProcessors(int most) {
        if (::sched_getaffinity(0, sizeof before_, &before_) != 0)
            return; // a machine of more than 1024
        known_ = true;
        cpu_set_t few = before_;
        for (int cpu = CPU_SETSIZE - 1; cpu >= 0 && CPU_COUNT(&few) > most; --cpu)
            CPU_CLR(cpu, &few);
        EXPECT_EQ(::sched_setaffinity(0, sizeof few, &few), 0);
    }
    ~FewProcessors() {
        if (known_) {
            EXPECT_EQ(::sched_setaffinity(0, sizeof before_, &before_), 0);
        }
    }
    FewProcessors(const FewProcessors&) = delete;
    FewProcessors& operator=(const FewProcessors&) = delete;

  private:
    cpu_set_t before_{};
    bool known_ = false;
};

// Limits of processes do not hold for root, who becomes somebody else first; with nobody else's processes to count, each
// limit is met by another of the threads that a start makes. Others have processes enough to be over a limit of one.
TEST(Threads, a_start_that_gets_too_few_says_so_and_ends_with_exit_code_2) {
    const bool is_root = geteuid() == 0;
    // A start makes a dozen, and as many as there are processors: those of a large machine would be of one kind, and a start each.
    const FewProcessors few(4);
    const int most = is_root ? 64 + usable_processors() : 1;
    int refused = 0;
    bool served = false;
    for (int limit = 1; limit <= most && !served; ++limit) {
        std::vector<std::string> words;
        if (is_root)
            words = {"--ruid=61234", "--bounding-set=-sys_resource,-sys_admin", "prlimit"};
        words.insert(words.end(), {"--nproc=" + std::to_string(limit),
                                   std::string(SEAWAY_BIN_DIR) + "/seaway-server",
                                   "scenes/calm.toml", "--device", "native", "--listen",
                                   "127.0.0.1:0", "--answer-threads", "2", "--io-threads", "3"});
        tests::ServerProcess server(words, -1, is_root ? "/usr/bin/setpriv" : "/usr/bin/prlimit");
        served = !server.wait_until_ready().empty();
        if (served) {
            server.send(SIGTERM);
            EXPECT_EQ(server.wait_for_exit(std::chrono::seconds(30)), 0) << server.log();
            break;
        }
        EXPECT_EQ(server.wait_for_exit(std::chrono::seconds(30)), 2) << limit << server.log();
        EXPECT_NE(server.log().find("the system gives it no further thread"), std::string::npos)
            << limit << server.log();
        ++refused;
    }
    EXPECT_GE(refused, is_root ? 8 : 1) << "a server has more threads than that";
    EXPECT_EQ(served, is_root) << "enough are enough";
}

// Threads that nobody joins end the process. A stack takes 8 MiB of addresses.
TEST(Threads, a_pool_that_gets_too_few_leaves_none_behind) {
    const auto has_bytes = static_cast<rlim_t>(tests::memory_bytes(getpid(), "VmSize"));
    rlimit before{};
    ASSERT_EQ(getrlimit(RLIMIT_AS, &before), 0);
    const rlimit limit{has_bytes + (512u << 20), before.rlim_max};
    ASSERT_EQ(setrlimit(RLIMIT_AS, &limit), 0);
    EXPECT_THROW(ThreadPool(1000), std::system_error);
    ASSERT_EQ(setrlimit(RLIMIT_AS, &before), 0);
    EXPECT_EQ(ThreadPool(4).threads(), 4);
}

} // namespace
} // namespace seaway
