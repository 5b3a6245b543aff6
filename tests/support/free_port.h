// SPDX-License-Identifier: Apache-2.0
// A port of 127.0.0.1 for a server that is to come again where it was.
#pragma once

#include <cstdint>
#include <random>
#include <set>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

namespace seaway::tests {

/// One that nobody listens on now, given once by this process, and that stays so until a server is started on it, or started again: it
/// is below those that the system gives to who connects or asks for any (from 32768), or it would be somebody else's by then, and the
/// server would not start.
inline int free_port() {
    static std::mt19937 lots{std::random_device{}()};
    static std::set<int> given; // who was given one may listen on it later
    std::uniform_int_distribution<int> ports(12'000, 32'000);
    while (true) {
        const int port = ports(lots);
        if (given.contains(port))
            continue;
        const int socket_of = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        address.sin_port = htons(static_cast<std::uint16_t>(port));
        const bool is_free =
            bind(socket_of, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0;
        close(socket_of);
        if (is_free) {
            given.insert(port);
            return port;
        }
    }
}

} // namespace seaway::tests
