// SPDX-License-Identifier: Apache-2.0
// Takes calls on a free port of 127.0.0.1, and says nothing.
#pragma once

#include <chrono>

#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <gtest/gtest.h>

namespace seaway::tests {

class Listener {
  public:
    Listener() : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        EXPECT_EQ(::bind(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
        EXPECT_EQ(::listen(socket_, 8), 0);
    }
    ~Listener() { ::close(socket_); }
    Listener(const Listener&) = delete;
    Listener& operator=(const Listener&) = delete;

    int port() const {
        sockaddr_in address{};
        socklen_t size = sizeof address;
        ::getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &size);
        return ntohs(address.sin_port);
    }
    /// The line of the next who calls, which is the caller's to close; -1: nobody within so long.
    int accept(std::chrono::milliseconds patience = std::chrono::minutes(1)) const {
        pollfd calls{socket_, POLLIN, 0};
        const bool called = ::poll(&calls, 1, static_cast<int>(patience.count())) == 1;
        return called ? ::accept4(socket_, nullptr, nullptr, SOCK_CLOEXEC) : -1;
    }

  private:
    int socket_;
};

} // namespace seaway::tests
