// SPDX-License-Identifier: Apache-2.0
// What Client's blocking calls wait with (client.cpp, client_fetch.cpp).
#pragma once

#include <memory>
#include <set>
#include <tuple>
#include <utility>

#include "client/client.h"
#include "client/link/waiter.h"

namespace seaway::client {

/// Keyframes are offered to it as they come, those around its times stay. For as long as it lives;
/// Client::mutex_ guards it until its fetches are done.
class Client::Wanted {
  public:
    explicit Wanted(Client& client);
    ~Wanted();
    Wanted(const Wanted&) = delete;
    Wanted& operator=(const Wanted&) = delete;

    /// Wants the keyframes around this time: takes them where the ring holds them all, with
    /// `fields`. False: they have to be fetched.
    bool add(const SeaState& state, sea::TimeUs time_us, sea::FieldSet fields);
    void offer(const HeldKeyframePtr& keyframe);
    /// What was held longest goes first from a ring: this makes all of it new, with these fields where they came.
    void give_to(KeyframeRing& ring, sea::FieldSet fields) const;

    /// The sea is another one: what was wanted is not. With Client::mutex_ held.
    void forget() {
        keys_.clear();
        ring_.clear();
    }

    const KeyframeRing& ring() const { return ring_; }

  private:
    using Key = std::tuple<std::uint32_t, int, sea::TimeUs>; ///< epoch, cascade, time
    /// It takes what it wants alone, so this bounds nothing.
    static constexpr RingLimits unbounded{std::numeric_limits<std::size_t>::max(),
                                          std::numeric_limits<std::size_t>::max()};

    Client& client_;
    std::set<Key> keys_;
    KeyframeRing ring_{unbounded};
};

} // namespace seaway::client
