// SPDX-License-Identifier: Apache-2.0
// A connection over TLS whose owner goes while something is under way. Asio's operations refer to OpenSSL's stream until they
// have called back: an end that they meet later is one of memory that was given back.
#include <atomic>
#include <vector>

#include <dlfcn.h>
#include <gtest/gtest.h>

#include "tests/sockets/tls_pair.h"

namespace {
std::atomic<int> streams_freed = 0;
}

/// In place of OpenSSL's own, for this program.
extern "C" void SSL_free(SSL* stream) {
    using Free = void (*)(SSL*);
    static const auto real = reinterpret_cast<Free>(dlsym(RTLD_NEXT, "SSL_free"));
    streams_freed += stream != nullptr ? 1 : 0;
    real(stream);
}

namespace seaway::sockets {
namespace {

namespace asio = boost::asio;

/// More than two sockets of loopback hold.
const std::vector<std::uint8_t> more_than_is_taken(32 << 20, 'm');

// The order of a subscriber that goes silent: his keyframe is stuck, a ping waits behind it, and the one who is told that
// the write has failed is the last that owns the connection.
TEST(TlsEnds, the_stream_lives_until_the_last_of_what_was_written_has_ended) {
    TlsPair pair;
    std::shared_ptr<Socket> owner = std::move(pair.server);
    owner->write_whole();
    int freed_at_the_last = -1;
    bool first_failed = false;
    const std::vector<std::uint8_t> ping(2);
    owner->write_all({asio::buffer(more_than_is_taken)},
                     Socket::Bytes([&, held = owner](error_code error, std::size_t) {
                         first_failed = static_cast<bool>(error);
                     }));
    owner->write_all({asio::buffer(ping)}, Socket::Bytes([&](error_code error, std::size_t) {
                         EXPECT_TRUE(error);
                         freed_at_the_last = streams_freed;
                     }));
    pair.io.run_for(std::chrono::milliseconds(50)); // both ends' buffers are full
    const int freed_before = streams_freed;
    owner->close();
    owner.reset(); // the write that is under way is the last who has it
    pair.run_until([&] { return freed_at_the_last >= 0; });
    EXPECT_TRUE(first_failed);
    EXPECT_EQ(freed_at_the_last, freed_before) << "it was freed below an operation";
    pair.io.poll();
    EXPECT_EQ(streams_freed, freed_before + 1) << "and goes with the last of them";
}

// Nobody owns a pong: it is on its way, whole or in part, when the connection is given up.
TEST(TlsEnds, the_stream_lives_until_a_frame_that_nobody_owns_has_ended) {
    TlsPair pair;
    bool told = false;
    pair.server->write_whole();
    pair.server->write_all({asio::buffer(more_than_is_taken)},
                           Socket::Bytes([&told](error_code, std::size_t) { told = true; }));
    pair.io.run_for(std::chrono::milliseconds(50));
    const int freed_before = streams_freed;
    pair.server.reset();
    EXPECT_EQ(streams_freed, freed_before) << "while it is under way";
    pair.run_until([&] { return told; });
    pair.io.poll();
    EXPECT_EQ(streams_freed, freed_before + 1);
}

TEST(TlsEnds, the_stream_lives_until_a_handshake_and_what_is_received_have_ended) {
    TlsPair pair;
    using asio::ip::tcp;
    tcp::acceptor acceptor(pair.io, {asio::ip::address_v4::loopback(), 0});
    tcp::socket near(pair.io), far(pair.io);
    near.connect(acceptor.local_endpoint());
    acceptor.accept(far);
    auto shaking = std::make_unique<Socket>(std::move(far), pair.server_context);
    int ended = 0;
    shaking->accept_tls([&](error_code error) { ended += error ? 1 : 0; });
    pair.server->write_whole();
    pair.server->receive(
        [&](error_code error, std::span<std::uint8_t>) { ended += error ? 1 : 0; });
    pair.io.run_for(std::chrono::milliseconds(20));
    const int freed_before = streams_freed;
    shaking.reset();
    pair.server.reset();
    EXPECT_EQ(streams_freed, freed_before) << "while they are under way";
    pair.run_until([&] { return ended == 2; });
    pair.io.poll();
    EXPECT_EQ(streams_freed, freed_before + 2);
}

// The loop goes before what it has under way: nothing is called, and everything is given back.
TEST(TlsEnds, what_is_under_way_ends_with_its_loop) {
    const int freed_before = streams_freed;
    const auto held = std::make_shared<int>(0);
    {
        TlsPair pair;
        pair.server->write_whole();
        for (int i = 0; i < 3; ++i)
            pair.server->write_all({asio::buffer(more_than_is_taken)},
                                   Socket::Bytes([held](error_code, std::size_t) {}));
        pair.io.run_for(std::chrono::milliseconds(20));
    }
    EXPECT_EQ(held.use_count(), 1);
    EXPECT_EQ(streams_freed, freed_before + 4)
        << "two ends, and for each one that was tried before";
}

} // namespace
} // namespace seaway::sockets
