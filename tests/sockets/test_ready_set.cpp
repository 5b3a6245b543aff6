// SPDX-License-Identifier: Apache-2.0
#include "sockets/ready_set.h"

#include <algorithm>
#include <deque>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/write.hpp>
#include <gtest/gtest.h>

namespace seaway::sockets {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;

/// Peers that have said more than one arrival holds, and a loop that has others to serve, too.
class ReadySetTest : public ::testing::Test {
  protected:
    /// What each of them has said lies there before anybody looks.
    void let_speak(std::size_t peers, std::size_t bytes) {
        tcp::acceptor acceptor(io, {asio::ip::address_v4::loopback(), 0});
        for (std::size_t i = 0; i < peers; ++i) {
            far.emplace_back(io).connect(acceptor.local_endpoint());
            near.emplace_back(io);
            acceptor.accept(near.back());
            asio::write(far.back(), asio::buffer(std::string(bytes, 'x')));
            receive(i, set.add(near.back().native_handle()));
        }
    }
    void receive(std::size_t peer, ReadySet::Id member) {
        ASSERT_FALSE(set.receive(
            member, [this, peer, member](ReadySet::error_code error, std::span<std::uint8_t>) {
                ASSERT_FALSE(error);
                arrived.push_back(peer);
                receive(peer, member);
            }));
    }
    /// The most arrivals between two turns of others, until there were so many.
    std::size_t most_at_once(std::size_t all) {
        std::size_t most = 0, before = 0;
        while (arrived.size() < all) {
            bool others = false;
            asio::post(io, [&] { others = true; });
            while (!others && io.run_one_for(std::chrono::seconds(20)) > 0)
                continue;
            if (!others) {
                ADD_FAILURE() << "nothing comes any more";
                break;
            }
            most = std::max(most, arrived.size() - std::exchange(before, arrived.size()));
        }
        return most;
    }

    asio::io_context io{1};
    ReadySet& set = asio::use_service<ReadySet>(io);
    std::deque<tcp::socket> near, far;
    std::vector<std::size_t> arrived; ///< whose
};

// Naive: sixteen full arrivals in one handler, each of which may be hundreds of messages.
TEST_F(ReadySetTest, who_says_much_ends_the_turn_and_nobody_has_a_second_before_all_have_had_one) {
    constexpr std::size_t peers = 20; // more than the system is asked for at a time
    let_speak(peers, 40'000);
    EXPECT_EQ(most_at_once(2 * peers), 1u);
    for (const std::size_t round : {0, 1}) {
        const auto from = arrived.begin() + static_cast<std::ptrdiff_t>(round * peers);
        EXPECT_EQ(std::set(from, from + peers).size(), peers) << round;
    }
}

TEST_F(ReadySetTest, of_those_who_say_little_many_have_one_turn) {
    let_speak(64, 60);
    EXPECT_EQ(most_at_once(64), 16u);
}

} // namespace
} // namespace seaway::sockets
