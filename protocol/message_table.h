// SPDX-License-Identifier: Apache-2.0
// The kinds of messages, one table row each: the number in the union, frozen, and who may send it.
// A kind that is added to the schema does not compile without its row; tests walk the table, and
// the table of docs/protocol.md repeats it. Thread-safe: constants only.
#pragma once

#include <array>

#include "protocol/seaway_generated.h"

namespace seaway::protocol {

/// Who wrote the bytes of a message: decides its size limit and which kinds are legal.
enum class Sender { client, server };

struct MessageInfo {
    wire::Body body;
    Sender sender;
};

inline constexpr std::array message_table{
    MessageInfo{wire::Body::Hello, Sender::client},
    MessageInfo{wire::Body::Subscribe, Sender::client},
    MessageInfo{wire::Body::Unsubscribe, Sender::client},
    MessageInfo{wire::Body::Ack, Sender::client},
    MessageInfo{wire::Body::Fetch, Sender::client},
    MessageInfo{wire::Body::Query, Sender::client},
    MessageInfo{wire::Body::Ping, Sender::client},
    MessageInfo{wire::Body::Welcome, Sender::server},
    MessageInfo{wire::Body::SeaState, Sender::server},
    MessageInfo{wire::Body::Subscribed, Sender::server},
    MessageInfo{wire::Body::Tile, Sender::server},
    MessageInfo{wire::Body::QueryReply, Sender::server},
    MessageInfo{wire::Body::FetchDone, Sender::server},
    MessageInfo{wire::Body::Pong, Sender::server},
    MessageInfo{wire::Body::Refused, Sender::server},
    MessageInfo{wire::Body::GoAway, Sender::server},
    MessageInfo{wire::Body::SubscribeSpectrum, Sender::client},
    MessageInfo{wire::Body::SpectrumSubscribed, Sender::server},
    MessageInfo{wire::Body::Spectrum, Sender::server},
    MessageInfo{wire::Body::SpectrumChunk, Sender::server},
    MessageInfo{wire::Body::Change, Sender::client},
    MessageInfo{wire::Body::Administer, Sender::client},
    MessageInfo{wire::Body::Changed, Sender::server},
    MessageInfo{wire::Body::Administered, Sender::server},
    MessageInfo{wire::Body::Pace, Sender::server},
};

/// The row of a kind; null for NONE and for kinds of later versions.
inline constexpr const MessageInfo* find_message(wire::Body body) {
    const auto number = static_cast<std::size_t>(body);
    return number >= 1 && number <= message_table.size() ? &message_table[number - 1] : nullptr;
}

static_assert([] {
    for (std::size_t row = 0; row < message_table.size(); ++row)
        if (static_cast<std::size_t>(message_table[row].body) != row + 1)
            return false;
    return message_table.size() == static_cast<std::size_t>(wire::Body::MAX);
}());

} // namespace seaway::protocol
