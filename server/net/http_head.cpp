// SPDX-License-Identifier: Apache-2.0
#include "server/net/http_head.h"

#include <algorithm>
#include <optional>

#include <fmt/format.h>

namespace seaway::server {
namespace {

bool equal_words(std::string_view a, std::string_view b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) {
        const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? c | 0x20 : int{c}; };
        return lower(x) == lower(y);
    });
}

std::string_view trimmed(std::string_view text) {
    const std::size_t first = text.find_first_not_of(" \t");
    if (first == std::string_view::npos)
        return {};
    return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

Refused bad_request(std::string why) {
    return {"bad_request", {.status = 400, .body = std::move(why) + "\n"}};
}

int hex(char c) {
    if (c >= '0' && c <= '9')
        return c - '0';
    const char lower = static_cast<char>(c | 0x20);
    return lower >= 'a' && lower <= 'f' ? lower - 'a' + 10 : -1;
}

/// Of "%41" its byte (RFC 3986, section 2.1); empty where a '%' has no two digits behind it.
std::optional<std::string> percent_decoded(std::string_view text) {
    std::string out;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] != '%') {
            out += text[i];
            continue;
        }
        if (text.size() - i < 3 || hex(text[i + 1]) < 0 || hex(text[i + 2]) < 0)
            return std::nullopt;
        out += static_cast<char>(hex(text[i + 1]) << 4 | hex(text[i + 2]));
        i += 2;
    }
    return out;
}

/// Path and name=value pairs behind the '?'.
bool split(std::string_view target, Asked& asked) {
    std::size_t begin = target.find('?');
    const std::optional<std::string> path = percent_decoded(target.substr(0, begin));
    if (!path)
        return false;
    asked.path = *path;
    while (begin != std::string_view::npos) {
        const std::size_t end = target.find('&', ++begin);
        const std::string_view pair = target.substr(begin, end - begin);
        const std::size_t equals = std::min(pair.find('='), pair.size());
        const auto name = percent_decoded(pair.substr(0, equals));
        const auto value = percent_decoded(pair.substr(std::min(equals + 1, pair.size())));
        if (!name || !value)
            return false;
        asked.parameters[*name] = *value;
        begin = end;
    }
    return true;
}

/// The body's framing is one that nobody reads otherwise.
std::optional<Refused> check_framing(const HttpHead& head) {
    if (head.transfer_encodings.empty())
        return std::nullopt;
    if (head.version < 11)
        return bad_request("Transfer-Encoding belongs to HTTP/1.1");
    if (head.transfer_encodings.size() > 1 || !equal_words(head.transfer_encodings[0], "chunked"))
        return Refused{
            "bad_request",
            {.status = 501, .body = "of Transfer-Encoding only chunked is understood\n"}};
    return std::nullopt;
}

struct Place {
    std::string_view target; ///< from its path on
    Authority host;          ///< empty where an old client named none
};

/// Host and target, of which an absolute target has both (RFC 9112, section 3.2.2).
std::variant<Place, Refused> read_place(const HttpHead& head) {
    if (head.hosts.size() > 1 || (head.hosts.empty() && head.version >= 11))
        return bad_request("a request has one Host field");
    Place place{head.target, {}};
    if (!head.hosts.empty()) {
        const std::optional<Authority> host = read_authority(head.hosts[0]);
        if (!host)
            return bad_request("Host is no HOST or HOST:PORT");
        place.host = *host;
    }
    for (const std::string_view scheme : {"http://", "https://"})
        if (equal_words(place.target.substr(0, scheme.size()), scheme)) {
            place.target.remove_prefix(scheme.size());
            const std::size_t end = std::min(place.target.find_first_of("/?"), place.target.size());
            const std::optional<Authority> host = read_authority(place.target.substr(0, end));
            if (!host)
                return bad_request("the target's host is no HOST or HOST:PORT");
            place.host = *host;
            place.target.remove_prefix(end);
            if (!place.target.starts_with('/'))
                return bad_request("the target has no path");
            break;
        }
    if (!place.target.starts_with('/') && place.target != "*")
        return bad_request("the target is neither a path nor an http URL");
    if (place.target.find('#') != std::string_view::npos)
        return bad_request("a target has no fragment");
    return place;
}

/// In a window of its own: what a page loads into a frame nobody sees.
bool follows_a_link(const HttpHead& head) {
    return equal_words(head.fetch_mode, "navigate") &&
           (head.fetch_dest.empty() || equal_words(head.fetch_dest, "document"));
}

/// Who made a browser send this may use the server.
std::optional<Refused> check_page(const HttpHead& head, const Origins& origins,
                                  const Authority& host, bool loopback, bool tls) {
    if (head.origins.size() > 1)
        return bad_request("a request has one Origin field");
    const auto forbidden = [](std::string why) {
        return Refused{"origin", {.status = 403, .body = std::move(why) + "\n"}};
    };
    if (loopback && !host.host.empty() && !origins.knows(host))
        return Refused{
            "host",
            {.status = 421,
             .body =
                 "on its own machine this server answers to addresses, localhost, the machine's "
                 "name and the hosts of --allow-origin: the name in Host is none of them\n"}};
    if (!head.origins.empty()) {
        if (head.origins[0] == "null")
            return forbidden("pages without an origin (Origin: null) may not use this server");
        if (!origins.allows(head.origins[0], host, tls))
            return forbidden("pages of this Origin may not use this server: the operator can allow "
                             "them with --allow-origin ORIGIN");
    } else if (equal_words(head.fetch_site, "cross-site") && !follows_a_link(head)) {
        return forbidden("pages of other sites may not load this");
    }
    return std::nullopt;
}

/// Nothing where there is no token or of another scheme.
std::string token_of(const HttpHead& head) {
    constexpr std::string_view scheme = "bearer ";
    if (head.authorizations.size() != 1)
        return {};
    const std::string_view value = head.authorizations[0];
    return equal_words(value.substr(0, scheme.size()), scheme)
               ? std::string(trimmed(value.substr(scheme.size())))
               : std::string();
}

} // namespace

std::variant<Asked, Refused> read_head(const HttpHead& head, const Origins& origins, bool loopback,
                                       bool tls) {
    if (auto refused = check_framing(head))
        return *std::move(refused);
    auto place = read_place(head);
    if (auto* refused = std::get_if<Refused>(&place))
        return std::move(*refused);
    const auto& [target, host] = std::get<Place>(place);
    if (auto refused = check_page(head, origins, host, loopback, tls))
        return *std::move(refused);
    if (head.authorizations.size() > 1)
        return bad_request("a request has one Authorization field");
    Asked asked{.path = {}, .parameters = {}, .token = token_of(head)};
    if (!split(target, asked))
        return bad_request("a '%' of the target has no two hexadecimal digits behind it");
    return asked;
}

bool is_websocket_key(std::string_view value) {
    constexpr std::string_view letters =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    constexpr std::size_t letters_of_16_bytes = 22;
    return value.size() == letters_of_16_bytes + 2 && value.ends_with("==") &&
           value.substr(0, letters_of_16_bytes).find_first_not_of(letters) ==
               std::string_view::npos;
}

bool offers(std::string_view list, std::string_view subprotocol) {
    while (true) {
        const std::size_t comma = list.find(',');
        if (trimmed(list.substr(0, comma)) == subprotocol)
            return true;
        if (comma == std::string_view::npos)
            return false;
        list.remove_prefix(comma + 1);
    }
}

} // namespace seaway::server
