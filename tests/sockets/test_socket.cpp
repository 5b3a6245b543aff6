// SPDX-License-Identifier: Apache-2.0
#include "sockets/socket.h"

#include <array>
#include <string>
#include <vector>

#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <gtest/gtest.h>

#include "tests/sockets/pair.h"

namespace seaway::sockets {
namespace {

namespace asio = boost::asio;

// Beast hands over frames and headers as sequences of buffers, some of them empty. A call of the system
// takes some of them, and none taken would mean the end.
TEST(Socket, sequences_of_any_number_of_buffers_arrive_whole_and_in_order) {
    Pair pair;
    std::vector<std::string> parts(20);
    for (int i = 0; i < 100; ++i)
        parts.push_back(i % 7 == 0 ? std::string() : std::to_string(i) + ",");
    std::string sent;
    std::vector<asio::const_buffer> buffers;
    for (const std::string& part : parts) {
        sent += part;
        buffers.push_back(asio::buffer(part));
    }
    std::string received(sent.size(), '\0');
    std::size_t written = 0;
    asio::async_write(*pair.ends[0], buffers,
                      [&](error_code, std::size_t bytes) { written = bytes; });
    asio::async_read(*pair.ends[1], asio::buffer(received), [](error_code, std::size_t) {});
    pair.run();
    EXPECT_EQ(written, sent.size());
    EXPECT_EQ(received, sent);

    std::size_t once = 0; // of one call, too, empty ones in front are no end
    pair.ends[0]->async_write_some(buffers, [&](error_code, std::size_t bytes) { once = bytes; });
    pair.run();
    EXPECT_GT(once, 0u);
}

TEST(Socket, what_waits_longer_than_allowed_ends_with_an_error_and_so_does_what_is_closed) {
    Pair pair;
    std::array<char, 8> bytes{};
    std::vector<error_code> ends;
    pair.ends[0]->expires_after(std::chrono::milliseconds(1));
    pair.ends[0]->async_read_some(asio::buffer(bytes),
                                  [&](error_code error, std::size_t) { ends.push_back(error); });
    pair.run();
    ASSERT_EQ(ends.size(), 1u);
    EXPECT_TRUE(ends[0]);
    Pair other;
    other.ends[0]->async_read_some(asio::buffer(bytes),
                                   [&](error_code error, std::size_t) { ends.push_back(error); });
    other.ends[0]->close();
    other.run();
    ASSERT_EQ(ends.size(), 2u);
    EXPECT_EQ(ends[1], asio::error::operation_aborted);
}

TEST(Completion, a_handler_that_is_never_called_is_destroyed) {
    const auto held = std::make_shared<int>(1);
    {
        const Completion<int> forgotten([held](int) {});
    }
    EXPECT_EQ(held.use_count(), 1);
    int sum = 0;
    Completion<int> called([&sum, held](int value) { sum += value + *held; });
    called(2);
    EXPECT_EQ(sum, 3);
    EXPECT_EQ(held.use_count(), 1) << "what it held goes with the call";
}

} // namespace
} // namespace seaway::sockets
