// SPDX-License-Identifier: Apache-2.0
#include "server/journal/open_journal.h"

#include <chrono>
#include <random>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "server/journal/nats_log.h"
#include "server/journal/nats_peers.h"
#include "server/journal/sea_clock.h"
#include "server/journal/shared_journal.h"
#include "server/journal/sqlite_journal.h"

namespace seaway::server {
namespace {

/// An engine that is restarted beside this server is there by then.
constexpr std::chrono::seconds start_patience{10};
constexpr std::chrono::milliseconds start_pause{250};

/// Unlike that of any other process, whatever their machines and numbers are.
std::string writer_name() {
    std::random_device lots;
    return fmt::format("{:08x}{:08x}", lots(), lots());
}

Result<NatsPlace> nats_place(const JournalPlace& place) {
    SEAWAY_TRY_LET(NatsPlace nats, read_nats_url(place.where));
    nats.ca_file = place.tls_ca_file;
    nats.cert_file = place.tls_cert_file;
    nats.key_file = place.tls_key_file;
    nats.credentials_file = place.credentials_file;
    nats.replicas = place.replicas;
    return nats;
}

Result<std::unique_ptr<Journal>> open_shared(const NatsPlace& place, const Beginning& beginning) {
    const auto until = std::chrono::steady_clock::now() + start_patience;
    while (true) {
        SEAWAY_TRY_LET(NatsConnection connection, NatsConnection::make(place));
        Result<std::unique_ptr<SharedJournal>> journal =
            SharedJournal::open(std::make_unique<NatsLog>(std::move(connection)), beginning,
                                {place.name(), writer_name(), local_now_us, SeaClock::utc_now_us});
        if (journal) {
            SEAWAY_TRY_LET(NatsConnection line, NatsConnection::make(place));
            (*journal)->talk_over(std::make_unique<NatsPeers>(std::move(line)));
            (*journal)->follow();
            return std::unique_ptr<Journal>(*std::move(journal));
        }
        const Error& why = journal.error();
        const bool may_pass = why.is(JournalError::unreachable) || why.is(JournalError::unknown);
        if (!may_pass || std::chrono::steady_clock::now() > until)
            return why;
        std::this_thread::sleep_for(start_pause);
    }
}

} // namespace

Result<void> check_journal_place(const JournalPlace& place) {
    if (is_nats_url(place.where)) {
        SEAWAY_TRY_LET(NatsPlace nats, nats_place(place));
        SEAWAY_TRY(NatsConnection::make(std::move(nats)));
        return {};
    }
    for (const auto& [option, file] : {std::pair{"--journal-tls-ca", &place.tls_ca_file},
                                       {"--journal-tls-cert", &place.tls_cert_file},
                                       {"--journal-credentials", &place.credentials_file}})
        if (!file->empty())
            return Error{fmt::format("{} goes with --journal nats://HOST:PORT/WORLD", option)};
    if (place.replicas != JournalPlace{}.replicas)
        return Error{"--journal-replicas goes with --journal nats://HOST:PORT/WORLD"};
    return {};
}

Result<std::unique_ptr<Journal>> open_journal(const JournalPlace& place,
                                              const Beginning& beginning) {
    if (is_nats_url(place.where)) {
        SEAWAY_TRY_LET(const NatsPlace nats, nats_place(place));
        return open_shared(nats, beginning);
    }
    SEAWAY_TRY_LET(std::unique_ptr<SqliteJournal> journal,
                   SqliteJournal::open(place.where, beginning, place.option));
    return std::unique_ptr<Journal>(std::move(journal));
}

} // namespace seaway::server
