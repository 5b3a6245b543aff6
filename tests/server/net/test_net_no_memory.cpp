// SPDX-License-Identifier: Apache-2.0
// The network's thread where it is given no memory, at each place at which it asks for some: what that befalls ends, and
// nothing of it stays. Core and connections are the server's; their thread is the test's, which memory can be kept from.
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <functional>
#include <memory>
#include <new>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <boost/asio/post.hpp>
#include <gtest/gtest.h>

#include "server/net/connection.h"
#include "server/net/fetch_job.h"
#include "server/net/session.h"
#include "sockets/upgrade.h"
#include "tests/server/net/net_fixture.h"
#include "tests/sockets/client_frames.h"
#include "tests/sockets/pair.h"
#include "tests/support/allocations.h"
#include "tests/support/eventually.h"

namespace seaway::tests {
namespace {

constexpr std::size_t all_there_is = 1'000'000; ///< as NoMemoryOnce: never

/// A server's network thread by hand, and a connection of which it has one end.
class ThreadByHand {
  public:
    explicit ThreadByHand(const server::NetOptions& options = {})
        : core(std::make_shared<server::Core>(options, sea, [this](server::Core::Work work) {
              boost::asio::post(pair.io, std::move(work));
          })) {
        heard.reserve(512 * 1024);
    }
    /// As a server ends.
    ~ThreadByHand() {
        core->detach();
        core->map_places.stop();
        core->waiting_for_maps.clear();
        core->turns.clear();
        core->disposal.stop();
    }
    ThreadByHand(const ThreadByHand&) = delete;
    ThreadByHand& operator=(const ThreadByHand&) = delete;

    server::ConnectionSlot slot() { return {core, core->door, peer.address}; }
    sockets::Socket near() { return std::move(*pair.ends[0]); }

    /// As the server's loop does: what there is no memory for is lost.
    template <class Work>
    void run(const Work& work) {
        try {
            work();
        } catch (const std::bad_alloc&) {
            ++failed;
        }
    }
    /// What is ready, and what the peer is told.
    void turn() {
        run([this] {
            pair.io.restart();
            pair.io.poll();
        });
        std::array<char, 16 * 1024> some;
        const auto bytes =
            ended ? 0 : ::recv(far(), some.data(), some.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
        if (bytes > 0)
            heard.append(some.data(), static_cast<std::size_t>(bytes)); // there is room
        else if (bytes == 0 || (errno != EAGAIN && errno != EINTR))
            ended = true;
    }
    /// False: not within a minute, as long as a crowded machine may need.
    template <class Condition>
    bool comes(const Condition& condition) {
        const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
        while (!condition()) {
            if (std::chrono::steady_clock::now() > end)
                return false;
            turn();
            std::this_thread::sleep_for(std::chrono::microseconds(100));
        }
        return true;
    }
    /// Nothing is left of any connection.
    bool is_clear() const {
        return core->door.connections == 0 && core->sessions.empty() &&
               core->waiting_for_maps.empty() && *sea.maps_alive == 0;
    }
    int far() const { return pair.ends[1]->descriptor(); }

    LogCapture log;
    SmallSea sea;
    sockets::Pair pair; ///< outlives the core, and is outlived by the sea of what waits there
    std::shared_ptr<server::Core> core;
    server::Peer peer{"test", std::make_shared<server::Address>("test", server::NetOptions{}), true,
                      false};
    std::string heard;
    bool ended = false;
    int failed = 0;
};

// ---- sessions ------------------------------------------------------------------------------

class NobodysLink final : public server::Link {
  public:
    void send_more() override {}
    void drop() noexcept override {}
    void close(protocol::SharedBytes, wire::ErrorCode, const std::string&) override {}
};

// Naive: it is taken out of the table of sessions behind something that needs memory; it ends once, and whoever looks there next finds
// what is gone.
TEST(NetNoMemory, a_session_that_ends_is_found_by_nobody_afterwards) {
    int failed = 0;
    for (const bool subscribed : {false, true})
        for (std::size_t after = 0; after < 12; ++after) {
            ThreadByHand server;
            server.sea.answer_fetches = false;
            NobodysLink link;
            auto session = std::make_unique<server::Session>(*server.core, link, server.peer,
                                                             server::Standing::stranger);
            const server::SessionId id = session->id();
            session->receive(protocol::hello("test", ""));
            if (subscribed)
                session->receive(protocol::subscribe(1, heights, 3));
            ASSERT_EQ(server.core->find(id), session.get());
            ASSERT_EQ(server.sea.subscriptions().size(), subscribed ? 1u : 0u);
            try {
                const NoMemoryOnce none(after);
                session->end("test", "there is no memory for it");
            } catch (const std::bad_alloc&) {
                ++failed;
            }
            EXPECT_TRUE(session->ended());
            EXPECT_EQ(server.core->find(id), nullptr) << after;
            EXPECT_EQ(server.sea.subscriptions().size(), 0u) << after;
        }
    EXPECT_GT(failed, 0);
}

// ---- fetches -------------------------------------------------------------------------------

/// A fetch, and what its session is told, where there is memory for that.
struct ToldFetch {
    ThreadByHand thread;
    bool memory = false;
    std::vector<Error> told;
    std::shared_ptr<server::FetchJob> job = std::make_shared<server::FetchJob>(
        thread.core, heights.fields, false, server::Asker::who_stays(),
        [this](const Result<server::FetchedTiles>& tiles) {
            if (!memory)
                throw std::bad_alloc();
            ASSERT_FALSE(tiles);
            told.push_back(tiles.error());
        });
};

// Naive: the end that could not be told was the end.
TEST(NetNoMemory, a_fetch_whose_end_could_not_be_told_is_told_the_next_one_and_that_alone) {
    ToldFetch fetch;
    const Error gone{server::Refusal::gone, "nobody waits for the answer"};
    EXPECT_THROW(fetch.job->bring(gone), std::bad_alloc);
    EXPECT_TRUE(fetch.job->asker().gone()) << "nothing more is worked on for it";
    fetch.memory = true;
    fetch.job->bring(gone);
    ASSERT_EQ(fetch.told.size(), 1u);
    EXPECT_TRUE(fetch.told[0].is(server::Refusal::busy)) << "its session is still there";
    fetch.job->bring(gone);
    fetch.job.reset();
    EXPECT_EQ(fetch.told.size(), 1u);
}

TEST(NetNoMemory, a_fetch_whose_end_could_not_be_told_is_told_when_it_is_given_up) {
    ToldFetch fetch;
    EXPECT_THROW(fetch.job->bring(Error{server::Refusal::busy, "later"}), std::bad_alloc);
    fetch.memory = true;
    fetch.job.reset();
    ASSERT_EQ(fetch.told.size(), 1u);
    EXPECT_TRUE(fetch.told[0].is(server::Refusal::busy));
}

// ---- connections ---------------------------------------------------------------------------

/// A map from the first byte to the last, each piece of it in several writes. How often memory was asked for.
std::size_t serve_a_map(ThreadByHand& server, std::size_t after) {
    server.sea.map_piece_bytes = 150 * 1024;
    server.sea.map_bytes_all = 2 * server.sea.map_piece_bytes;
    const Allocations asked;
    const NoMemoryOnce none(after);
    server.run([&] { server::serve_map(server.slot(), server.near(), server.peer, {}); });
    EXPECT_TRUE(server.comes([&] { return server.ended; })) << "the peer waits for ever: " << after;
    return asked.count();
}

// Naive: a map that could not begin, or whose header or rows could not be sent, keeps its place until the peer leaves.
TEST(NetNoMemory, a_map_ends_where_there_is_no_memory_for_it_and_its_place_comes_back) {
    std::size_t steps = 0;
    {
        ThreadByHand server;
        steps = serve_a_map(server, all_there_is);
        EXPECT_TRUE(server.heard.starts_with("HTTP/1.1 200"));
        EXPECT_TRUE(server.heard.ends_with(std::string(server.sea.map_bytes_all, 'm')));
    }
    int failed = 0;
    for (std::size_t after = 0; after < steps; ++after) {
        ThreadByHand server;
        serve_a_map(server, after);
        ASSERT_FALSE(testing::Test::HasFailure());
        failed += server.failed;
        ASSERT_TRUE(server.comes([&] { return server.is_clear(); })) << after;
        std::vector<server::MapPlaces::Place> places;
        for (int i = 0; i < server::maps_at_once_max; ++i)
            EXPECT_TRUE(server.core->map_places.ask(
                server.peer.address,
                [&](server::MapPlaces::Place place) { places.push_back(std::move(place)); },
                [] { return true; }));
        EXPECT_TRUE(server.comes([&] { return places.size() == server::maps_at_once_max; }))
            << after;
    }
    EXPECT_GT(failed, 20);
}

/// Behind its handshake.
void serve_a_stream(ThreadByHand& server) {
    namespace http = boost::beast::http;
    sockets::Upgrade upgrade{{http::verb::get, "/", 11}};
    upgrade.request.set(http::field::host, "here");
    upgrade.request.set(http::field::upgrade, "websocket");
    upgrade.request.set(http::field::connection, "Upgrade");
    upgrade.request.set(http::field::sec_websocket_version, "13");
    upgrade.request.set(http::field::sec_websocket_key, "dGhlIHNhbXBsZSBub25jZQ==");
    server::serve_stream(server.slot(), server.near(), upgrade, server.peer,
                         server::Standing::client);
    ASSERT_TRUE(server.comes([&] {
        return server.core->sessions.size() == 1 &&
               server.heard.find("\r\n\r\n") != std::string::npos;
    }));
}

/// Some messages in one arrival, and the end. How often memory was asked for.
std::size_t say_some(ThreadByHand& server, std::size_t after) {
    sockets::FrameBytes together;
    sockets::append_client_frame(together, protocol::hello("test", ""));
    for (std::uint32_t id = 1; id <= 3; ++id)
        sockets::append_client_frame(together, protocol::ping(id, 0));
    EXPECT_EQ(::send(server.far(), together.data(), together.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(together.size()));
    server.pair.ends[1]->shutdown_send();
    const Allocations asked;
    const NoMemoryOnce none(after);
    EXPECT_TRUE(server.comes([&] { return server.is_clear(); })) << after;
    return asked.count();
}

// Naive: one that has asked for the next message when there is no memory for the answers to the last ones is held by its own socket.
TEST(NetNoMemory, a_stream_ends_with_its_session_where_there_is_no_memory_for_it) {
    std::size_t steps = 0;
    server::NetOptions options;
    options.hello_deadline = std::chrono::minutes(5);
    {
        ThreadByHand server(options);
        serve_a_stream(server);
        steps = say_some(server, all_there_is);
        EXPECT_EQ(server.core->counters.messages_received, 4u);
        EXPECT_EQ(server.core->counters.messages_sent, 5u) << "Welcome, SeaState, three Pongs";
    }
    options.hello_deadline = std::chrono::milliseconds(500); // until then its timer may hold it
    int failed = 0;
    for (std::size_t after = 0; after < steps; ++after) {
        ThreadByHand server(options);
        serve_a_stream(server);
        say_some(server, after);
        ASSERT_FALSE(testing::Test::HasFailure());
        failed += server.failed;
    }
    EXPECT_GT(failed, 5);
}

} // namespace
} // namespace seaway::tests
