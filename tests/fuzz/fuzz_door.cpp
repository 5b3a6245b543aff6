// SPDX-License-Identifier: Apache-2.0
// What stands in flags, files and header fields at the door: addresses, origins, hosts, URLs, tokens, parameters of
// maps. Refused by name, or what was read holds what its header says. Input: fields, each up to a line end.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <string_view>

#include "client/link/url.h"
#include "protocol/limits.h"
#include "protocol/token_file.h"
#include "server/map_source.h"
#include "server/net/endpoint.h"
#include "server/net/origins.h"
#include "server/net/tokens.h"
#include "tests/fuzz/scratch_file.h"

using namespace seaway;

namespace {

void require(bool kept) {
    if (!kept)
        std::abort();
}

void try_addresses(const std::string& text) {
    if (const auto endpoint = server::read_endpoint("--listen", text)) {
        require(endpoint->port >= 0 && endpoint->port <= 65535);
        const auto again = server::read_endpoint("--listen", endpoint->text());
        require(again && again->text() == endpoint->text());
    } else {
        require(endpoint.error().message.find("--listen") != std::string::npos);
    }
    if (const auto url = client::parse_url(text)) {
        require(!url->host.empty() && url->path.starts_with('/'));
        const auto again =
            client::parse_url((url->tls ? "wss://" : "ws://") + url->authority() + url->path);
        require(again && again->host == url->host && again->port == url->port);
    }
}

void try_origins(const std::string& text, const std::string& host) {
    const auto authority = server::read_authority(host);
    const auto origins = server::Origins::read({text});
    if (!origins || !authority)
        return;
    require(!origins->allows("null", *authority, false));
    require(origins->allows(text, *authority, true) == origins->allows(text, *authority, true));
}

void try_tokens(const std::string& text) {
    const std::string path = tests::scratch_file(
        "token", reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
    const auto token = protocol::read_token_file(path);
    if (!token)
        return require(token.error().message.starts_with(path));
    require(!token->empty() && token->size() <= protocol::limits::hello_text_bytes_max);
    for (const char c : *token)
        require(c > ' ' - 1 && c <= '~');
    require(server::tokens_equal(*token, *token) && !server::tokens_equal(*token, ""));
    require(server::printable(*token).size() <= 120);
}

void try_map(std::string_view text) {
    static constexpr const char* names[] = {"kind",     "x0_m",    "y0_m", "width_m",
                                            "height_m", "columns", "rows", "t_s"};
    std::map<std::string, std::string> parameters{
        {"width_m", "10"}, {"height_m", "10"}, {"columns", "2"}, {"rows", "2"}};
    for (std::size_t i = 0; !text.empty(); ++i) {
        const std::size_t end = text.find('&');
        parameters[i < std::size(names) ? names[i] : std::string(text.substr(0, 4))] =
            text.substr(0, end);
        text = end == std::string_view::npos ? std::string_view() : text.substr(end + 1);
    }
    const auto request = server::read_map_request(parameters, 5);
    if (!request)
        return require(!request.error().message.empty());
    require(std::isfinite(request->x0_m) && std::isfinite(request->y0_m));
    require(request->width_m > 0 && request->width_m <= 1e6);
    require(request->columns >= 1 && request->columns <= 4096 && request->rows >= 1);
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    std::string_view rest(reinterpret_cast<const char*>(data), size);
    std::string fields[4];
    for (std::string& field : fields) {
        const std::size_t end = rest.find('\n');
        field = rest.substr(0, end);
        rest = end == std::string_view::npos ? std::string_view() : rest.substr(end + 1);
    }
    try_addresses(fields[0]);
    try_origins(fields[1], fields[2]);
    try_map(fields[3]);
    try_tokens(std::string(data, data + size));
    return 0;
}
