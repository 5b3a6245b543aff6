// SPDX-License-Identifier: Apache-2.0
// A connection for which OpenSSL has no memory. Naive: Asio goes on with none, which is a crash, or throws what nobody catches.
#include <atomic>
#include <new>

#include <dlfcn.h>

#include <boost/asio/ssl/context.hpp>
#include <gtest/gtest.h>

#include "tests/sockets/pair.h"

namespace {
std::atomic<bool> none_is_left = false;
}

/// In place of OpenSSL's own, for this program.
extern "C" SSL* SSL_new(SSL_CTX* context) {
    using New = SSL* (*)(SSL_CTX*);
    static const auto real = reinterpret_cast<New>(dlsym(RTLD_NEXT, "SSL_new"));
    return none_is_left ? nullptr : real(context);
}

namespace seaway::sockets {
namespace {

TEST(SocketOfTls, that_there_is_no_memory_for_says_so_and_the_next_one_is_made) {
    boost::asio::io_context io;
    boost::asio::ssl::context tls(boost::asio::ssl::context::tls_server);
    const auto made = [&] { return Socket(boost::asio::ip::tcp::socket(io), tls).has_tls(); };
    none_is_left = true;
    EXPECT_THROW(made(), std::bad_alloc);
    none_is_left = false;
    EXPECT_TRUE(made());
}

} // namespace
} // namespace seaway::sockets
