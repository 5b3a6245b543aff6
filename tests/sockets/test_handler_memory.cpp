// SPDX-License-Identifier: Apache-2.0
// Room for the handlers that a server cannot go on without.
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <gtest/gtest.h>

#include "sockets/handler_memory.h"

namespace seaway::sockets {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;

struct Acceptor {
    asio::io_context io;
    tcp::acceptor acceptor{io, {asio::ip::address_v4::loopback(), 0}};
    HandlerMemoryPtr memory = std::make_shared<HandlerMemory>();

    template <class Taken>
    void accept(Taken taken) {
        acceptor.async_accept(
            with(memory, [taken](boost::system::error_code error, tcp::socket) { taken(error); }));
    }
};

TEST(HandlerMemory, holds_a_handler_until_it_is_called_which_may_await_the_next_one_there) {
    Acceptor server;
    int taken = 0;
    server.accept([&](boost::system::error_code error) {
        EXPECT_FALSE(error);
        EXPECT_FALSE(server.memory->in_use());
        ++taken;
        server.accept([&](boost::system::error_code) { ++taken; });
        EXPECT_TRUE(server.memory->in_use());
    });
    EXPECT_TRUE(server.memory->in_use());
    tcp::socket first(server.io), second(server.io);
    first.connect(server.acceptor.local_endpoint());
    second.connect(server.acceptor.local_endpoint());
    server.io.run();
    EXPECT_EQ(taken, 2);
    EXPECT_FALSE(server.memory->in_use());
}

// As by an exception of Asio's, which takes the handler along.
TEST(HandlerMemory, says_that_a_handler_is_gone_which_nobody_called) {
    HandlerMemoryPtr memory;
    {
        Acceptor server;
        memory = server.memory;
        server.accept([](boost::system::error_code) { ADD_FAILURE() << "nobody runs this"; });
        EXPECT_TRUE(memory->in_use());
    }
    EXPECT_FALSE(memory->in_use());
}

} // namespace
} // namespace seaway::sockets
