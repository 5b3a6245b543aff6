// SPDX-License-Identifier: Apache-2.0
// Both ends of a TLS connection over loopback, behind their handshake.
#pragma once

#include <memory>
#include <optional>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <gtest/gtest.h>
#include <openssl/evp.h>
#include <openssl/ssl.h>
#include <openssl/x509v3.h>

#include "sockets/socket.h"

namespace seaway::sockets {

/// The server's has a certificate of an hour for 127.0.0.1, and the client's trusts it.
inline void make_certificate(boost::asio::ssl::context& server, boost::asio::ssl::context& client) {
    const std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)> key(EVP_EC_gen("P-256"),
                                                                  EVP_PKEY_free);
    const std::unique_ptr<X509, decltype(&X509_free)> x509(X509_new(), X509_free);
    X509_set_version(x509.get(), 2); // of X.509 v3
    ASN1_INTEGER_set(X509_get_serialNumber(x509.get()), 1);
    X509_gmtime_adj(X509_getm_notBefore(x509.get()), -60);
    X509_gmtime_adj(X509_getm_notAfter(x509.get()), 3600);
    X509_set_pubkey(x509.get(), key.get());
    X509_EXTENSION* const name =
        X509V3_EXT_conf_nid(nullptr, nullptr, NID_subject_alt_name, "IP:127.0.0.1");
    X509_add_ext(x509.get(), name, -1);
    X509_EXTENSION_free(name);
    X509_sign(x509.get(), key.get(), EVP_sha256());
    SSL_CTX_use_certificate(server.native_handle(), x509.get());
    SSL_CTX_use_PrivateKey(server.native_handle(), key.get());
    X509_STORE_add_cert(SSL_CTX_get_cert_store(client.native_handle()), x509.get());
}

struct TlsPair {
    TlsPair() {
        using boost::asio::ip::tcp;
        make_certificate(server_context, client_context);
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
