// SPDX-License-Identifier: Apache-2.0
#include "tests/server/net/simulated/ledger.h"

#include <algorithm>

#include "protocol/limits.h"
#include "tests/server/net/simulated/late_sea.h"

namespace seaway::tests::simulated {

using wire::Body;

Body Ledger::asks(std::span<const std::uint8_t> bytes) {
    const auto message = asked_.read(bytes);
    if (!message)
        return Body::NONE;
    const auto owes = [&](std::uint32_t request_id) {
        ++owed_[request_id];
        asked_for_[request_id].insert((*message)->body_type());
    };
    if (const auto* query = (*message)->body_as_Query())
        owes(query->request_id());
    else if (const auto* fetch = (*message)->body_as_Fetch())
        owes(fetch->request_id());
    else if (const auto* subscribe = (*message)->body_as_Subscribe())
        owes(subscribe->request_id());
    else if (const auto* spectrum = (*message)->body_as_SubscribeSpectrum())
        owes(spectrum->request_id());
    else if (const auto* ping = (*message)->body_as_Ping())
        ++pings_[ping->request_id()];
    else if (const auto* ack = (*message)->body_as_Ack())
        acknowledges(*ack);
    else if (const auto* stop = (*message)->body_as_Unsubscribe(); stop && stop->spectrum())
        chunks_left_ = 0; // none comes any more
    return (*message)->body_type();
}

void Ledger::acknowledges(const wire::Ack& ack) {
    unacknowledged_.erase(ack.keyframe());
    if (ack.also() != nullptr)
        for (const std::uint64_t keyframe : *ack.also())
            unacknowledged_.erase(keyframe);
}

void Ledger::told(std::span<const std::uint8_t> bytes, const std::optional<server::Demand>& grant,
                  const Publications& publications) {
    complete_ = std::nullopt;
    const auto message = read_.read(bytes);
    require(message.has_value() && protocol::check(**message).has_value(),
            "what the server writes is well formed");
    if (!message)
        return;
    const wire::Message& m = **message;
    judge_.count(wire::EnumNameBody(m.body_type()));
    if (m.body_type() == Body::Welcome) {
        require(!welcomed_, "a client is welcomed once");
        welcomed_ = true;
        return;
    }
    require(welcomed_, "nothing is said before Welcome");
    if (const auto* tile = m.body_as_Tile()) {
        told_tile(*tile, bytes.size(), grant, publications);
    } else if (const auto* done = m.body_as_FetchDone()) {
        told_done(*done);
    } else if (const auto* reply = m.body_as_QueryReply()) {
        settle(reply->request_id(), Body::Query);
    } else if (const auto* refused = m.body_as_Refused()) {
        judge_.count(fmt::format("Refused {}", protocol::name(refused->code())));
        settle(refused->request_id(), Body::NONE);
    } else if (const auto* subscribed = m.body_as_Subscribed()) {
        require(asked_for_[subscribed->request_id()].contains(Body::Subscribe),
                "Subscribed answers a Subscribe");
        credit_ = subscribed->credit();
    } else if (const auto* pong = m.body_as_Pong()) {
        require(pings_[pong->request_id()] > 0, "each Ping has one Pong");
        if (--pings_[pong->request_id()] <= 0)
            pings_.erase(pong->request_id());
    } else if (const auto* spectra = m.body_as_SpectrumSubscribed()) {
        settle(spectra->request_id(), Body::SubscribeSpectrum);
    } else if (const auto* spectrum = m.body_as_Spectrum()) {
        spectrum_epoch_ = spectrum->epoch();
        next_chunk_ = 0;
        chunks_left_ = spectrum->chunks();
    } else if (const auto* chunk = m.body_as_SpectrumChunk()) {
        told_chunk(*chunk);
    } else if (m.body_as_SeaState() != nullptr) {
        require(!states_.empty() && std::ranges::equal(*states_.front(), bytes),
                "sea states come all, and in order");
        if (!states_.empty())
            states_.pop_front();
    }
}

void Ledger::told_tile(const wire::Tile& tile, std::size_t bytes,
                       const std::optional<server::Demand>& grant,
                       const Publications& publications) {
    require(bytes <= protocol::limits::server_message_bytes_max, "tiles are of bounded size");
    if (!LateSea::is_streamed(tile.time_us())) {
        fetched_fields_[tile.keyframe()] |= 1u << static_cast<int>(tile.field());
        return;
    }
    if (tile.keyframe() != begun_) {
        require(tiles_left_ == 0, "a streamed keyframe that has begun is finished");
        begins(tile, grant, publications);
    }
    if (--tiles_left_ == 0) {
        complete_ = begun_;
        begun_ = 0;
        judge_.count("streamed keyframe");
    }
}

void Ledger::begins(const wire::Tile& tile, const std::optional<server::Demand>& grant,
                    const Publications& publications) {
    begun_ = tile.keyframe();
    require(unacknowledged_.size() < static_cast<std::size_t>(credit_),
            "no more keyframes under way than there is credit");
    unacknowledged_.insert(begun_);
    require(grant && grant->wants(tile.cascade()), "what nobody was granted is not streamed");
    tiles_left_ = (grant ? grant->fields.size() : 1) * tile.parts();
    const auto published = publications.find(begun_);
    require(published != publications.end(), "what is streamed was published");
    if (published == publications.end())
        return;
    require(!grant || grant->quality == published->second.quality,
            "a session is streamed its own quality");
    std::uint64_t& newest = newest_[{tile.epoch(), tile.cascade()}];
    require(published->second.turn > newest,
            "no keyframe comes after a newer one of its cascade and sea");
    newest = std::max(newest, published->second.turn);
    for (const auto& [number, other] : publications)
        require(other.turn <= published->second.turn ||
                    other.cascade != published->second.cascade ||
                    other.epoch != published->second.epoch ||
                    other.quality != published->second.quality || !grant ||
                    !other.fields.contains(grant->fields),
                "what begins is the newest there is of its sea");
    judge_.count("keyframe begun");
}

void Ledger::told_done(const wire::FetchDone& done) {
    std::size_t whole = 0;
    for (const auto& [number, fields] : fetched_fields_)
        whole += (fields & done.fields()) == done.fields() && done.fields() != 0 ? 1 : 0;
    if (done.fields() != 0)
        require(whole == done.keyframes(),
                fmt::format("FetchDone follows all that was fetched: {} whole keyframes of {}, {} "
                            "begun, fields {:#x}",
                            whole, done.keyframes(), fetched_fields_.size(), done.fields()));
    fetched_fields_.clear();
    const std::set<Body>& asked = asked_for_[done.request_id()];
    require(asked.contains(Body::Fetch) || asked.contains(Body::Subscribe),
            "FetchDone answers a Fetch or a Subscribe");
    settle(done.request_id(), Body::NONE);
}

void Ledger::told_chunk(const wire::SpectrumChunk& chunk) {
    require(chunk.epoch() == spectrum_epoch_ && chunk.chunk() == next_chunk_ && chunks_left_ > 0,
            "chunks follow their spectrum, each once and in order");
    ++next_chunk_;
    chunks_left_ -= chunks_left_ > 0 ? 1 : 0;
}

void Ledger::settle(std::uint32_t request_id, Body by) {
    require(by == Body::NONE || asked_for_[request_id].contains(by),
            "a reply is of the kind that was asked for");
    const auto owed = owed_.find(request_id);
    require(owed != owed_.end(), "a request is answered once");
    if (owed != owed_.end() && --owed->second == 0)
        owed_.erase(owed);
}

std::size_t Ledger::replies_owed() const {
    const auto count = [](const std::map<std::uint32_t, int>& owed) {
        std::size_t sum = 0;
        for (const auto& [id, replies] : owed)
            sum += static_cast<std::size_t>(std::max(replies, 0));
        return sum;
    };
    return count(owed_) + count(pings_);
}

std::string Ledger::owing() const {
    std::string kinds;
    for (const auto& [id, replies] : owed_)
        for (const Body kind : asked_for_.at(id))
            kinds += fmt::format(" {} {},", wire::EnumNameBody(kind), id);
    return fmt::format("{}:{} {} pongs, {} sea states, {} chunks", who_, kinds, pings_.size(),
                       states_.size(), chunks_left_);
}

std::uint64_t Ledger::newest(int cascade) const {
    std::uint64_t newest = 0;
    for (const auto& [of, turn] : newest_)
        if (of.second == cascade)
            newest = std::max(newest, turn);
    return newest;
}

} // namespace seaway::tests::simulated
