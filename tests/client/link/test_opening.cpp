// SPDX-License-Identifier: Apache-2.0
// Connections that do not come about: names that nobody knows in time or that have moved, servers that decline for a while.
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <stop_token>
#include <string>
#include <string_view>
#include <thread>

#include <dlfcn.h>
#include <gtest/gtest.h>
#include <netdb.h>
#include <sys/socket.h>
#include <unistd.h>

#include "client/client.h"
#include "client/link/failure.h"
#include "client/link/message_stream.h"
#include "protocol/limits.h"
#include "tests/client/wave_server.h"
#include "tests/support/eventually.h"
#include "tests/support/listener.h"

namespace {

/// Names for which the system asks and asks. Each test has its own: who asks for one that is being looked up waits for that.
constexpr std::string_view unanswered = ".never.answered.example";
struct Hanging {
    std::mutex mutex;
    std::condition_variable changed;
    bool released = false;
    int now = 0; ///< threads in it
};
Hanging& hanging() {
    static auto* const all = new Hanging; // threads may be in it when the program ends
    return *all;
}

/// A name that is another machine's, 127.0.0.2, from the second look at it on.
constexpr std::string_view moving = "moving.example";
std::atomic<int> looks_at_moving = 0;

} // namespace

/// In place of the system's, for this program.
extern "C" int getaddrinfo(const char* host, const char* port, const addrinfo* hints,
                           addrinfo** found) {
    using Ask = int (*)(const char*, const char*, const addrinfo*, addrinfo**);
    static const auto real = reinterpret_cast<Ask>(dlsym(RTLD_NEXT, "getaddrinfo"));
    if (host != nullptr && host == moving)
        return real(looks_at_moving++ == 0 ? "127.0.0.1" : "127.0.0.2", port, hints, found);
    if (host == nullptr || !std::string_view(host).ends_with(unanswered))
        return real(host, port, hints, found);
    Hanging& here = hanging();
    std::unique_lock lock(here.mutex);
    ++here.now;
    here.changed.notify_all();
    here.changed.wait_for(lock, std::chrono::seconds(20), [&] { return here.released; });
    --here.now;
    here.changed.notify_all();
    return EAI_AGAIN;
}

namespace seaway::client {
namespace {

class OpeningTest : public ::testing::Test {
  protected:
    OpeningTest() {
        const std::scoped_lock lock(hanging().mutex);
        hanging().released = false;
    }
    ~OpeningTest() override {
        Hanging& here = hanging();
        std::unique_lock lock(here.mutex);
        here.released = true;
        here.changed.notify_all();
        here.changed.wait_for(lock, std::chrono::seconds(30), [&] { return here.now == 0; });
    }
    static int still_asked() {
        const std::scoped_lock lock(hanging().mutex);
        return hanging().now;
    }
    /// A thread of its own asks, which on a busy machine may come to it when it has been given up already.
    static bool comes_to_ask() {
        return tests::eventually([] { return still_asked() > 0; });
    }
    static inline int tests_ = 0;
    const Url url{.host = std::to_string(++tests_) + std::string(unanswered), .port = "9430"};
};

// Naive: it is given up in time, and then waited for until the system has given up as well.
TEST_F(OpeningTest, a_name_that_the_system_does_not_find_is_given_up_before_the_system_does) {
    const auto stream = open_websocket(url, {.connect_timeout_s = 0.1});
    EXPECT_TRUE(comes_to_ask());
    EXPECT_EQ(still_asked(), 1) << "the system is still at it";
    ASSERT_FALSE(stream);
    EXPECT_EQ(failure_of(stream.error()), Failure::cannot_connect);
    EXPECT_NE(stream.error().message.find("the name was not found in 0.1 s"), std::string::npos)
        << stream.error().message;
}

// Naive: each attempt of a client that comes back leaves a thread behind, for as long as the system hangs.
TEST_F(OpeningTest, who_tries_again_and_again_waits_for_the_one_look_up_that_is_under_way) {
    for (int attempt = 0; attempt < 5; ++attempt) {
        EXPECT_FALSE(open_websocket(url, {.connect_timeout_s = 0.02}));
        EXPECT_TRUE(comes_to_ask());
        EXPECT_EQ(still_asked(), 1);
    }
}

TEST_F(OpeningTest, who_is_told_to_stop_does_not_wait_for_a_name) {
    std::stop_source stop;
    std::thread stops([&] {
        Hanging& here = hanging();
        std::unique_lock lock(here.mutex);
        here.changed.wait(lock, [&] { return here.now > 0; });
        stop.request_stop();
    });
    const auto stream = open_websocket(url, {.connect_timeout_s = 60, .stop = stop.get_token()});
    EXPECT_EQ(still_asked(), 1) << "the system is still at it";
    stops.join();
    ASSERT_FALSE(stream);
    EXPECT_NE(stream.error().message.find("given up by this client"), std::string::npos)
        << stream.error().message;
}

/// The port of one that answers the first request with these words.
class Declining {
  public:
    explicit Declining(std::string words) : words_(std::move(words)) {
        answers_ = std::thread([this] {
            const int peer = listener_.accept();
            std::string asked(4096, '\0');
            EXPECT_GT(::recv(peer, asked.data(), asked.size(), 0), 0);
            EXPECT_GT(::send(peer, words_.data(), words_.size(), 0), 0);
            ::close(peer);
        });
    }
    ~Declining() { answers_.join(); }
    Declining(const Declining&) = delete;
    Declining& operator=(const Declining&) = delete;
    int port() const { return listener_.port(); }

  private:
    const std::string words_;
    const tests::Listener listener_;
    std::thread answers_;
};

// Naive: it is back in half a second, whatever the server asked for.
TEST_F(OpeningTest, a_server_that_declines_for_a_while_is_left_for_that_long_and_an_hour_at_most) {
    for (const auto& [says, retry_after_ms] :
         {std::pair("7", 7000u), std::pair("86400", protocol::limits::retry_after_ms_max)}) {
        const Declining server(std::string("HTTP/1.1 503 Service Unavailable\r\nRetry-After: ") +
                               says + "\r\nContent-Length: 0\r\n\r\n");
        const auto stream =
            open_websocket({.host = "127.0.0.1", .port = std::to_string(server.port())},
                           {.connect_timeout_s = 60});
        ASSERT_FALSE(stream);
        EXPECT_EQ(failure_of(stream.error()), Failure::cannot_connect) << "which passes";
        EXPECT_EQ(stream.error().retry_after_ms, retry_after_ms);
    }
}

/// Of this name, at this address and port.
auto serve_moving(const std::string& at, server::Host& sea) {
    auto server =
        server::NetServer::start({.listen = at,
                                  .allowed_origins = {"http://" + std::string(moving)},
                                  .idle_timeout = std::chrono::minutes(5), // as tests::serve()
                                  .write_timeout = std::chrono::minutes(5)},
                                 sea);
    EXPECT_TRUE(server) << server.error().message;
    return std::move(*server);
}

// Naive: the address is looked up once, and who comes back calls a machine that has handed its name on.
TEST(Opening, who_comes_back_looks_its_name_up_anew) {
    for (const bool threadless : {false, true}) {
        looks_at_moving = 0;
        tests::WaveSea sea, sea_elsewhere;
        auto here = serve_moving("127.0.0.1:0", sea);
        const std::string port = std::to_string(here->port());
        const auto elsewhere = serve_moving("127.0.0.2:" + port, sea_elsewhere);
        const auto client = Client::connect({.url = "ws://" + std::string(moving) + ":" + port,
                                             .timeout_s = 60,
                                             .threadless = threadless});
        ASSERT_TRUE(client) << client.error().message;
        here.reset();
        EXPECT_TRUE(tests::eventually([&] {
            if (threadless)
                (*client)->work_until(std::chrono::steady_clock::now(), [] { return false; });
            return (*client)->status().connections == 2;
        })) << looks_at_moving
            << " looks";
    }
}

} // namespace
} // namespace seaway::client
