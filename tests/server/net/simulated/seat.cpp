// SPDX-License-Identifier: Apache-2.0
#include "tests/server/net/simulated/seat.h"

#include <algorithm>

namespace seaway::tests::simulated {

using protocol::Bytes;
using protocol::SharedBytes;

namespace {

/// For GoAway (server/net/stream_connection.cpp).
constexpr sea::TimeUs close_deadline_us = 1'000'000;

Temper some_temper(Draw& draw) {
    return draw.one_of({Temper::honest, Temper::honest, Temper::honest, Temper::slow, Temper::stuck,
                        Temper::miser, Temper::hostile, Temper::mute});
}

} // namespace

Seat::Seat(server::Core& core, Judge& judge, Draw& draw, const Publications& publications,
           const std::string& name, std::string token, std::function<void()> settle)
    : core_(core), judge_(judge), draw_(draw), publications_(publications), name_(name),
      token_(std::move(token)), settle_(std::move(settle)), temper_(some_temper(draw)),
      pause_(draw.one_of({1u, 3u, 6u, 12u})), ledger_(judge, name) {
    bytes_per_s_ =
        temper_ == Temper::slow ? draw.log_uniform(300, 30'000) : draw.log_uniform(100'000, 1e8);
    delay_us_ = draw.whole(0, 120'000);
    buffer_bytes_ = draw.one_of({0u, 4096u, 65'536u});
    session_.emplace(core, *this,
                     server::Peer{.name = name, .address = core.addresses.of("::1", {})},
                     server::Standing::stranger);
}

void Seat::tell(const std::string& what) {
    judge_.tell(fmt::format("{:.3f} s {} {}", 1e-6 * static_cast<double>(now_us_), name_, what));
}

// ---- the link ------------------------------------------------------------------------------

void Seat::send_more() {
    while (writing_ == nullptr && !lost_) {
        const bool last = go_away_ != nullptr;
        writing_ = last ? std::exchange(go_away_, nullptr) : session_->next_message();
        if (writing_ == nullptr)
            return;
        judge_.require(last || !session_->ended(), name_ + ": an ended session sends nothing");
        judge_.count(last ? "GoAway" : "message handed out");
        judge_.digest(writing_->data(), writing_->size());
        std::optional<std::uint64_t> completes;
        if (!last) {
            ledger_.told(*writing_, core_.host.subscriptions().find(session_->id()), publications_);
            completes = ledger_.complete();
        }
        writing_since_us_ = now_us_;
        travelling_.push_back({writing_, writing_->size(), completes});
        travelling_bytes_ += writing_->size();
        written();
    }
}

/// It is written as soon as the buffer has taken it all.
void Seat::written() {
    if (writing_ != nullptr && travelling_bytes_ <= buffer_bytes_)
        writing_ = nullptr;
}

void Seat::close(SharedBytes go_away, wire::ErrorCode code, const std::string& why) {
    judge_.require(!closing_, name_ + ": a session is closed once");
    judge_.count(fmt::format("closed {}", protocol::name(code)));
    tell(fmt::format("is closed: {} ({})", protocol::name(code), why));
    closing_ = true;
    closing_since_us_ = now_us_;
    go_away_ = std::move(go_away);
    send_more();
}

/// Carries what it can; what there is room for then is written, and carried too.
void Seat::drain(sea::TimeUs passed_us) {
    allowance_ += bytes_per_s_ * 1e-6 * static_cast<double>(passed_us);
    while (travelling_bytes_ > 0 && allowance_ >= 1) {
        for (Travelling& one : travelling_) {
            const std::size_t carried = std::min(one.left, static_cast<std::size_t>(allowance_));
            allowance_ -= static_cast<double>(carried);
            travelling_bytes_ -= carried;
            if (one.left > 0 && one.left == carried)
                one.arrives_us = now_us_ + delay_us_;
            one.left -= carried;
        }
        written();
        send_more();
    }
    if (travelling_bytes_ == 0)
        allowance_ = 0; // a line that was idle carries no more for it
}

void Seat::come_to(sea::TimeUs now_us) {
    const sea::TimeUs passed_us = now_us - now_us_;
    now_us_ = now_us;
    if (opened_us_ < 0)
        opened_us_ = now_us;
    drain(opened_us_ == now_us ? 0 : passed_us);
    while (!lost_ && !travelling_.empty() && travelling_.front().left == 0 &&
           travelling_.front().arrives_us <= now_us) {
        const Travelling message = std::move(travelling_.front());
        travelling_.pop_front();
        arrived(message);
    }
    pass_deadlines();
    while (!lost_ && !closing_ && !asking_.empty() && session_->wants_requests())
        give_to_session();
}

void Seat::pass_deadlines() {
    const server::NetOptions& options = core_.options;
    const auto us = [](std::chrono::milliseconds ms) { return 1000 * ms.count(); };
    if (closing_ && ((writing_ == nullptr && travelling_.empty()) ||
                     now_us_ - closing_since_us_ >= close_deadline_us))
        lost_ = true;
    if (!lost_ && now_us_ - opened_us_ >= us(options.hello_deadline))
        session_->hello_overdue();
    if (!lost_ && writing_ != nullptr && now_us_ - writing_since_us_ >= us(options.write_timeout)) {
        tell("has not taken a message in time");
        judge_.count("write timeout");
        session_->end(protocol::name(wire::ErrorCode::too_slow), "simulated");
        lost_ = true;
    }
}

void Seat::give_to_session() {
    const Bytes bytes = std::move(asking_.front());
    asking_.pop_front();
    const bool was_greeted = session_->greeted();
    wire::Body asked = wire::Body::NONE;
    if (!session_->ended()) {
        asked = ledger_.asks(bytes);
        judge_.count("message taken");
    }
    if (!was_greeted)
        for (const SharedBytes& state : core_.host.sea_state_messages())
            ledger_.owes_state(state); // if this is the Hello; else the session ends with it
    session_->receive(bytes);
    if (asked == wire::Body::SubscribeSpectrum)
        settle_();
}

void Seat::cut() {
    tell("is cut");
    session_->end(server::disconnected, "simulated");
    lost_ = true;
}

void Seat::say_bye() {
    tell("closes");
    session_->end(server::closed_by_client, "simulated");
    lost_ = true;
}

void Seat::is_owed(const SharedBytes& state) {
    if (session_->greeted() && !session_->ended())
        ledger_.owes_state(state);
}

// ---- the peer ------------------------------------------------------------------------------

void Seat::arrived(const Travelling& message) {
    if (!message.completes || closing_)
        return;
    const bool hoards = temper_ == Temper::miser ? draw_.below(3) != 0 : draw_.below(3) == 0;
    if (hoards && !calm_)
        hoarded_.push_back(*message.completes);
    else if (temper_ == Temper::miser && !calm_)
        say(protocol::ack(*message.completes));
    else
        say_ack(*message.completes);
}

void Seat::say_ack(std::uint64_t keyframe) {
    // Those that were acknowledged by chance before they had come can be more than a window holds.
    constexpr std::size_t also_max = protocol::limits::keyframes_per_ack_max - 1;
    for (; hoarded_.size() > also_max; hoarded_.pop_back())
        say(protocol::ack(hoarded_.back()));
    std::vector<std::uint64_t> also = std::exchange(hoarded_, {});
    if (!also.empty())
        judge_.count("Ack of several");
    if (also.size() < also_max && draw_.below(4) == 0) // of one twice, or of anything
        also.push_back(draw_.below(2) == 0 ? keyframe : draw_.below(1000));
    say(protocol::ack(keyframe, also));
}

void Seat::calm_down() {
    calm_ = true;
    bytes_per_s_ = 1e9;
    if (!hoarded_.empty())
        say_ack(0);
}

void Seat::act() {
    if (lost_ || closing_ || calm_ || asking_.size() > 20)
        return;
    if (!said_hello_ && temper_ != Temper::mute) {
        said_hello_ = true;
        return say(protocol::hello(name_, draw_.below(20) == 0 ? "wrong" : token_));
    }
    if (temper_ == Temper::stuck && draw_.below(40) == 0)
        bytes_per_s_ = 0;
    if (temper_ == Temper::hostile && draw_.below(12) == 0)
        return say(nonsense());
    if (!hoarded_.empty() && draw_.below(10) == 0) {
        say(protocol::ack(hoarded_.back()));
        hoarded_.pop_back();
    }
    if (said_hello_ && draw_.below(pause_) == 0)
        say(something());
}

protocol::TileWish Seat::wish() {
    return {.cascades = draw_.one_of({1u, 2u, 3u, 3u, 7u, 4u}),
            .fields = sea::FieldSet::from_bits(static_cast<std::uint32_t>(draw_.below(1u << 13))),
            .error_m = draw_.one_of({0.0f, 0.02f, 0.5f})};
}

Bytes Seat::something() {
    const int credit = draw_.whole(protocol::limits::credit_min, protocol::limits::credit_max);
    switch (draw_.below(14)) {
    case 0:
    case 1:
        return protocol::subscribe(new_id(), wish(), credit);
    case 2:
        return protocol::unsubscribe(draw_.below(2) == 0);
    case 12:
    case 13:
        return protocol::subscribe_spectrum(
            new_id(), {.error_m = draw_.one_of({0.0f, 0.01f, 0.5f}),
                       .slope_error = draw_.one_of({0.0f, 0.005f}),
                       .fields = sea::FieldSet::from_bits(
                           static_cast<std::uint32_t>(draw_.below(1u << 13)))});
    case 3:
    case 4: {
        std::vector<sea::TimeUs> times(draw_.below(10));
        for (sea::TimeUs& time : times)
            time = draw_.whole(-1'000'000'000, 1'000'000'000);
        return protocol::fetch(new_id(), times, wish());
    }
    case 5:
        return protocol::ack(draw_.below(1000)); // of anything
    case 6:
    case 7:
        return protocol::ping(new_id(), now_us_);
    default: {
        std::vector<sea::QueryPoint> points(draw_.below(40) == 0 ? 300 : draw_.below(40));
        for (sea::QueryPoint& point : points)
            point = {draw_.uniform(-1e6, 1e6), draw_.uniform(-1e6, 1e6), now_us_};
        return protocol::query(new_id(), points, draw_.below(4) == 0);
    }
    }
}

Bytes Seat::nonsense() {
    Bytes bytes = something();
    switch (draw_.below(6)) {
    case 0:
        return protocol::hello("again", token_);
    case 3:
        return protocol::ack(1,
                             std::vector<std::uint64_t>(protocol::limits::keyframes_per_ack_max));
    case 1:
        return protocol::go_away(wire::ErrorCode::none, "I am the server");
    case 2:
        bytes.resize(draw_.below(bytes.size()));
        return bytes;
    default:
        for (int flips = draw_.whole(1, 6); flips > 0; --flips)
            bytes[draw_.below(bytes.size())] ^= static_cast<std::uint8_t>(1u << draw_.below(8));
        return bytes;
    }
}

} // namespace seaway::tests::simulated
