// SPDX-License-Identifier: Apache-2.0
#include "server/net/origins.h"

#include <algorithm>
#include <charconv>

#include <boost/asio/ip/address.hpp>
#include <fmt/format.h>

namespace seaway::server {
namespace {

namespace ip = boost::asio::ip;

std::string lower(std::string_view text) {
    std::string out(text);
    for (char& c : out)
        if (c >= 'A' && c <= 'Z')
            c = static_cast<char>(c + ('a' - 'A'));
    return out;
}

bool is_word(char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
}

struct Origin {
    std::string scheme;
    Authority authority;

    std::string whole() const {
        const int usual = scheme == "http" ? 80 : scheme == "https" ? 443 : 0;
        return fmt::format("{}://{}:{}", scheme, authority.host,
                           authority.port > 0 ? authority.port : usual);
    }
};

std::optional<Origin> read_origin(std::string_view text) {
    const std::size_t colon = text.find("://");
    if (colon == 0 || colon == std::string_view::npos)
        return std::nullopt;
    Origin origin{lower(text.substr(0, colon)), {}};
    if (!std::all_of(origin.scheme.begin(), origin.scheme.end(),
                     [](char c) { return is_word(c) || c == '+' || c == '-' || c == '.'; }))
        return std::nullopt;
    const std::optional<Authority> authority = read_authority(text.substr(colon + 3));
    if (!authority)
        return std::nullopt;
    origin.authority = *authority;
    return origin;
}

} // namespace

bool Authority::is_certain() const {
    return literal || host == "localhost" || host.ends_with(".localhost");
}

std::optional<Authority> read_authority(std::string_view text) {
    Authority authority;
    std::string_view rest;
    boost::system::error_code error;
    if (text.starts_with('[')) {
        const std::size_t end = std::min(text.find(']'), text.size() - 1);
        authority.host = lower(text.substr(1, end - 1));
        ip::make_address_v6(authority.host, error);
        if (error || text[end] != ']')
            return std::nullopt;
        authority.literal = true;
        rest = text.substr(end + 1);
    } else {
        const std::size_t end = std::min(text.find(':'), text.size());
        authority.host = lower(text.substr(0, end));
        if (authority.host.size() > 1 && authority.host.ends_with('.'))
            authority.host.pop_back();
        constexpr std::string_view marks = "-._~!$&'()*+,;=%";
        if (authority.host.empty() ||
            !std::all_of(authority.host.begin(), authority.host.end(), [&](char c) {
                return is_word(c) || marks.find(c) != std::string_view::npos;
            }))
            return std::nullopt;
        ip::make_address_v4(authority.host, error);
        authority.literal = !error;
        rest = text.substr(end);
    }
    if (rest.empty() || rest == ":")
        return authority;
    const auto read = std::from_chars(rest.data() + 1, rest.data() + rest.size(), authority.port);
    if (rest.front() != ':' || read.ec != std::errc() || read.ptr != rest.data() + rest.size() ||
        authority.port < 1 || authority.port > 65535)
        return std::nullopt;
    return authority;
}

Result<Origins> Origins::read(const std::vector<std::string>& allowed,
                              const std::string& own_host) {
    Origins origins;
    if (const std::optional<Authority> own = read_authority(own_host))
        origins.hosts_.insert(own->host);
    for (const std::string& text : allowed) {
        const std::optional<Origin> origin = read_origin(text);
        if (!origin || text.find('*') != std::string::npos) // no patterns
            return Error{
                fmt::format("--allow-origin {}: expected SCHEME://HOST[:PORT] as a browser "
                            "writes it, such as https://sea.example.org{}",
                            text, text == "null" ? "; any page can make itself \"null\"" : "")};
        origins.allowed_.insert(origin->whole());
        origins.hosts_.insert(origin->authority.host);
    }
    return origins;
}

bool Origins::allows(std::string_view text, const Authority& host, bool tls) const {
    const std::optional<Origin> origin = read_origin(text);
    if (!origin)
        return false;
    const std::string whole = origin->whole();
    return allowed_.count(whole) > 0 ||
           (knows(host) && whole == Origin{tls ? "https" : "http", host}.whole());
}

} // namespace seaway::server
