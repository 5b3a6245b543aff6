// SPDX-License-Identifier: Apache-2.0
#include "client/link/connection.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "client/link/clock.h"
#include "client/link/failure.h"
#include "protocol/spectrum_codec.h"

namespace seaway::client {

namespace {

std::string text(const flatbuffers::String* string) {
    return string ? string->str() : std::string();
}

/// Of two servers, or of one before and after its libraries were renewed, each is off by what it says.
bool same_probes(const std::vector<sea::Probe>& a, const std::vector<sea::Probe>& b) {
    const auto near = [](double one, double other) {
        return std::abs(one - other) <= 2 * sea::probe_error_m;
    };
    return std::ranges::equal(a, b, [&](const sea::Probe& one, const sea::Probe& other) {
        return one.x_m == other.x_m && one.y_m == other.y_m && one.time_us == other.time_us &&
               near(one.height_m, other.height_m) &&
               near(one.displacement_x_m, other.displacement_x_m) &&
               near(one.displacement_y_m, other.displacement_y_m);
    });
}

} // namespace

bool same_tiles(const SeaState& a, const SeaState& b) {
    return std::ranges::equal(a.cascades, b.cascades, [](const auto& one, const auto& other) {
        return one.size == other.size && one.length_m == other.length_m;
    });
}

bool same_waves(const SeaState& a, const SeaState& b) {
    if (!same_probes(a.probes, b.probes) || a.glide.has_value() != b.glide.has_value())
        return false;
    return !a.glide || (a.glide->end_us == b.glide->end_us &&
                        (a.glide->leads_to.empty() || b.glide->leads_to.empty() ||
                         same_probes(a.glide->leads_to, b.glide->leads_to)));
}

/// The same wish of a client that brings maps to their own grids.
protocol::TileWish compact(protocol::TileWish wish) {
    wish.compact = true;
    return wish;
}

std::int64_t deadline_us(double timeout_s) {
    return local_now_us() + static_cast<std::int64_t>(timeout_s * 1e6);
}

Connection::Connection(ConnectionEvents events)
    : events_(std::move(events)), requests_([this](std::uint32_t, protocol::Bytes message) {
          return send(std::move(message));
      }) {}

Connection::~Connection() {
    if (stream_ && !open_) // of an attempt that is given up nobody waits for the peer
        stream_->drop();
}

bool Connection::send(protocol::Bytes message) {
    return stream_ && stream_->send(std::move(message));
}

void Connection::fetch(std::span<const sea::TimeUs> times_us, const protocol::TileWish& wish,
                       double timeout_s, ReplyHandler handler) {
    if (times_us.empty() || times_us.size() > welcome_.times_per_fetch_max)
        return handler(failed(Failure::bad_argument,
                              fmt::format("{} times in one fetch, the server takes 1 to {}",
                                          times_us.size(), welcome_.times_per_fetch_max)));
    requests_.start(
        Lane::bulk,
        [&](std::uint32_t request_id) {
            return protocol::fetch(request_id, times_us, compact(wish));
        },
        deadline_us(timeout_s), std::move(handler), wish.fields);
}

void Connection::subscribe_spectrum(const protocol::SpectrumWish& wish, double timeout_s,
                                    ReplyHandler handler) {
    spectra_wanted_ = true;
    requests_.start(
        Lane::spectrum,
        [&](std::uint32_t request_id) { return protocol::subscribe_spectrum(request_id, wish); },
        deadline_us(timeout_s), std::move(handler));
}

void Connection::unsubscribe_spectrum() {
    spectra_wanted_ = false;
    send(protocol::unsubscribe(true));
    // What was to come of waves comes no more, and nobody says so: its place would be taken for ever.
    requests_.abandon(Lane::spectrum, failed(Failure::refused, "unsubscribed meanwhile"));
}

// ---- the connection's thread -----------------------------------------------------------------

void Connection::on_message(std::span<const std::uint8_t> bytes) {
    const Result<const wire::Message*> message = reader_.read(bytes);
    Result<void> fine = message ? dispatch(**message) : Result<void>(message.error());
    if (!fine)
        stream_->close(
            fmt::format("the server sent what this client cannot read: {}", fine.error().message));
}

Result<void> Connection::dispatch(const wire::Message& message) {
    using wire::Body;
    const Body kind = message.body_type();
    // Of a sea whose time was not said nothing could be made.
    if (!welcomed_ && kind != Body::Welcome && kind != Body::GoAway && kind <= Body::MAX)
        return Error{fmt::format("{} before the welcome", wire::EnumNameBody(kind))};
    switch (kind) { // no default: a new kind must be thought of
    case Body::Welcome:
        return take(*message.body_as_Welcome());
    case Body::SeaState:
        return take(*message.body_as_SeaState());
    case Body::Subscribed:
        return take(*message.body_as_Subscribed());
    case Body::Tile:
        return take(*message.body_as_Tile());
    case Body::QueryReply:
        return take(*message.body_as_QueryReply());
    case Body::FetchDone:
        return take(*message.body_as_FetchDone());
    case Body::SpectrumSubscribed:
        return take(*message.body_as_SpectrumSubscribed());
    case Body::Spectrum:
        return take(*message.body_as_Spectrum());
    case Body::SpectrumChunk:
        return take(*message.body_as_SpectrumChunk());
    case Body::Changed:
        return take(*message.body_as_Changed());
    case Body::Administered:
        return take(*message.body_as_Administered());
    case Body::Pace:
        return take(*message.body_as_Pace());
    case Body::Pong:
        return take(*message.body_as_Pong());
    case Body::Refused:
        take(*message.body_as_Refused());
        break;
    case Body::GoAway:
        return take(*message.body_as_GoAway());
    case Body::NONE: // the reader lets none of these through
    case Body::Hello:
    case Body::Subscribe:
    case Body::Unsubscribe:
    case Body::Ack:
    case Body::Fetch:
    case Body::Query:
    case Body::Ping:
    case Body::SubscribeSpectrum:
    case Body::Change:
    case Body::Administer:
        break;
    }
    return {}; // kinds of later versions are skipped
}

Result<void> Connection::take(const wire::Welcome& welcome) {
    SEAWAY_TRY(protocol::check(welcome));
    const std::int64_t now_us = local_now_us();
    if (events_.on_clock)
        events_.on_clock(hello_sent_us_, now_us, protocol::sea_time(welcome));
    const std::scoped_lock lock(opening_mutex_);
    if (welcomed_)
        return Error{"a second welcome"};
    welcome_ = {welcome.session(), text(welcome.server()), welcome.points_per_query_max(),
                welcome.exact_points_per_query_max(), welcome.times_per_fetch_max()};
    acknowledgements_.begin(welcome.keyframes_per_ack_max());
    welcomed_ = true;
    opening_.notify_all();
    return {};
}

Result<void> Connection::take(const wire::SeaState& state) {
    SEAWAY_TRY(protocol::check(state));
    const auto value = std::make_shared<const SeaState>(protocol::values(state));
    // What is held of an epoch is sampled with whatever comes later of it.
    if (const SeaStatePtr known = sea_state(value->epoch); known && !same_tiles(*known, *value))
        return Error{
            fmt::format("a sea state replaces epoch {} by one of other cascades", value->epoch)};
    std::erase_if(sea_states_,
                  [&](const SeaStatePtr& held) { return held->epoch == value->epoch; });
    sea_states_.push_back(value);
    if (sea_states_.size() > protocol::limits::sea_states_held)
        sea_states_.erase(sea_states_.begin());
    if (events_.on_sea_state)
        events_.on_sea_state(value);
    const std::scoped_lock lock(opening_mutex_);
    sea_known_ = true;
    opening_.notify_all();
    return {};
}

SeaStatePtr Connection::sea_state(std::uint32_t epoch) {
    const auto found = std::ranges::find(sea_states_, epoch, &SeaState::epoch);
    if (found == sea_states_.end())
        return nullptr;
    // The running one is told once, and used all the time.
    std::rotate(found, found + 1, sea_states_.end());
    return sea_states_.back();
}

Result<void> Connection::take(const wire::Subscribed& subscribed) {
    SEAWAY_TRY(protocol::check(subscribed));
    Grant grant;
    grant.cascades = subscribed.cascades();
    grant.fields = sea::FieldSet::from_bits(subscribed.fields());
    grant.error_m = subscribed.error_m();
    grant.credit = subscribed.credit();
    grant.why = text(subscribed.why());
    if (const wire::TileLimits* limits = subscribed.limits()) {
        grant.rate_hz_max = limits->rate_hz();
        grant.size_max = static_cast<int>(limits->size());
    }
    streamed_fields_ = grant.fields;
    send_ack(acknowledgements_.granted(grant.credit));
    requests_.note_grant(subscribed.request_id(), grant);
    if (events_.on_grant)
        events_.on_grant(grant);
    return {};
}

Result<void> Connection::take(const wire::Tile& tile) {
    SEAWAY_TRY(protocol::check(tile));
    const protocol::TileHeader header = protocol::header(tile);
    const SeaStatePtr state = sea_state(header.epoch);
    if (!state || static_cast<std::size_t>(header.cascade) >= state->cascades.size())
        return Error{fmt::format("a tile of cascade {} in epoch {}, which no sea state announced",
                                 header.cascade, header.epoch)};
    const auto& cascade = state->cascades[static_cast<std::size_t>(header.cascade)];
    const std::vector<sea::FieldSet> requested = requests_.bulk_fields();
    const Result<TileAssembly::Added> added =
        assembly_.add(header, {tile.payload()->data(), tile.payload()->size()}, cascade,
                      state->depth_m, streamed_fields_, requested, state->wave_law);
    if (!added)
        return added.error();
    if (added->unpredicted) {
        if (std::exchange(last_unpredicted_, header.keyframe) == header.keyframe)
            return {}; // its other map
        ++unpredicted_;
        subscribe_unpredicted();
        send_ack(acknowledgements_.complete(header.keyframe));
        return {};
    }
    if (added->acknowledge)
        send_ack(acknowledgements_.complete(header.keyframe));
    if (added->complete && events_.on_keyframe)
        events_.on_keyframe(added->complete);
    return {};
}

void Connection::send_ack(std::optional<protocol::Bytes> ack) {
    // One that is missing would take its keyframes' places in the window for ever.
    if (ack && !send(std::move(*ack)))
        stream_->close(fmt::format("the server takes nothing: {} bytes and more wait for it",
                                   MessageStream::waiting_bytes_max));
}

Result<void> Connection::take(const wire::FetchDone& done) {
    Reply value;
    value.keyframes = done.keyframes();
    value.fields = sea::FieldSet::from_bits(done.fields());
    for (const HeldKeyframePtr& keyframe : assembly_.finish(value.fields))
        if (events_.on_keyframe)
            events_.on_keyframe(keyframe);
    if (!requests_.finish(Lane::bulk, done.request_id(), std::move(value)))
        return Error{fmt::format("the end of request {}, which is not open", done.request_id())};
    return {};
}

Result<void> Connection::take(const wire::SpectrumSubscribed& subscribed) {
    SEAWAY_TRY(protocol::check(subscribed));
    spectrum_request_ = subscribed.request_id();
    spectrum_grant_ = protocol::grant(subscribed);
    spectra_awaited_ = spectrum_grant_.spectra;
    if (spectra_awaited_ == 0)
        requests_.finish(Lane::spectrum, spectrum_request_, Reply{.spectrum = spectrum_grant_});
    return {};
}

Result<void> Connection::take(const wire::Spectrum& spectrum) {
    SEAWAY_TRY(protocol::check(spectrum));
    const protocol::SpectrumHead head = protocol::head(spectrum);
    const SeaStatePtr state = sea_state(head.epoch);
    if (!state)
        return Error{
            fmt::format("the spectrum of epoch {}, which no sea state announced", head.epoch)};
    spectrum_epoch_ = head.epoch;
    next_chunk_ = 0;
    chunks_ = head.chunks;
    spectrum_taken_ = spectra_wanted_; // else it was under way, or nobody ever asked
    if (spectrum_taken_ && events_.on_spectrum)
        events_.on_spectrum(state, head);
    if (chunks_ == 0) // a calm sea
        one_spectrum_less();
    return {};
}

Result<void> Connection::take(const wire::SpectrumChunk& chunk) {
    SEAWAY_TRY(protocol::check(chunk));
    if (chunk.epoch() != spectrum_epoch_ || chunk.chunk() != next_chunk_ || next_chunk_ >= chunks_)
        return Error{fmt::format("chunk {} of the spectrum of epoch {}: {} of {} of epoch {} comes",
                                 chunk.chunk(), chunk.epoch(), next_chunk_, chunks_,
                                 spectrum_epoch_)};
    ++next_chunk_;
    if (spectrum_taken_) {
        const Result<std::vector<sea::WaveBlock>> blocks =
            protocol::decode_spectrum({chunk.payload()->data(), chunk.payload()->size()});
        if (!blocks)
            return blocks.error();
        if (events_.on_waves)
            SEAWAY_TRY(events_.on_waves(chunk.epoch(), protocol::left(chunk), *blocks));
    }
    if (next_chunk_ == chunks_)
        one_spectrum_less();
    return {};
}

void Connection::one_spectrum_less() {
    if (spectra_awaited_ > 0 && --spectra_awaited_ == 0)
        requests_.finish(Lane::spectrum, spectrum_request_, Reply{.spectrum = spectrum_grant_});
}

Result<void> Connection::take(const wire::Pong& pong) {
    SEAWAY_TRY(protocol::check(pong));
    const std::int64_t sent_us = pong.client_time_us(), now_us = local_now_us();
    if (sent_us < hello_sent_us_ || sent_us > now_us)
        return Error{fmt::format("a pong to a ping of {} us, when none was sent", sent_us)};
    if (events_.on_clock)
        events_.on_clock(sent_us, now_us, protocol::sea_time(pong));
    return {};
}

Result<void> Connection::take(const wire::Pace& pace) {
    SEAWAY_TRY(protocol::check(pace));
    if (events_.on_pace)
        events_.on_pace(protocol::pace(pace));
    return {};
}

void Connection::take(const wire::Refused& refused) {
    const Failure failure =
        refused.code() == wire::ErrorCode::too_large ? Failure::too_large : Failure::refused;
    Error why = failed(failure, fmt::format("refused ({}): {}", protocol::name(refused.code()),
                                            text(refused.message())));
    why.retry_after_ms = refused.retry_after_ms();
    requests_.refuse(refused.request_id(), why);
}

void Connection::on_tick() {
    if (!open_)
        return;
    const std::int64_t now_us = local_now_us();
    requests_.expire(now_us);
    if (events_.on_tick)
        events_.on_tick();
    if (now_us < next_ping_us_)
        return;
    ++pings_;
    next_ping_us_ = now_us + pause_after_ping_us(pings_);
    send(protocol::ping(pings_, now_us));
}

} // namespace seaway::client
