// SPDX-License-Identifier: Apache-2.0
// Both ends of a connection over loopback.
#pragma once

#include <array>
#include <functional>
#include <memory>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <gtest/gtest.h>

#include "sockets/served_web_socket.h"
#include "sockets/socket.h"

namespace seaway::sockets {

struct Pair {
    Pair() {
        using boost::asio::ip::tcp;
        tcp::acceptor acceptor(io, {boost::asio::ip::address_v4::loopback(), 0});
        tcp::socket near(io), far(io);
        near.connect(acceptor.local_endpoint());
        acceptor.accept(far);
        ends = {std::make_unique<Socket>(std::move(near)),
                std::make_unique<Socket>(std::move(far))};
    }
    /// Until nothing is under way.
    void run() {
        io.restart();
        io.run_for(std::chrono::seconds(20));
    }
    boost::asio::io_context io;
    std::array<std::unique_ptr<Socket>, 2> ends;
};

/// What was begun, piece by piece to the end.
inline void finish(ServedWebSocket& socket, const std::function<void()>& done) {
    socket.finish([&socket, done](const Result<bool>& all) {
        ASSERT_TRUE(all) << all.error().message;
        if (*all)
            done();
        else
            finish(socket, done);
    });
}

} // namespace seaway::sockets
