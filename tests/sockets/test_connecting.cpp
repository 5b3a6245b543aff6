// SPDX-License-Identifier: Apache-2.0
// Names with several addresses, some of which say nothing.
#include <array>
#include <memory>
#include <vector>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/error.hpp>
#include <gtest/gtest.h>
#include <sys/socket.h>

#include "sockets/connecting.h"
#include "sockets/name_lookup.h"
#include "sockets/socket.h"

namespace seaway::sockets {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;

/// An address at which nobody answers, neither yes nor no: its listener takes nobody, and has no room for one more.
class Silent {
  public:
    explicit Silent(asio::io_context& io) : listener_(io, tcp::v4()) {
        listener_.bind({asio::ip::address_v4::loopback(), 0});
        listener_.listen(0);
        for (auto& one : waiting_) {
            one = std::make_unique<tcp::socket>(io, tcp::v4());
            one->native_non_blocking(true); // Asio would wait
            const tcp::endpoint there = endpoint();
            ::connect(one->native_handle(), there.data(), there.size());
        }
    }
    tcp::endpoint endpoint() const { return listener_.local_endpoint(); }

  private:
    tcp::acceptor listener_;
    std::array<std::unique_ptr<tcp::socket>, 3> waiting_;
};

class ConnectingTest : public ::testing::Test {
  protected:
    void connect(const std::vector<tcp::endpoint>& endpoints,
                 std::chrono::milliseconds patience = std::chrono::seconds(20)) {
        socket.expires_after(patience);
        socket.connect(Socket::Endpoints::create(endpoints.begin(), endpoints.end(), "name", "1"),
                       [this](error_code error) { ends.push_back(error); });
    }
    void run() {
        io.restart();
        const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(40);
        while (ends.empty() && io.run_one_until(deadline) > 0)
            continue;
        io.poll();
        ASSERT_EQ(ends.size(), 1u);
    }
    /// Nobody listens there.
    tcp::endpoint closed() {
        tcp::acceptor acceptor(io, {asio::ip::address_v4::loopback(), 0});
        return acceptor.local_endpoint();
    }

    asio::io_context io;
    Socket socket{tcp::socket(io)};
    tcp::acceptor server{io, {asio::ip::address_v4::loopback(), 0}};
    std::vector<error_code> ends;
};

TEST_F(ConnectingTest, an_address_that_says_nothing_does_not_keep_the_next_from_being_tried) {
    const Silent silent(io), silent_too(io);
    connect({silent.endpoint(), silent_too.endpoint(), server.local_endpoint()});
    run();
    EXPECT_FALSE(ends[0]) << ends[0].message();
    tcp::socket far(io);
    server.accept(far);
    std::array<char, 1> byte{'x'};
    far.send(asio::buffer(byte));
    bool there = false;
    socket.async_read_some(asio::buffer(byte),
                           [&](error_code error, std::size_t) { there = !error; });
    io.restart();
    io.run_for(std::chrono::seconds(5));
    EXPECT_TRUE(there) << "it is the socket that is read from";
}

TEST_F(ConnectingTest, an_address_that_refuses_is_followed_by_the_next) {
    connect({closed(), server.local_endpoint()});
    run();
    EXPECT_FALSE(ends[0]) << ends[0].message();
}

TEST_F(ConnectingTest, where_all_refuse_it_is_said_why) {
    connect({closed(), closed()});
    run();
    EXPECT_EQ(ends[0], asio::error::connection_refused);
}

TEST_F(ConnectingTest, where_one_refuses_the_silent_one_is_waited_for_as_long_as_all_have) {
    const Silent silent(io);
    connect({silent.endpoint(), closed()}, std::chrono::milliseconds(600));
    run();
    EXPECT_EQ(ends[0], boost::beast::error::timeout);
}

TEST_F(ConnectingTest, what_is_closed_while_it_connects_ends_with_an_error_and_stays_closed) {
    connect({server.local_endpoint()});
    io.poll(); // it is connected already, which nobody has been told
    socket.close();
    if (ends.empty())
        run();
    EXPECT_EQ(socket.descriptor(), -1);
}

TEST_F(ConnectingTest, who_gives_up_a_silent_address_is_told_so_at_once) {
    const Silent silent(io);
    connect({silent.endpoint()});
    io.poll();
    socket.close();
    EXPECT_TRUE(ends.empty()) << "never within the call";
    run();
    EXPECT_EQ(ends[0], asio::error::operation_aborted);
}

TEST_F(ConnectingTest, addresses_are_known_without_asking_anybody_and_names_are_asked_for) {
    for (const std::string host : {"127.0.0.1", "::1", "127.1"}) {
        std::optional<Result<NameLookup::Endpoints>> found;
        NameLookup lookup(io);
        const auto guard = asio::make_work_guard(io);
        lookup.begin(host, "9430", [&](const auto& endpoints) { found = endpoints; });
        EXPECT_FALSE(found) << "never within the call";
        io.restart();
        while (!found && io.run_one_for(std::chrono::seconds(20)) > 0)
            continue;
        ASSERT_TRUE(found && *found) << host;
        EXPECT_EQ((*found)->begin()->endpoint().port(), 9430);
        EXPECT_TRUE((*found)->begin()->endpoint().address().is_loopback());
    }
}

TEST_F(ConnectingTest, who_asked_for_a_name_and_is_gone_is_not_told) {
    int told = 0;
    {
        NameLookup lookup(io);
        lookup.begin("127.0.0.1", "1", [&](const auto&) { ++told; });
    }
    io.restart();
    io.poll();
    EXPECT_EQ(told, 0);
}

} // namespace
} // namespace seaway::sockets
