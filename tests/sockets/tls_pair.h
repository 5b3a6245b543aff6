// SPDX-License-Identifier: Apache-2.0
// Both ends of a TLS connection over loopback, behind their handshake.
#pragma once

#include <memory>
#include <optional>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <gtest/gtest.h>

#include "sockets/socket.h"
#include "tests/support/certificate.h"

namespace seaway::sockets {

struct TlsPair {
    TlsPair() {
        using boost::asio::ip::tcp;
        const tests::Certificate own; // which the client trusts
        server_context.use_certificate_chain_file(own.cert_file);
        server_context.use_private_key_file(own.key_file, boost::asio::ssl::context::pem);
        client_context.load_verify_file(own.cert_file);
        tcp::acceptor acceptor(io, {boost::asio::ip::address_v4::loopback(), 0});
        tcp::socket near(io), far(io);
        near.connect(acceptor.local_endpoint());
        acceptor.accept(far);
        server = std::make_unique<Socket>(std::move(far), server_context);
        client = std::make_unique<Socket>(std::move(near), client_context);
        int shaken = 0;
        const auto count = [&shaken](error_code error) {
            EXPECT_FALSE(error) << error.message();
            ++shaken;
        };
        server->accept_tls(count);
        client->connect_tls("127.0.0.1", count);
        run_until([&] { return shaken == 2; });
    }
    template <class Condition>
    void run_until(Condition condition) {
        io.restart();
        const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
        while (!condition() && io.run_one_until(deadline) > 0)
            continue;
        EXPECT_TRUE(condition());
    }

    boost::asio::ssl::context server_context{boost::asio::ssl::context::tls_server};
    boost::asio::ssl::context client_context{boost::asio::ssl::context::tls_client};
    boost::asio::io_context io;
    std::unique_ptr<Socket> server, client;
};

} // namespace seaway::sockets
