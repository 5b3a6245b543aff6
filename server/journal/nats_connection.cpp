// SPDX-License-Identifier: Apache-2.0
#include "server/journal/nats_connection.h"

#include <atomic>
#include <random>
#include <utility>

#include <fmt/format.h>
#include <nats/nats.h>
#include <resolv.h>

#include "base/pem_file.h"
#include "base/text_file.h"
#include "server/journal/shared_log.h"

namespace seaway::server {
namespace {

constexpr std::size_t credentials_bytes_max = 64 * 1024;
/// A peer that is silent for two of them has gone.
constexpr int ping_every_ms = 2000;

struct DestroyOptions {
    void operator()(natsOptions* options) const { natsOptions_Destroy(options); }
};

/// The library's errors are several lines with places in its source: the status says what an operator needs.
std::string said(natsStatus status) {
    return natsStatus_GetText(status);
}

Result<void> with_file(const char* option, const std::string& file, natsStatus status) {
    if (status == NATS_OK)
        return {};
    return Error{fmt::format("{} {}: {}", option, file, said(status))};
}

Result<void> set_credentials(natsOptions* options, const std::string& file) {
    constexpr const char* option = "--journal-credentials";
    Result<std::string> text = read_text_file(file, credentials_bytes_max);
    if (!text)
        return Error{fmt::format("{} {}: {}", option, file, text.error().message)};
    if (text->starts_with("-----BEGIN")) {
        for (const char* part : {"-----BEGIN NATS USER JWT-----", "-----BEGIN USER NKEY SEED-----"})
            if (text->find(part) == std::string::npos)
                return Error{fmt::format("{} {}: NATS credentials without {}", option, file, part)};
        return with_file(option, file,
                         natsOptions_SetUserCredentialsFromFiles(options, file.c_str(), nullptr));
    }
    while (!text->empty() && (text->back() == '\n' || text->back() == '\r'))
        text->pop_back();
    if (text->empty() || text->find('\n') != std::string::npos)
        return Error{fmt::format("{} {}: neither NATS credentials nor one line, USER:PASSWORD or a "
                                 "token",
                                 option, file)};
    const std::size_t colon = text->find(':');
    return with_file(option, file,
                     colon == std::string::npos
                         ? natsOptions_SetToken(options, text->c_str())
                         : natsOptions_SetUserInfo(options, text->substr(0, colon).c_str(),
                                                   text->substr(colon + 1).c_str()));
}

Result<void> set_tls(natsOptions* options, const NatsPlace& place) {
    if (place.ca_file.empty())
        return {};
    // The library would wait for a pipe, and ask a terminal for a pass phrase.
    const auto readable = [](const char* option, const std::string& path,
                             const Result<std::string>& text) -> Result<void> {
        if (text)
            return {};
        return Error{fmt::format("{} {}: {}", option, path, text.error().message)};
    };
    SEAWAY_TRY(readable("--journal-tls-ca", place.ca_file, read_pem_file(place.ca_file)));
    if (!place.cert_file.empty()) {
        SEAWAY_TRY(readable("--journal-tls-cert", place.cert_file, read_pem_file(place.cert_file)));
        SEAWAY_TRY(
            readable("--journal-tls-key", place.key_file, read_pem_key_file(place.key_file)));
    }
    SEAWAY_TRY(with_file("--journal-tls-ca", place.ca_file, natsOptions_SetSecure(options, true)));
    SEAWAY_TRY(with_file("--journal-tls-ca", place.ca_file,
                         natsOptions_LoadCATrustedCertificates(options, place.ca_file.c_str())));
    if (place.cert_file.empty())
        return {};
    // One call, which does not say of which.
    return with_file("--journal-tls-cert",
                     place.cert_file + " with --journal-tls-key " + place.key_file,
                     natsOptions_LoadCertificatesChain(options, place.cert_file.c_str(),
                                                       place.key_file.c_str()));
}

using Options = std::unique_ptr<natsOptions, DestroyOptions>;

/// With what the files say now.
Result<Options> options_of(const NatsPlace& place) {
    natsOptions* made = nullptr;
    natsStatus status = natsOptions_Create(&made);
    if (status != NATS_OK)
        return Error{"NATS: " + said(status)};
    Options options(made);
    for (const natsStatus next :
         {natsOptions_SetAllowReconnect(made, false),
          natsOptions_SetTimeout(made, nats_patience_ms),
          natsOptions_SetPingInterval(made, ping_every_ms), natsOptions_SetMaxPingsOut(made, 1),
          natsOptions_SetWriteDeadline(made, nats_patience_ms),
          natsOptions_SetName(made, "seaway-server")})
        status = status == NATS_OK ? next : status;
    if (status != NATS_OK)
        return Error{"NATS: " + said(status)};
    SEAWAY_TRY(set_tls(made, place));
    if (!place.credentials_file.empty())
        SEAWAY_TRY(set_credentials(made, place.credentials_file));
    return options;
}

/// Why nobody was let in, or nobody is there.
Error failed_to_connect(natsStatus status, const NatsPlace& place) {
    if (status == NATS_CONNECTION_AUTH_FAILED)
        return Error{fmt::format("NATS lets nobody in {} (--journal-credentials): {}",
                                 place.credentials_file.empty() ? "without credentials"
                                                                : "with these credentials",
                                 said(status))};
    if (status == NATS_SSL_ERROR || status == NATS_SECURE_CONNECTION_WANTED ||
        status == NATS_SECURE_CONNECTION_REQUIRED)
        return Error{"NATS and this server do not agree on TLS (--journal-tls-ca, "
                     "--journal-tls-cert): " +
                     said(status)};
    return Error{LogFailure::unreachable, "NATS cannot be reached: " + said(status)};
}

/// A name server that does not answer would keep a connection, and with it the stop of this server, for 10 s each (resolv.conf(5): timeout,
/// attempts). The library looks names up on the thread that connects, and these settings are that thread's.
void look_names_up_for_a_short_time() {
    if ((_res.options & RES_INIT) == 0 && res_init() != 0)
        return;
    _res.retrans = 1;
    _res.retry = 2;
}

} // namespace

struct NatsConnection::Parts {
    natsConnection* connection = nullptr;
    std::size_t host = 0; ///< that is tried first
    std::atomic<bool> no_more = false;
};

NatsConnection::NatsConnection(NatsPlace place, std::unique_ptr<Parts> parts)
    : place_(std::move(place)), parts_(std::move(parts)) {}

NatsConnection::NatsConnection(NatsConnection&&) noexcept = default;

NatsConnection::~NatsConnection() {
    if (parts_)
        drop();
}

Result<NatsConnection> NatsConnection::make(NatsPlace place) {
    SEAWAY_TRY(options_of(place));
    auto parts = std::make_unique<Parts>();
    parts->host = std::random_device()() % place.servers.size(); // as many at each
    return NatsConnection(std::move(place), std::move(parts));
}

void NatsConnection::connect_no_more() {
    parts_->no_more = true;
}

Result<natsConnection*> NatsConnection::get() {
    if (parts_->connection && natsConnection_IsClosed(parts_->connection))
        drop();
    if (parts_->connection)
        return parts_->connection;
    const Result<Options> options = options_of(place_);
    // It was fine when make() read it, and may be again. Clients are told of trouble, so its place is not named.
    if (!options)
        return Error{LogFailure::unreachable,
                     "NATS cannot be reached: a file that lets this server in is broken, SIGHUP "
                     "says which"};
    look_names_up_for_a_short_time();
    Error last{LogFailure::unreachable, "NATS is connected to no more: this server stops"};
    for (std::size_t tried = 0; tried < place_.servers.size() && !parts_->no_more; ++tried) {
        natsOptions_SetURL(options->get(), place_.servers[parts_->host].c_str());
        const natsStatus status = natsConnection_Connect(&parts_->connection, options->get());
        if (status == NATS_OK)
            return parts_->connection;
        parts_->connection = nullptr;
        parts_->host = (parts_->host + 1) % place_.servers.size();
        // What a host has said an operator has to know, beside hosts that are away.
        if (const Error why = failed_to_connect(status, place_);
            tried == 0 || last.is(LogFailure::unreachable))
            last = why;
    }
    return last;
}

void NatsConnection::drop() {
    if (!parts_->connection)
        return;
    natsConnection_Close(parts_->connection);
    natsConnection_Destroy(parts_->connection);
    parts_->connection = nullptr;
}

} // namespace seaway::server
