// SPDX-License-Identifier: Apache-2.0
// Ledger: what one client has asked and been told, and what it may be told next. It is kept from the bytes
// alone, as they go in and out of the session, and holds each message against the promises of
// docs/protocol.md.
#pragma once

#include <deque>
#include <map>
#include <optional>
#include <set>

#include "protocol/messages.h"
#include "server/host/subscriptions.h"
#include "tests/server/net/simulated/judge.h"

namespace seaway::tests::simulated {

/// What has been published, for those who are sent it.
struct Published {
    std::uint64_t turn = 0; ///< counts up
    server::Quality quality = 0;
    int cascade = 0;
    sea::FieldSet fields;
    std::uint32_t epoch = 0;
};
using Publications = std::map<std::uint64_t, Published>; ///< by number of the keyframe

class Ledger {
  public:
    Ledger(Judge& judge, std::string who) : judge_(judge), who_(std::move(who)) {}

    /// The session is about to be given these bytes. What they ask for; NONE: they are no message.
    wire::Body asks(std::span<const std::uint8_t> bytes);
    /// It is to be told of this sea, in this order.
    void owes_state(protocol::SharedBytes state) { states_.push_back(std::move(state)); }
    /// The session has handed these out. `grant`: what it has just now.
    void told(std::span<const std::uint8_t> bytes, const std::optional<server::Demand>& grant,
              const Publications& publications);

    /// Of the last told(): the streamed keyframe that it was the end of.
    std::optional<std::uint64_t> complete() const { return complete_; }
    bool welcomed() const { return welcomed_; }
    bool owes_nothing() const {
        return replies_owed() == 0 && states_.empty() && chunks_left_ == 0;
    }
    /// Requests that were taken and are not answered.
    std::size_t replies_owed() const;
    std::string owing() const;
    /// Turn of the newest keyframe that was streamed of a cascade; 0: none.
    std::uint64_t newest(int cascade) const;

  private:
    void acknowledges(const wire::Ack& ack);
    void told_tile(const wire::Tile& tile, std::size_t bytes,
                   const std::optional<server::Demand>& grant, const Publications& publications);
    void begins(const wire::Tile& tile, const std::optional<server::Demand>& grant,
                const Publications& publications);
    void told_done(const wire::FetchDone& done);
    void told_chunk(const wire::SpectrumChunk& chunk);
    /// A reply that settles a request, which is then owed no other one.
    void settle(std::uint32_t request_id, wire::Body by);
    void require(bool kept, const std::string& promise) {
        judge_.require(kept, who_ + ": " + promise);
    }

    Judge& judge_;
    const std::string who_;
    protocol::MessageReader asked_{protocol::Sender::client};
    protocol::MessageReader read_{protocol::Sender::server};
    bool welcomed_ = false;
    std::map<std::uint32_t, int> owed_;                       ///< settling replies, by request
    std::map<std::uint32_t, std::set<wire::Body>> asked_for_; ///< kinds, by request
    std::map<std::uint32_t, int> pings_;
    std::deque<protocol::SharedBytes> states_;
    int credit_ = 0;
    std::set<std::uint64_t> unacknowledged_;
    std::uint64_t begun_ = 0; ///< streamed keyframe under way; 0: none
    int tiles_left_ = 0;      ///< of it
    std::map<std::pair<std::uint32_t, int>, std::uint64_t> newest_; ///< by epoch and cascade
    std::map<std::uint64_t, std::uint32_t> fetched_fields_;
    std::optional<std::uint64_t> complete_;
    std::uint32_t spectrum_epoch_ = 0; ///< of the one under way
    std::uint32_t next_chunk_ = 0;
    std::uint32_t chunks_left_ = 0;
};

} // namespace seaway::tests::simulated
