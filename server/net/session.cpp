// SPDX-License-Identifier: Apache-2.0
#include "server/net/session.h"

#include <algorithm>
#include <chrono>
#include <new>

#include <fmt/format.h>

#include "base/messages.h"
#include "protocol/limits.h"
#include "server/net/fetch_job.h"
#include "server/net/refusals.h"
#include "server/net/session_behind.h"
#include "server/net/tokens.h"

namespace seaway::server {

namespace limits = protocol::limits;
using wire::ErrorCode;

Session::Session(Core& core, Link& link, Peer peer, Standing standing)
    : core_(core), link_(link), id_(core.next_session++), peer_(std::move(peer)),
      standing_(standing) {
    core_.sessions[id_] = this;
    ++core_.counters.sessions_opened;
}

Session::~Session() {
    try {
        end(disconnected, "connection dropped");
    } catch (const std::bad_alloc&) { // of what counts and logs; it has ended
    }
}

void Session::receive(std::span<const std::uint8_t> bytes) {
    if (closing_ || ended_ || core_.stopping) // which ends what is not taken
        return;
    or_drop([&] { dispatch(bytes); });
}

void Session::dispatch(std::span<const std::uint8_t> bytes) {
    ++core_.counters.messages_received;
    core_.counters.bytes_received += bytes.size();
    const Result<const wire::Message*> message = reader_.read(bytes);
    if (!message)
        return close(ErrorCode::bad_message, message.error().message);
    const wire::Message& m = **message;
    if (!greeted_ && m.body_type() != wire::Body::Hello)
        return close(ErrorCode::hello_expected, "the first message must be Hello");
    make_owed_spectra();
    if (closing_ || ended_) // by what it was owed
        return;
    switch (m.body_type()) {
    case wire::Body::Hello:
        return on_hello(*m.body_as_Hello());
    case wire::Body::Subscribe:
        return on_subscribe(*m.body_as_Subscribe());
    case wire::Body::Unsubscribe:
        return on_unsubscribe(m.body_as_Unsubscribe()->spectrum());
    case wire::Body::SubscribeSpectrum:
        return on_subscribe_spectrum(*m.body_as_SubscribeSpectrum());
    case wire::Body::Ack:
        return on_ack(*m.body_as_Ack());
    case wire::Body::Fetch:
        return on_fetch(*m.body_as_Fetch());
    case wire::Body::Query:
        return on_query(*m.body_as_Query());
    case wire::Body::Ping:
        return on_ping(*m.body_as_Ping());
    case wire::Body::Change:
        return on_change(*m.body_as_Change());
    case wire::Body::Administer:
        return on_administer(*m.body_as_Administer());
    case wire::Body::NONE: // read() lets none of these through
    case wire::Body::Welcome:
    case wire::Body::SeaState:
    case wire::Body::Subscribed:
    case wire::Body::Tile:
    case wire::Body::QueryReply:
    case wire::Body::FetchDone:
    case wire::Body::Pong:
    case wire::Body::Refused:
    case wire::Body::GoAway:
    case wire::Body::SpectrumSubscribed:
    case wire::Body::Spectrum:
    case wire::Body::SpectrumChunk:
    case wire::Body::Changed:
    case wire::Body::Administered:
    case wire::Body::Pace:
        return close(ErrorCode::bad_message, "message kind does not come from a client");
    }
}

void Session::on_hello(const wire::Hello& hello) {
    if (greeted_)
        return close(ErrorCode::bad_message, "Hello was said before");
    if (const Result<void> fine = protocol::check(hello); !fine)
        return close(ErrorCode::bad_value, fine.error().message);
    const auto* versions = hello.versions();
    if (std::find(versions->begin(), versions->end(), protocol::version) == versions->end())
        return close(ErrorCode::unsupported_version,
                     fmt::format("this server speaks version {}", protocol::version));
    const std::string_view token = hello.token() ? hello.token()->string_view() : "";
    const Judgement judged = judge_token(core_, peer_, token);
    if (judged.barred)
        return close(judged.barred == Barred::too_many_wrong ? ErrorCode::too_many_requests
                                                             : ErrorCode::unauthorised,
                     judged.why, judged.retry_after);
    if (!token.empty())
        standing_ = judged.standing;
    if (standing_ == Standing::stranger && !is_open(core_))
        return close(ErrorCode::unauthorised, "token missing or wrong");
    greeted_ = true;
    client_ = printable(hello.client() ? hello.client()->string_view() : "");
    core_.log(fmt::format("event=session_open session={} peer={} client={} administrator={}", id_,
                          peer_.name, in_quotes(client_), standing_ == Standing::administrator));
    reply(protocol::welcome(id_, "seaway " SEAWAY_VERSION, core_.host.sea_time()));
    for (const protocol::SharedBytes& state : core_.host.sea_state_messages())
        tell(state);
}

bool Session::fetches_too_many(std::uint32_t request_id) {
    if (fetches_in_flight_ + outbox_.fetches_waiting() < limits::fetches_in_flight_max)
        return false;
    refuse(request_id, {ErrorCode::too_many_requests, "earlier fetches are not done"});
    return true;
}

void Session::on_subscribe(const wire::Subscribe& subscribe) {
    const std::uint32_t request_id = subscribe.request_id();
    if (const Result<void> fine = protocol::check(subscribe); !fine)
        return refuse(request_id, fine.error());
    if (fetches_too_many(request_id))
        return;
    Demand wish{.cascades = subscribe.cascades(),
                .fields = sea::FieldSet::from_bits(subscribe.fields()),
                .error_m = subscribe.error_m(),
                .compact = subscribe.compact(),
                .predicted = subscribe.predicted(),
                .rate_hz_max = subscribe.rate_hz_max(),
                .size_max = subscribe.size_max()};
    wish.shared_only = shares_coarser_maps(wish);
    const Demand grant = core_.host.grant(wish, id_);
    if (grant.empty()) // what was granted before goes on
        return refuse(
            request_id,
            {grant.busy ? Refusal::busy : Refusal::not_offered,
             grant.why.empty() ? "this sea offers none of these fields and cascades" : grant.why});
    if (subscription_ && subscription_->wish.predicted && !wish.predicted &&
        subscription_->wish.fields == wish.fields)
        ++core_.counters.predictions_given_up;
    outbox_.stop_stream();
    // At once: in a moment without either the simulation would end what nobody wants, foam's history too.
    core_.host.subscriptions().set(id_, grant);
    outbox_.set_credit(subscribe.credit());
    subscription_ = Subscription{request_id, wish, subscribe.credit(), grant};
    count_coarser_maps();
    state_grant();
    Demand start = grant;
    start.fields |= grant.follows;
    fetch(request_id, {}, start);
}

void Session::state_grant() {
    const Demand& grant = subscription_->granted;
    reply(protocol::subscribed(subscription_->request_id,
                               {.cascades = grant.cascades,
                                .fields = grant.fields | grant.follows,
                                .error_m = grant.error_m,
                                .rate_hz_max = grant.rate_hz_max,
                                .size_max = grant.size_max},
                               subscription_->credit, grant.why));
}

bool Session::shares_coarser_maps(const Demand& wish) const {
    if (core_.options.connections_per_address == 0 || // all are one address, that of a proxy
        (wish.size_max == 0 && !(wish.rate_hz_max > 0)))
        return false;
    return peer_.address->coarser_maps.kinds_but(counted_coarser_) >= coarser_rungs_of_address_max;
}

void Session::count_coarser_maps() {
    std::optional<Quality> now;
    if (subscription_ && is_coarser(subscription_->granted.quality))
        now = subscription_->granted.quality;
    peer_.address->coarser_maps.change(counted_coarser_, now);
    counted_coarser_ = now;
}

void Session::renew_grant() {
    if (!subscription_)
        return;
    const Demand before = subscription_->granted;
    Demand wish = subscription_->wish;
    wish.renewed = true;
    wish.quality = before.quality;
    wish.shared_only = shares_coarser_maps(wish);
    const Demand now = core_.host.grant(wish);
    subscription_->granted.until_us = now.until_us;
    if (now.empty()) // what streams goes on, and each tile says what it misses
        return;
    const bool other_tiles = !now.grants_as(before);
    if (!other_tiles && now.error_m == before.error_m && now.why == before.why &&
        now.rate_hz_max == before.rate_hz_max && now.size_max == before.size_max)
        return;
    subscription_->granted = now;
    count_coarser_maps();
    if (other_tiles) {
        subscription_->former_quality = before.quality;
        subscription_->former_cascades = before.cascades;
        core_.host.subscriptions().set(id_, now);
    }
    state_grant();
}

void Session::on_unsubscribe(bool spectrum) {
    if (spectrum) {
        spectrum_wish_.reset();
        spectra_owed_.reset();
        outbox_.stop_spectra();
        return;
    }
    subscription_.reset();
    count_coarser_maps();
    core_.host.subscriptions().erase(id_);
    outbox_.stop_stream();
}

void Session::on_ack(const wire::Ack& ack) {
    // There is no request that could be refused, and what is not taken off the window would stay there for ever.
    if (const Result<void> fine = protocol::check(ack); !fine)
        return close(ErrorCode::bad_value, fine.error().message);
    bool any = outbox_.acknowledge(ack.keyframe());
    if (ack.also() != nullptr)
        for (const std::uint64_t keyframe : *ack.also())
            any = outbox_.acknowledge(keyframe) || any;
    if (any)
        link_.send_more();
}

void Session::on_fetch(const wire::Fetch& request) {
    const std::uint32_t request_id = request.request_id();
    if (const Result<void> fine = protocol::check(request); !fine)
        return refuse(request_id, fine.error());
    if (fetches_too_many(request_id))
        return;
    fetch(request_id, {request.times_us()->begin(), request.times_us()->end()},
          {.cascades = request.cascades(),
           .fields = sea::FieldSet::from_bits(request.fields()),
           .error_m = request.error_m(),
           .compact = request.compact()});
}

void Session::fetch(std::uint32_t request_id, std::vector<sea::TimeUs> times_us,
                    const Demand& demand) {
    ++fetches_in_flight_;
    ++core_.counters.fetches;
    FetchJob::GiveBack give_back = [core = core_.weak_from_this(), session = id_,
                                    request_id](Result<FetchedTiles> encoded) {
        later(core, session, [request_id, encoded = std::move(encoded)](Session& found) {
            found.fetched(request_id, encoded);
        });
    };
    const auto job =
        std::make_shared<FetchJob>(core_.weak_from_this(), demand.fields, times_us.empty(),
                                   Asker(here_), std::move(give_back));
    core_.host.fetch({.times_us = std::move(times_us), .demand = demand, .asker = job->asker()},
                     [job](Result<FetchedPart> part) { job->bring(std::move(part)); });
}

void Session::fetched(std::uint32_t request_id, const Result<FetchedTiles>& encoded) {
    --fetches_in_flight_;
    if (!encoded)
        return refuse(request_id, encoded.error());
    const auto& [keyframes, fields, sea_states] = *encoded;
    for (const protocol::SharedBytes& sea_state : sea_states)
        tell(sea_state);
    auto done = std::make_shared<const protocol::Bytes>(
        protocol::fetch_done(request_id, static_cast<std::uint32_t>(keyframes.size()), fields));
    if (!outbox_.push_fetched(keyframes, fields, std::move(done)))
        return refuse(request_id, tiles_too_large(protocol::limits::fetch_bytes_max));
    link_.send_more();
}

void Session::on_ping(const wire::Ping& ping) {
    reply(protocol::pong(ping.request_id(), ping.client_time_us(), core_.host.sea_time()));
}

bool Session::wants_requests() const {
    return outbox_.accepts_requests();
}

protocol::SharedBytes Session::next_message() {
    if (closing_ || ended_)
        return nullptr;
    if (outbox_.paces_spectra())
        outbox_.allow_spectra(core_.host.sea_time_us());
    protocol::SharedBytes message = outbox_.next();
    if (message != nullptr)
        count_sent(*message);
    return message;
}

void Session::count_sent(const protocol::Bytes& message) {
    ++messages_sent_;
    bytes_sent_ += message.size();
    ++core_.counters.messages_sent;
    core_.counters.bytes_sent += message.size();
}

void Session::hello_overdue() {
    if (!greeted_)
        or_drop([&] {
            close(ErrorCode::hello_expected,
                  fmt::format("no Hello within {} ms", core_.options.hello_deadline.count()));
        });
}

bool Session::takes(const EncodedKeyframe& keyframe) {
    const Demand& granted = subscription_->granted;
    if (!granted.wants(keyframe.cascade))
        return false;
    const std::uint32_t cascade = 1u << keyframe.cascade;
    const bool awaited = keyframe.quality == granted.quality;
    if (awaited)
        subscription_->former_cascades &= ~cascade;
    return awaited || (keyframe.quality == subscription_->former_quality &&
                       (subscription_->former_cascades & cascade) != 0);
}

void Session::deliver(const Delivery& streamed) {
    const EncodedKeyframe& keyframe = *streamed.keyframe;
    if (!subscription_ || closing_ || !takes(keyframe))
        return;
    or_drop([&] {
        if (streamed.sea_state != nullptr && !was_told(streamed.sea_state))
            announce(streamed.sea_state);
        if (!subscription_) // it has not taken so many states that it was ended
            return;
        if (core_.host.sea_time_us() >= subscription_->granted.until_us)
            renew_grant();
        // A keyframe computed for an earlier plan may lack what this session was granted: half a
        // keyframe is of no use to it.
        const Demand& granted = subscription_->granted;
        const sea::FieldSet fields = maps_that_bring(keyframe, granted.fields, granted.follows);
        if (fields.empty())
            return;
        outbox_.push_keyframe(streamed.keyframe, fields, streamed.file);
        link_.send_more();
    });
}

void Session::tell_of(std::uint32_t epoch) {
    if (protocol::SharedBytes sea_state = core_.host.sea_state_message(epoch))
        tell(std::move(sea_state));
}

bool Session::was_told(const protocol::SharedBytes& sea_state) const {
    return std::ranges::find(told_, sea_state) != told_.end();
}

void Session::tell(protocol::SharedBytes sea_state) {
    if (!greeted_ || closing_ || ended_ || was_told(sea_state))
        return;
    or_drop([&] { // others are told all the same
        told_.push_back(sea_state);
        if (told_.size() > protocol::limits::sea_states_told)
            told_.pop_front();
        if (!outbox_.push_durable(std::move(sea_state)))
            return close(ErrorCode::too_slow, "sea states wait and cannot be sent");
        link_.send_more();
    });
}

void Session::announce(protocol::SharedBytes sea_state) {
    tell(std::move(sea_state));
    if (!greeted_ || closing_ || ended_)
        return;
    or_drop([&] {
        renew_grant();
        if (spectrum_wish_)
            make_spectra({});
        link_.send_more();
    });
}

void Session::reply(protocol::Bytes message) {
    outbox_.push_reply(std::make_shared<const protocol::Bytes>(std::move(message)));
    link_.send_more();
}

void Session::refuse(std::uint32_t request_id, const Error& why) {
    const ErrorCode code = wire_code(why);
    ++core_.counters.requests_refused[std::string(protocol::name(code))];
    reply(protocol::refused(request_id, code, why.message, retry_after_ms(why)));
}

bool Session::is_owed() const {
    return queries_in_flight_ + fetches_in_flight_ + spectra_in_making_ + changes_in_flight_ +
                   journal_reads_ >
               0 ||
           outbox_.fetches_waiting() > 0 || outbox_.reply_bytes_waiting() > 0;
}

void Session::close(ErrorCode code, const std::string& why, std::chrono::milliseconds stays_away) {
    if (closing_ || ended_)
        return;
    or_drop([&] { link_.send_held_back(); });
    if (ended_)
        return;
    closing_ = true;
    or_drop([&] {
        end(protocol::name(code), why);
        if (code == ErrorCode::shutting_down)
            stays_away = core_.retry_after;
        link_.close(std::make_shared<const protocol::Bytes>(protocol::go_away(
                        code, why, static_cast<std::uint32_t>(stays_away.count()))),
                    code, why);
    });
}

void Session::give_up(std::string_view why) {
    or_drop([&] { // its places are waited for, also where there is no memory to say why
        if (!outbox_.is_sending_streamed())
            return close(ErrorCode::too_slow, std::string(why));
        end(protocol::name(ErrorCode::too_slow), why);
        link_.drop();
    });
}

void Session::end(std::string_view reason, std::string_view why) {
    if (ended_)
        return;
    ended_ = true;
    here_ = nullptr;
    core_.sessions.erase(id_); // before all for which there may be no memory: it ends once
    on_unsubscribe();
    core_.counters.outboxes += outbox_.counters();
    outbox_.clear(); // what waited is released now, not when the connection goes
    ++core_.counters.sessions_closed[std::string(reason)];
    const std::chrono::duration<double> open = std::chrono::steady_clock::now() - opened_;
    core_.log(fmt::format("event=session_closed session={} peer={} reason={} why={} "
                          "open_s={:.1f} messages_sent={} bytes_sent={}",
                          id_, peer_.name, reason, in_quotes(printable(why)), open.count(),
                          messages_sent_, bytes_sent_));
}

} // namespace seaway::server
