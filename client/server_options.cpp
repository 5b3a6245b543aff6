// SPDX-License-Identifier: Apache-2.0
#include "client/server_options.h"

#include <string_view>

#include <fmt/format.h>

#include "client/link/failure.h"
#include "client/link/url.h"
#include "protocol/token_file.h"

namespace seaway::client {

namespace {

constexpr std::string_view plain = "ws://";
constexpr double timeout_max_s = 86400;

Error not_connected(const std::string& url, Error why) {
    const bool spoke_otherwise = why.message.find("no WebSocket server") != std::string::npos;
    if (failure_of(why) == Failure::cannot_connect && url.starts_with(plain) && spoke_otherwise)
        why.message += "; if it speaks TLS it is wss://" + url.substr(plain.size());
    return why;
}

} // namespace

void ServerOptions::describe(CommandLine& line, const std::string& token) {
    line.option("--timeout", timeout_s, "Patience with each request")
        .takes("SECONDS")
        .shows_default();
    line.option("--token-file", token_file, "File with " + token).takes("FILE");
    line.option("--ca-file", ca_file, "Certificates (PEM) to trust, for wss").takes("FILE");
}

Result<void> ServerOptions::check() const {
    SEAWAY_TRY(parse_url(url));
    if (!ca_file.empty() && url.starts_with(plain))
        return Error{fmt::format("--ca-file: {} is no wss, no certificate is looked at", url)};
    if (!(timeout_s > 0 && timeout_s <= timeout_max_s))
        return Error{fmt::format("--timeout {}: above 0, up to {} s", timeout_s, timeout_max_s)};
    return {};
}

Result<ConnectOptions> ServerOptions::connect_options(const std::string& program) const {
    ConnectOptions options{.url = url,
                           .name = program + "/" SEAWAY_VERSION,
                           .token = {},
                           .ca_file = ca_file,
                           .timeout_s = timeout_s};
    if (token_file.empty())
        return options;
    const Result<std::string> token = protocol::read_token_file(token_file);
    if (!token)
        return failed(Failure::bad_argument, token.error().message);
    options.token = *token;
    return options;
}

Result<std::unique_ptr<Client>> connect_to(const ConnectOptions& options, ClientEvents events) {
    Result<std::unique_ptr<Client>> client = Client::connect(options, std::move(events));
    return client ? std::move(client) : not_connected(options.url, client.error());
}

Result<std::unique_ptr<Connection>> connection_to(const ConnectOptions& options) {
    Result<std::unique_ptr<Connection>> connection = Connection::open(options, {});
    return connection ? std::move(connection) : not_connected(options.url, connection.error());
}

} // namespace seaway::client
