// SPDX-License-Identifier: Apache-2.0
// Acknowledgements: which keyframes are complete and not acknowledged, and when that is said. One Ack says it of
// several, because each costs the server a read: as soon as they are half of the credit, so that the other half is
// on its way meanwhile and no clock is needed. With a credit of 2, the default, that is each keyframe at once.
//
// Fewer than the credit are ever held back, so that the server can always send another one, which brings the Ack. A
// grant may have a smaller credit than the one before, whose keyframes still count: it brings out what is held back.
//
// A plain value; for one thread.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "protocol/messages.h"

namespace seaway::client {

class Acknowledgements {
  public:
    /// What Welcome says: how many the server takes at a time. 0: one, it is from before there could be more.
    void begin(std::uint32_t keyframes_per_ack_max) {
        together_max_ = std::max(keyframes_per_ack_max, 1u);
    }

    /// A grant, of the same stream or of another one. The Ack to send now, if any is.
    std::optional<protocol::Bytes> granted(int credit) {
        together_ = std::clamp(static_cast<std::uint32_t>(credit) / 2, 1u, together_max_);
        return say();
    }

    /// All tiles of a keyframe have come. The Ack to send now, if any is.
    std::optional<protocol::Bytes> complete(std::uint64_t keyframe) {
        held_back_.push_back(keyframe);
        return held_back_.size() < together_ ? std::nullopt : say();
    }

    /// Complete, and not said.
    std::size_t held_back() const { return held_back_.size(); }

  private:
    std::optional<protocol::Bytes> say() {
        if (held_back_.empty())
            return std::nullopt;
        const std::span<const std::uint64_t> all(held_back_);
        protocol::Bytes ack = protocol::ack(all.front(), all.subspan(1));
        held_back_.clear();
        return ack;
    }

    std::uint32_t together_max_ = 1;
    std::uint32_t together_ = 1;
    std::vector<std::uint64_t> held_back_; ///< oldest first
};

} // namespace seaway::client
