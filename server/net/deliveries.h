// SPDX-License-Identifier: Apache-2.0
// Deliveries: keyframes and seas on their way to the sessions, one after the other, some sessions in each of the io
// thread's turns. Seas go first, as clients have to know them before they begin. Of the io thread alone.
#pragma once

#include <deque>
#include <utility>

#include "server/host/subscriptions.h"
#include "server/publish/keyframe_file.h"

namespace seaway::server {

class Core;

/// A keyframe of the stream, where it lies, and what says of which sea it is. Without a keyframe: a sea that is near
/// (Session::announce()).
struct Delivery {
    EncodedKeyframePtr keyframe;
    KeyframeFilePtr file = {}; ///< none: its messages are all there is
    protocol::SharedBytes sea_state = {};
};

class Deliveries {
  public:
    /// Of a turn, for each of several threads that send; one alone sends for as long as its turn is.
    static constexpr int sessions_a_turn = 8;

    explicit Deliveries(Core& core) : core_(core) {}

    /// To the sessions that are there when its turn comes. Keyframes that were added before come first.
    void add(Delivery keyframe) { add_to(keyframes_, std::move(keyframe)); }
    /// A sea that is near. What is added later comes to each session behind it, and a keyframe of it brings it along at the latest.
    void announce(protocol::SharedBytes sea_state) {
        add_to(seas_, {{}, {}, std::move(sea_state)});
    }

  private:
    struct Line {
        std::deque<Delivery> waiting;
        SessionId last = 0; ///< that has been sent the first of them
    };
    void add_to(Line& line, Delivery one);
    void turn();
    bool any() const { return !seas_.waiting.empty() || !keyframes_.waiting.empty(); }

    Core& core_;
    Line seas_, keyframes_;
};

} // namespace seaway::server
