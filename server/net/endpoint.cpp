// SPDX-License-Identifier: Apache-2.0
#include "server/net/endpoint.h"

#include <cerrno>
#include <charconv>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/address.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <fmt/format.h>

namespace seaway::server {

using boost::asio::ip::tcp;

std::string Endpoint::text() const {
    return is_v6 ? fmt::format("[{}]:{}", ip, port) : fmt::format("{}:{}", ip, port);
}

Result<Endpoint> read_endpoint(const std::string& flag, const std::string& text) {
    const Error wrong{fmt::format("{} {}: not understood, expected ADDR:PORT with numbers, "
                                  "such as 127.0.0.1:9430, 0.0.0.0:9430 or [::]:9430",
                                  flag, text)};
    const std::size_t colon = text.rfind(':');
    if (colon == std::string::npos)
        return wrong;
    std::string host = text.substr(0, colon);
    const bool bracketed = host.size() > 2 && host.front() == '[' && host.back() == ']';
    if (bracketed)
        host = host.substr(1, host.size() - 2);
    else if (host.find(':') != std::string::npos)
        return wrong;
    unsigned port = 0;
    const char* begin = text.data() + colon + 1;
    const char* end = text.data() + text.size();
    const auto parsed = std::from_chars(begin, end, port);
    if (begin == end || parsed.ptr != end || parsed.ec != std::errc() || port > 65535)
        return wrong;
    boost::system::error_code error;
    const auto address = boost::asio::ip::make_address(host, error);
    if (error)
        return wrong;
    return Endpoint{address.to_string(), static_cast<int>(port), address.is_v6()};
}

Result<void> check_address(const std::string& flag, const Endpoint& endpoint) {
    boost::asio::io_context io{1};
    tcp::socket socket(io);
    boost::system::error_code error;
    const tcp::endpoint any_port(boost::asio::ip::make_address(endpoint.ip, error), 0);
    socket.open(any_port.protocol(), error);
    if (!error)
        socket.bind(any_port, error);
    return error ? Result<void>(cannot_listen(flag, endpoint, error.value(), error.message()))
                 : Result<void>();
}

bool meet(const Endpoint& a, const Endpoint& b) {
    const auto is_any = [](const Endpoint& endpoint) {
        return endpoint.ip == "0.0.0.0" || endpoint.ip == "::";
    };
    return a.port != 0 && a.port == b.port && (a.ip == b.ip || is_any(a) || is_any(b));
}

Error cannot_listen(const std::string& flag, const Endpoint& endpoint, int error,
                    const std::string& message) {
    std::string advice = fmt::format("choose another address with {} ADDR:PORT", flag);
    if (error == EADDRINUSE)
        advice = fmt::format("another program listens there; stop it or choose another port with "
                             "{}, 0 takes a free one",
                             flag);
    else if (error == EACCES)
        advice = fmt::format("ports below 1024 need root; choose another with {}", flag);
    else if (error == EADDRNOTAVAIL)
        advice = "this machine has no such address; 0.0.0.0 listens on all of them";
    return {fmt::format("cannot listen on {}: {}: {}", endpoint.text(), message, advice)};
}

} // namespace seaway::server
