// SPDX-License-Identifier: Apache-2.0
#include "client/link/url.h"

#include <algorithm>
#include <charconv>

#include <fmt/format.h>

#include "client/link/failure.h"

namespace seaway::client {
namespace {

Error bad_url(std::string_view text, std::string_view why) {
    return failed(Failure::bad_argument, fmt::format("address '{}': {}", text, why));
}

bool port_fits(std::string_view port) {
    unsigned number = 0;
    const auto [end, problem] = std::from_chars(port.data(), port.data() + port.size(), number);
    return problem == std::errc() && end == port.data() + port.size() && number >= 1 &&
           number <= 65535;
}

bool has_blank_or_control(std::string_view text) {
    return std::ranges::any_of(text, [](unsigned char c) { return c <= ' ' || c == 0x7f; });
}

bool is_ascii(std::string_view text) {
    return std::ranges::all_of(text, [](unsigned char c) { return c < 0x80; });
}

} // namespace

std::string Url::authority() const {
    const bool bare_ipv6 = host.find(':') != std::string::npos;
    const std::string name = bare_ipv6 ? fmt::format("[{}]", host) : host;
    return port == (tls ? "443" : "80") ? name : fmt::format("{}:{}", name, port);
}

Result<Url> parse_url(std::string_view text) {
    const std::size_t scheme_end = text.find("://");
    if (scheme_end == std::string_view::npos)
        return bad_url(text, "write it as ws://HOST:PORT or wss://HOST:PORT");
    const std::string_view scheme = text.substr(0, scheme_end);
    if (scheme != "ws" && scheme != "wss")
        return bad_url(
            text, fmt::format("scheme '{}' is not known, use ws:// or, with TLS, wss://", scheme));
    if (has_blank_or_control(text) || text.find('#') != std::string_view::npos)
        return bad_url(text, "blanks, control characters and '#' are not allowed");
    if (!is_ascii(text))
        return bad_url(text, "it has to be ASCII: a name as xn--..., a path as %C3%BC");
    Url url;
    url.tls = scheme == "wss";
    std::string_view rest = text.substr(scheme_end + 3);
    const std::size_t path_start = rest.find_first_of("/?");
    if (path_start != std::string_view::npos) {
        const std::string_view path = rest.substr(path_start);
        if (path.front() == '?')
            url.path.append(path);
        else if (path != "/")
            url.path = path;
        rest = rest.substr(0, path_start);
    }
    if (rest.find('@') != std::string_view::npos)
        return bad_url(text, "user names and passwords are not used; give a token instead");
    std::size_t host_end = rest.find(':');
    if (rest.starts_with('[')) {
        const std::size_t bracket = rest.find(']');
        if (bracket == std::string_view::npos)
            return bad_url(text, "an IPv6 address needs its closing ']'");
        url.host = rest.substr(1, bracket - 1);
        if (url.host.find(':') == std::string::npos && !url.host.empty())
            return bad_url(text, "between brackets stands an IPv6 address");
        host_end = bracket + 1;
        if (host_end == rest.size())
            host_end = std::string_view::npos;
        else if (rest[host_end] != ':')
            return bad_url(text, "after ']' comes ':PORT' or the path");
    } else {
        url.host = rest.substr(0, host_end);
    }
    if (url.host.find_first_of("[]") != std::string::npos)
        return bad_url(text, "brackets stand around an IPv6 address, once");
    if (url.host.empty())
        return bad_url(text, "the host is missing (an IPv6 address is written in brackets)");
    url.port = url.tls ? "443" : "80";
    if (host_end != std::string_view::npos) {
        url.port = rest.substr(host_end + 1);
        if (!port_fits(url.port))
            return bad_url(text, fmt::format("port '{}' is not a number from 1 to 65535 (an IPv6 "
                                             "address is written in brackets)",
                                             url.port));
    }
    return url;
}

} // namespace seaway::client
