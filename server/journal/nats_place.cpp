// SPDX-License-Identifier: Apache-2.0
#include "server/journal/nats_place.h"

#include <algorithm>
#include <charconv>
#include <sstream>

#include <fmt/format.h>

namespace seaway::server {
namespace {

constexpr std::string_view scheme = "nats://";
constexpr int port_default = 4222;

bool is_name(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
           c == '_';
}

bool is_host(std::string_view host) {
    return !host.empty() && std::ranges::all_of(host, [](char c) {
        return is_name(c) || c == '.' || c == ':' || c == '[' || c == ']';
    });
}

Result<std::string> read_server(std::string_view text) {
    std::size_t colon = text.rfind(':');
    if (!text.empty() && text.back() == ']') // an address with colons of its own
        colon = std::string_view::npos;
    const std::string_view host = text.substr(0, colon);
    int port = port_default;
    if (colon != std::string_view::npos) {
        const std::string_view digits = text.substr(colon + 1);
        const auto [end, error] =
            std::from_chars(digits.data(), digits.data() + digits.size(), port);
        if (error != std::errc{} || end != digits.data() + digits.size() || port < 1 ||
            port > 65535)
            return Error{fmt::format("'{}' is no port, 1 to 65535", digits)};
    }
    if (!is_host(host))
        return Error{fmt::format("'{}' is no host", host)};
    return fmt::format("{}{}:{}", scheme, host, port);
}

} // namespace

bool is_nats_url(std::string_view text) {
    return text.find("://") != std::string_view::npos;
}

std::string NatsPlace::name() const {
    std::string all;
    for (const std::string& server : servers)
        all += (all.empty() ? std::string(scheme) : ",") + server.substr(scheme.size());
    return all + '/' + world;
}

Result<NatsPlace> read_nats_url(const std::string& url) {
    // What may hold a secret is not said again.
    if (url.find('@') != std::string::npos)
        return Error{
            "--journal: who one is does not belong into the address, where others read it: "
            "--journal-credentials FILE"};
    const auto wrong = [&url](const std::string& why) {
        return Error{
            fmt::format("--journal {}: {}; it is a folder, or nats://HOST:PORT/WORLD", url, why)};
    };
    if (!url.starts_with(scheme))
        return wrong("of addresses only nats:// is known (TLS: --journal-tls-ca FILE)");
    const std::size_t slash = url.find('/', scheme.size());
    NatsPlace place;
    place.world = slash == std::string::npos ? "" : url.substr(slash + 1);
    if (place.world.empty() || place.world.size() > world_name_max ||
        !std::ranges::all_of(place.world, is_name))
        return wrong(
            fmt::format("the world's name is 1 to {} letters, digits, - and _", world_name_max));
    std::istringstream hosts(url.substr(scheme.size(), slash - scheme.size()));
    for (std::string host; std::getline(hosts, host, ',');) {
        Result<std::string> server = read_server(host);
        if (!server)
            return wrong(server.error().message);
        place.servers.push_back(*std::move(server));
    }
    if (place.servers.empty() || place.servers.size() > nats_servers_max)
        return wrong(fmt::format("1 to {} hosts", nats_servers_max));
    return place;
}

} // namespace seaway::server
