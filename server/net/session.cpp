// SPDX-License-Identifier: Apache-2.0
#include "server/net/session.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <new>

#include <fmt/format.h>

#include "protocol/limits.h"
#include "server/net/refusals.h"
#include "server/net/tokens.h"

namespace seaway::server {

namespace limits = protocol::limits;
using wire::ErrorCode;

namespace {

Error too_large() {
    return {ErrorCode::too_large,
            fmt::format("more than {} bytes of tiles: fetch fewer times or fields",
                        limits::fetch_bytes_max)};
}

Error tiles_wait() {
    Error busy{Refusal::busy, "fetched tiles that nobody has read yet fill the memory there is for "
                              "them, try again later"};
    busy.retry_after_ms = 1000;
    return busy;
}

} // namespace

Session::Session(Core& core, Link& link, Peer peer, Standing standing)
    : core_(core), link_(link), id_(core.next_session++), peer_(std::move(peer)),
      standing_(standing) {
    core_.sessions[id_] = this;
    ++core_.counters.sessions_opened;
}

Session::~Session() {
    end(disconnected, "connection dropped");
}

void Session::receive(std::span<const std::uint8_t> bytes) {
    if (closing_ || ended_)
        return;
    ++core_.counters.messages_received;
    core_.counters.bytes_received += bytes.size();
    const Result<const wire::Message*> message = reader_.read(bytes);
    if (!message)
        return close(ErrorCode::bad_message, message.error().message);
    const wire::Message& m = **message;
    if (!greeted_ && m.body_type() != wire::Body::Hello)
        return close(ErrorCode::hello_expected, "the first message must be Hello");
    switch (m.body_type()) {
    case wire::Body::Hello:
        return on_hello(*m.body_as_Hello());
    case wire::Body::Subscribe:
        return on_subscribe(*m.body_as_Subscribe());
    case wire::Body::Unsubscribe:
        return on_unsubscribe();
    case wire::Body::Ack:
        if (outbox_.acknowledge(m.body_as_Ack()->keyframe()))
            link_.send_more();
        return;
    case wire::Body::Fetch:
        return on_fetch(*m.body_as_Fetch());
    case wire::Body::Query:
        return on_query(*m.body_as_Query());
    case wire::Body::Ping:
        return on_ping(*m.body_as_Ping());
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
                     judged.why);
    if (!token.empty())
        standing_ = judged.standing;
    if (standing_ == Standing::stranger && !is_open(core_))
        return close(ErrorCode::unauthorised, "token missing or wrong");
    greeted_ = true;
    core_.log(fmt::format("event=session_open session={} peer={} client=\"{}\" administrator={}",
                          id_, peer_.name,
                          printable(hello.client() ? hello.client()->string_view() : ""),
                          standing_ == Standing::administrator));
    reply(protocol::welcome(id_, "seaway " SEAWAY_VERSION, core_.host.sea_time_us()));
    for (const protocol::SharedBytes& state : core_.host.sea_state_messages())
        announce(state);
}

void Session::on_subscribe(const wire::Subscribe& subscribe) {
    const std::uint32_t request_id = subscribe.request_id();
    if (const Result<void> fine = protocol::check(subscribe); !fine)
        return refuse(request_id, fine.error());
    if (fetches_in_flight_ + outbox_.fetches_waiting() >= limits::fetches_in_flight_max)
        return refuse(request_id, {ErrorCode::too_many_requests, "earlier fetches are not done"});
    const Demand wish{.cascades = subscribe.cascades(),
                      .fields = sea::FieldSet::from_bits(subscribe.fields()),
                      .error_m = subscribe.error_m(),
                      .compact = subscribe.compact()};
    on_unsubscribe();
    const Demand grant = core_.host.grant(wish);
    if (grant.empty())
        return refuse(request_id, {Refusal::not_offered, "this sea offers none of these fields"});
    core_.host.subscriptions().set(id_, grant);
    outbox_.set_credit(subscribe.credit());
    reply(protocol::subscribed(request_id,
                               {.cascades = grant.cascades,
                                .fields = grant.fields | grant.follows,
                                .error_m = grant.error_m},
                               subscribe.credit()));
    Demand start = grant;
    start.fields |= grant.follows;
    fetch(request_id, {}, start);
}

void Session::on_unsubscribe() {
    core_.host.subscriptions().erase(id_);
    outbox_.stop_stream();
}

void Session::on_fetch(const wire::Fetch& request) {
    const std::uint32_t request_id = request.request_id();
    if (const Result<void> fine = protocol::check(request); !fine)
        return refuse(request_id, fine.error());
    if (fetches_in_flight_ + outbox_.fetches_waiting() >= limits::fetches_in_flight_max)
        return refuse(request_id, {ErrorCode::too_many_requests, "earlier fetches are not done"});
    fetch(request_id, {request.times_us()->begin(), request.times_us()->end()},
          {.cascades = request.cascades(),
           .fields = sea::FieldSet::from_bits(request.fields()),
           .error_m = request.error_m(),
           .compact = request.compact()});
}

/// What a fetch brings, encoded keyframe by keyframe as it comes.
class Session::FetchJob : public std::enable_shared_from_this<FetchJob> {
  public:
    using GiveBack = std::function<void(Result<Encoded>)>;

    FetchJob(std::weak_ptr<Core> core, sea::FieldSet wanted, bool start, const Asker& session,
             GiveBack give_back)
        : core_(std::move(core)), wanted_(wanted), start_(start),
          asker_(session.about(wanted_here_)),
          give_back_(std::move(give_back)), encoded_{{}, wanted} {}

    /// Gone with the session, or once the fetch has ended for another reason.
    const Asker& asker() const { return asker_; }

    /// Host's answer, on any thread: encoding is for the encode thread.
    void bring(Result<FetchedPart> fetched) {
        const std::shared_ptr<Core> alive = core_.lock();
        if (alive == nullptr)
            return;
        if (!fetched)
            return end(fetched.error());
        const auto slice =
            [self = shared_from_this(),
             part = std::make_shared<Part>(Part{*std::move(fetched)})](Encoder& encoder) {
                try {
                    return self->encode(*part, encoder);
                } catch (const std::bad_alloc&) {
                    self->end(tiles_wait());
                    return true;
                }
            };
        EncodeWorker& encoding = alive->encoding;
        if (!(start_ ? encoding.submit_start(slice) : encoding.submit_fetched(slice)))
            end(Error{Refusal::busy, "too many fetches wait to be encoded already"});
    }

  private:
    struct Part {
        FetchedPart fetched;
        std::size_t done = 0;
    };

    /// EncodeWorker::Job.
    bool encode(Part& part, Encoder& encoder) {
        if (asker_.gone())
            return true;
        std::vector<KeyframeTiles>& tiles = part.fetched.tiles;
        if (part.done < tiles.size()) {
            KeyframeTiles& tile = tiles[part.done++];
            const sea::FieldSet follows = tile.follows & wanted_ & sea::following(wanted_);
            Result<EncodedKeyframePtr> one =
                encoder.encode(*tile.keyframe, tile.codec_error, tile.quality,
                               wanted_.without(follows), {tile.compact_size, tile.follows});
            tile.keyframe = nullptr;
            if (const Result<void> taken = one ? take(*one, follows) : one.error(); !taken) {
                encoded_.keyframes.clear(); // and their places
                end(taken.error());
                return true;
            }
        }
        if (part.done < tiles.size())
            return false;
        if (part.fetched.last)
            end(std::move(encoded_));
        return true;
    }

    Result<void> take(const EncodedKeyframePtr& one, sea::FieldSet follows) {
        bytes_ += message_bytes(*one, wanted_);
        if (bytes_ > limits::fetch_bytes_max)
            return too_large();
        if (start_)
            return keep(one, follows);
        const std::shared_ptr<Core> alive = core_.lock();
        const Room::Place place =
            alive ? alive->fetched_tiles->take(message_bytes(*one, wanted_)) : nullptr;
        if (!place)
            return tiles_wait();
        // Whoever holds the keyframe to send it holds its place too.
        const auto both = std::make_shared<std::pair<Room::Place, EncodedKeyframePtr>>(place, one);
        return keep(EncodedKeyframePtr(both, both->second.get()), follows);
    }

    Result<void> keep(const EncodedKeyframePtr& one, sea::FieldSet follows) {
        encoded_.fields = encoded_.fields & (one->fields | (follows & sea::following(one->fields)));
        encoded_.keyframes.push_back(one);
        return {};
    }

    /// Only the first end counts.
    void end(Result<Encoded> encoded) {
        if (ended_.exchange(true))
            return;
        wanted_here_ = nullptr;
        give_back_(std::move(encoded));
    }

    const std::weak_ptr<Core> core_;
    const sea::FieldSet wanted_;
    const bool start_;
    std::shared_ptr<const void> wanted_here_ = std::make_shared<char>();
    const Asker asker_;
    const GiveBack give_back_;
    std::atomic<bool> ended_ = false;
    Encoded encoded_; ///< of the encode thread
    std::size_t bytes_ = 0;
};

void Session::fetch(std::uint32_t request_id, std::vector<sea::TimeUs> times_us,
                    const Demand& demand) {
    ++fetches_in_flight_;
    ++core_.counters.fetches;
    FetchJob::GiveBack give_back = [core = core_.weak_from_this(), session = id_,
                                    request_id](Result<Encoded> encoded) {
        const std::shared_ptr<Core> alive = core.lock();
        if (alive == nullptr)
            return;
        alive->post([core, session, request_id, encoded = std::move(encoded)] {
            const std::shared_ptr<Core> here = core.lock();
            if (Session* found = here ? here->find(session) : nullptr)
                found->fetched(request_id, encoded);
        });
    };
    const auto job =
        std::make_shared<FetchJob>(core_.weak_from_this(), demand.fields, times_us.empty(),
                                   Asker(here_), std::move(give_back));
    core_.host.fetch({.times_us = std::move(times_us), .demand = demand, .asker = job->asker()},
                     [job](Result<FetchedPart> part) { job->bring(std::move(part)); });
}

void Session::fetched(std::uint32_t request_id, const Result<Encoded>& encoded) {
    --fetches_in_flight_;
    if (!encoded)
        return refuse(request_id, encoded.error());
    const auto& [keyframes, fields] = *encoded;
    auto done = std::make_shared<const protocol::Bytes>(
        protocol::fetch_done(request_id, static_cast<std::uint32_t>(keyframes.size()), fields));
    if (!outbox_.push_fetched(keyframes, fields, std::move(done)))
        return refuse(request_id, too_large());
    link_.send_more();
}

void Session::on_query(const wire::Query& query) {
    const std::uint32_t request_id = query.request_id();
    if (const Result<void> fine = protocol::check(query); !fine)
        return refuse(request_id, fine.error());
    if (queries_in_flight_ >= limits::queries_in_flight_max)
        return refuse(request_id,
                      {ErrorCode::too_many_requests,
                       fmt::format("{} queries are not answered yet", queries_in_flight_)});
    QueryBatch batch{.exact = query.exact(), .points = {}, .asker = Asker(here_)};
    if (query.points() != nullptr) {
        batch.points.reserve(query.points()->size());
        for (const wire::Point* point : *query.points())
            batch.points.push_back({point->x_m(), point->y_m(), point->time_us()});
    }
    ++queries_in_flight_;
    ++core_.counters.queries;
    core_.counters.query_points += batch.points.size();
    core_.host.query(std::move(batch), [core = core_.weak_from_this(), session = id_,
                                        request_id](Result<QueryAnswers> answers) {
        const std::shared_ptr<Core> alive = core.lock();
        if (alive == nullptr)
            return;
        alive->post([core, session, request_id, answers = std::move(answers)] {
            const std::shared_ptr<Core> here = core.lock();
            if (Session* found = here ? here->find(session) : nullptr)
                found->answered(request_id, answers);
        });
    });
}

void Session::answered(std::uint32_t request_id, const Result<QueryAnswers>& answers) {
    --queries_in_flight_;
    if (!answers)
        return refuse(request_id, answers.error());
    reply(protocol::query_reply(request_id, answers->epoch, answers->answers));
}

void Session::on_ping(const wire::Ping& ping) {
    reply(protocol::pong(ping.request_id(), ping.client_time_us(), core_.host.sea_time_us()));
}

bool Session::wants_requests() const {
    return outbox_.accepts_requests();
}

protocol::SharedBytes Session::next_message() {
    if (closing_ || ended_)
        return nullptr;
    protocol::SharedBytes message = outbox_.next();
    if (message != nullptr) {
        ++messages_sent_;
        bytes_sent_ += message->size();
        ++core_.counters.messages_sent;
        core_.counters.bytes_sent += message->size();
    }
    return message;
}

void Session::hello_overdue() {
    if (!greeted_)
        close(ErrorCode::hello_expected,
              fmt::format("no Hello within {} ms", core_.options.hello_deadline.count()));
}

void Session::deliver(const EncodedKeyframePtr& keyframe) {
    const std::optional<Demand> grant = core_.host.subscriptions().find(id_);
    if (!grant || closing_ || keyframe->quality != grant->quality ||
        !grant->wants(keyframe->cascade))
        return;
    // A keyframe computed for an earlier plan may lack what this session was granted: half a
    // keyframe is of no use to it.
    if (!keyframe->fields.contains(grant->fields))
        return;
    outbox_.push_keyframe(keyframe, grant->fields);
    link_.send_more();
}

void Session::announce(protocol::SharedBytes sea_state) {
    if (!greeted_ || closing_)
        return;
    if (!outbox_.push_durable(std::move(sea_state)))
        return close(ErrorCode::too_slow, "sea states wait and cannot be sent");
    link_.send_more();
}

void Session::reply(protocol::Bytes message) {
    outbox_.push_reply(std::make_shared<const protocol::Bytes>(std::move(message)));
    link_.send_more();
}

void Session::refuse(std::uint32_t request_id, const Error& why) {
    const ErrorCode code = wire_code(why);
    ++core_.counters.requests_refused[std::string(protocol::name(code))];
    reply(protocol::refused(request_id, code, why.message, why.retry_after_ms));
}

void Session::close(ErrorCode code, const std::string& why) {
    if (closing_ || ended_)
        return;
    closing_ = true;
    end(protocol::name(code), why);
    link_.close(std::make_shared<const protocol::Bytes>(protocol::go_away(code, why)), code, why);
}

void Session::end(std::string_view reason, std::string_view why) {
    if (ended_)
        return;
    ended_ = true;
    here_ = nullptr;
    on_unsubscribe();
    core_.sessions.erase(id_);
    core_.counters.outboxes += outbox_.counters();
    ++core_.counters.sessions_closed[std::string(reason)];
    const std::chrono::duration<double> open = std::chrono::steady_clock::now() - opened_;
    core_.log(fmt::format("event=session_closed session={} peer={} reason={} why=\"{}\" "
                          "open_s={:.1f} messages_sent={} bytes_sent={}",
                          id_, peer_.name, reason, printable(why), open.count(), messages_sent_,
                          bytes_sent_));
    outbox_ = Outbox(); // what waited is released now, not when the connection goes
}

} // namespace seaway::server
