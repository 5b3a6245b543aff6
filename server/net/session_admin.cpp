// SPDX-License-Identifier: Apache-2.0
// What administrators may ask of a session: changes of the sea, and what there is.
#include <algorithm>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "base/hash.h"
#include "base/messages.h"
#include "protocol/limits.h"
#include "server/host/refusal.h"
#include "server/net/refusals.h"
#include "server/net/session.h"
#include "server/net/session_behind.h"

namespace seaway::server {

using nlohmann::ordered_json;
using wire::ErrorCode;

namespace {

constexpr std::size_t sessions_listed_max = 256;
constexpr int changes_in_flight_max = 4;
constexpr int journal_reads_max = 4;

Error administrators_alone(bool there_are_some) {
    return {ErrorCode::unauthorised,
            there_are_some ? "this is for administrators: connect with their token"
                           : "this server has no administrators: it was started without "
                             "--admin-token-file"};
}

Result<SeaWish> wish_of(const wire::Change& change, int in_flight) {
    if (const Result<void> fine = protocol::check(change); !fine)
        return Error{Refusal::bad_value, fine.error().message};
    if (in_flight >= changes_in_flight_max)
        return Error{Refusal::busy, fmt::format("{} changes are not made yet", in_flight)};
    SeaWish wish;
    wish.over_us = change.over_us();
    wish.at_us = change.at_us();
    if (const flatbuffers::Optional<std::uint32_t> pace = change.pace_permille()) {
        wish.pace_permille = static_cast<int>(*pace);
        if (wish.over_us != 0 || wish.at_us != 0)
            return Error{
                Refusal::bad_value,
                fmt::format("a pace holds from a second on, and at once: over_us is {} and "
                            "at_us {}, allowed is 0",
                            wish.over_us, wish.at_us)};
    }
    if (change.scene() != nullptr)
        wish.scene = change.scene()->str();
    if (change.set() != nullptr)
        for (const flatbuffers::String* text : *change.set()) {
            Result<TomlAssignment> value = parse_toml_assignment(text->string_view());
            if (!value)
                return Error{Refusal::bad_value, value.error().message};
            wish.set.push_back(*std::move(value));
        }
    return wish;
}

/// For the log: all of it, long values cut. A scene that two servers name alike is the same.
std::string what_of(const SeaWish& wish) {
    if (wish.pace_permille)
        return fmt::format("pace {}", *wish.pace_permille / static_cast<double>(sea::pace_unit));
    if (wish.set.empty())
        return fmt::format("a scene of {} bytes, fnv1a {}", wish.scene.size(),
                           hex_hash(wish.scene));
    std::string what;
    for (const TomlAssignment& one : wish.set) {
        const std::string text = seaway::printable(one.path + "=" + one.value);
        std::size_t most = 120;
        while (most < text.size() && (static_cast<unsigned char>(text[most]) & 0xc0u) == 0x80u)
            --most; // not within a character
        what += what.empty() ? "" : " ";
        what += text.size() <= most ? text : text.substr(0, most) + "[...]";
    }
    return what;
}

} // namespace

void Session::on_change(const wire::Change& change) {
    const std::uint32_t request_id = change.request_id();
    if (standing_ != Standing::administrator)
        return refuse(request_id, administrators_alone(!core_.tokens.admin.empty()));
    Result<SeaWish> wish = wish_of(change, changes_in_flight_);
    ++changes_in_flight_;
    if (wish)
        core_.log_act(fmt::format("event=change_asked session={} peer={} over_s={} what={}", id_,
                                  peer_.name, sea::seconds_from_us(wish->over_us),
                                  in_quotes(what_of(*wish))));
    core_.host.change(std::move(wish), [core = core_.weak_from_this(), session = id_,
                                        request_id](Result<SeaPromise> promise) {
        const std::shared_ptr<Core> alive = core.lock();
        if (alive == nullptr)
            return;
        alive->post([core, session, request_id, promise = std::move(promise)] {
            const std::shared_ptr<Core> here = core.lock();
            if (here && !promise)
                here->log_act(fmt::format("event=change_refused session={} why={}", session,
                                          in_quotes(promise.error().message)));
            if (Session* found = here ? here->find(session) : nullptr)
                found->or_drop([&] { found->changed(request_id, promise); });
        });
    });
}

void Session::changed(std::uint32_t request_id, const Result<SeaPromise>& promise) {
    --changes_in_flight_;
    if (!promise)
        return refuse(request_id, promise.error());
    reply(protocol::changed(request_id, promise->epoch, promise->start_us, promise->end_us,
                            promise->change));
}

void Session::on_administer(const wire::Administer& administer) {
    const std::uint32_t request_id = administer.request_id();
    if (standing_ != Standing::administrator)
        return refuse(request_id, administrators_alone(!core_.tokens.admin.empty()));
    if (const Result<void> fine = protocol::check(administer); !fine)
        return refuse(request_id, fine.error());
    switch (administer.act()) {
    case wire::Act::state:
        return reply(protocol::administered(request_id, core_.host.state_json()));
    case wire::Act::plan:
        return reply(protocol::administered(request_id, core_.host.plan_json()));
    case wire::Act::sessions:
        return reply(protocol::administered(request_id, sessions_json()));
    case wire::Act::history:
        return read_journal(request_id, &Host::history, administer.session());
    case wire::Act::change:
        return read_journal(request_id, &Host::scene_of_change, administer.session());
    case wire::Act::drop:
        if (const Result<void> gone = drop(administer.session()); !gone)
            return refuse(request_id, gone.error());
        return reply(protocol::administered(
            request_id, fmt::format("{{\"dropped\": {}}}\n", administer.session())));
    }
}

/// It stands on a disk, which may hang: all others would wait with the network's thread.
void Session::read_journal(std::uint32_t request_id, JournalText text, std::uint64_t number) {
    if (journal_reads_ >= journal_reads_max)
        return refuse(request_id, {ErrorCode::too_many_requests,
                                   fmt::format("{} readings of the journal are not answered yet",
                                               journal_reads_)});
    ++journal_reads_;
    if (!ask_behind([text, number](Host& host) { return (host.*text)(number); },
                    [request_id](Session& session, const Result<std::string>& said) {
                        session.told(request_id, said);
                    }))
        told(request_id, Error{Refusal::busy, "too much waits to be read or made already"});
}

void Session::told(std::uint32_t request_id, const Result<std::string>& text) {
    --journal_reads_;
    if (!text)
        return refuse(request_id, text.error());
    if (text->size() > protocol::limits::administered_bytes_max)
        return refuse(request_id,
                      {ErrorCode::too_large,
                       fmt::format("the answer has {} bytes, at most {} are told", text->size(),
                                   protocol::limits::administered_bytes_max)});
    reply(protocol::administered(request_id, *text));
}

std::string Session::sessions_json() const {
    using Waiting = std::pair<std::size_t, const Session*>;
    std::vector<Waiting> waiting; // by number, as those of equal bytes stay
    std::size_t bytes_waiting = 0;
    for (const auto& [id, session] : core_.sessions) {
        waiting.emplace_back(session->outbox_.bytes_waiting(), session);
        bytes_waiting += waiting.back().first;
    }
    std::stable_sort(waiting.begin(), waiting.end(),
                     [](const Waiting& a, const Waiting& b) { return a.first > b.first; });
    waiting.resize(std::min(waiting.size(), sessions_listed_max));
    ordered_json listed = ordered_json::array();
    const auto now = std::chrono::steady_clock::now();
    for (const auto& [bytes, session] : waiting) {
        const std::optional<Demand> grant = core_.host.subscriptions().find(session->id_);
        listed.push_back(
            {{"session", session->id_},
             {"peer", session->peer_.name},
             {"client", session->client_},
             {"administrator", session->standing_ == Standing::administrator},
             {"open_s",
              std::chrono::duration_cast<std::chrono::seconds>(now - session->opened_).count()},
             {"subscribed", grant.has_value()},
             {"messages_sent", session->messages_sent_},
             {"bytes_sent", session->bytes_sent_},
             {"bytes_waiting", bytes}});
    }
    const ordered_json json{
        {"sessions", core_.sessions.size()}, {"bytes_waiting", bytes_waiting}, {"listed", listed}};
    return json.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

Result<void> Session::drop(SessionId session) {
    if (session == id_)
        return Error{ErrorCode::bad_value,
                     fmt::format("session is {}, which is this one: close it instead", session)};
    Session* found = core_.find(session);
    if (found == nullptr)
        return Error{ErrorCode::bad_value, fmt::format("session is {}; there is none", session)};
    core_.log_act(
        fmt::format("event=session_dropped session={} by={} peer={}", session, id_, peer_.name));
    found->close(ErrorCode::dropped, "an administrator has ended this session");
    return {};
}

} // namespace seaway::server
