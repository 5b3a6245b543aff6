// SPDX-License-Identifier: Apache-2.0
// Servers that follow one log in NATS, as real programs on loopback, and what their pages say.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <thread>
#include <vector>

#include <arpa/inet.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <sys/socket.h>
#include <unistd.h>

#include "tests/server/change_bench.h"
#include "tests/support/nats_server.h"

namespace seaway::changes {

inline std::vector<std::string> arguments_of(const std::string& journal) {
    std::vector<std::string> words = arguments("");
    words[5] = "--journal";
    words[6] = journal;
    return words;
}

/// Body of a page, and whether it was 200.
struct Answer {
    bool fine;
    std::string body;
};

inline Answer get(const std::string& url, const std::string& path) {
    const int line = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(static_cast<std::uint16_t>(tests::port_of(url)));
    (void)connect(line, reinterpret_cast<sockaddr*>(&address), sizeof address);
    const std::string request = fmt::format("GET {} HTTP/1.1\r\nHost: 127.0.0.1\r\nAuthorization: "
                                            "Bearer {}\r\nConnection: close\r\n\r\n",
                                            path, token);
    (void)send(line, request.data(), request.size(), 0);
    std::string text;
    char buffer[4096];
    for (ssize_t count; (count = recv(line, buffer, sizeof buffer, 0)) > 0;)
        text.append(buffer, static_cast<std::size_t>(count));
    close(line);
    const std::size_t end = text.find("\r\n\r\n");
    return {text.find(" 200 ") < text.find("\r\n"),
            end == std::string::npos ? "" : text.substr(end + 4)};
}

inline nlohmann::json journal_of(const std::string& url) {
    return nlohmann::json::parse(get(url, "/v1/state").body)["journal"];
}

inline int times_in(const std::string& log, const std::string& words) {
    int count = 0;
    for (std::size_t at = 0; (at = log.find(words, at)) != std::string::npos; ++at)
        ++count;
    return count;
}

} // namespace seaway::changes
