// SPDX-License-Identifier: Apache-2.0
#include "tests/server/net/tcp.h"

#include <algorithm>
#include <array>
#include <cerrno>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

namespace seaway::tests {
namespace {

using std::chrono::milliseconds;

std::error_code last_error() {
    return {errno, std::generic_category()};
}

} // namespace

Tcp::Tcp() : descriptor_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {}
Tcp::~Tcp() {
    close();
}

void Tcp::set(int option, const void* value, std::size_t size) {
    EXPECT_EQ(::setsockopt(descriptor_, SOL_SOCKET, option, value, static_cast<socklen_t>(size)),
              0);
}

std::error_code Tcp::connect(int port, const std::string& from) {
    sockaddr_in address{};
    if (!from.empty()) {
        address.sin_family = AF_INET;
        EXPECT_EQ(::inet_pton(AF_INET, from.c_str(), &address.sin_addr), 1);
        EXPECT_EQ(::bind(descriptor_, reinterpret_cast<const sockaddr*>(&address), sizeof address),
                  0);
    }
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (::connect(descriptor_, reinterpret_cast<const sockaddr*>(&address), sizeof address) < 0)
        return last_error();
    return {};
}

std::error_code Tcp::write(std::span<const std::uint8_t> bytes, milliseconds wait) {
    while (!bytes.empty()) {
        if (!ready(POLLOUT, Clock::now() + wait))
            return std::make_error_code(std::errc::timed_out);
        const auto sent =
            ::send(descriptor_, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
        if (sent >= 0)
            bytes = bytes.subspan(static_cast<std::size_t>(sent));
        else if (errno != EAGAIN && errno != EINTR)
            return last_error();
    }
    return {};
}

std::error_code Tcp::read(std::string& to, Clock::time_point end) {
    if (!ready(POLLIN, end))
        return std::make_error_code(std::errc::timed_out);
    std::array<char, 16384> some{};
    const auto received = ::recv(descriptor_, some.data(), some.size(), 0);
    if (received < 0)
        return last_error();
    if (received == 0)
        return std::make_error_code(std::errc::no_message_available);
    to.append(some.data(), static_cast<std::size_t>(received));
    return {};
}

void Tcp::close() {
    if (descriptor_ >= 0)
        ::close(descriptor_);
    descriptor_ = -1;
}

bool Tcp::ready(short what, Clock::time_point end) const {
    for (;;) {
        const auto left = std::chrono::ceil<milliseconds>(end - Clock::now());
        pollfd asked{descriptor_, what, 0};
        const int count =
            ::poll(&asked, 1, static_cast<int>(std::max<milliseconds::rep>(left.count(), 0)));
        if (count > 0)
            return true;
        if (count == 0)
            return false;
        EXPECT_EQ(errno, EINTR);
    }
}

} // namespace seaway::tests
