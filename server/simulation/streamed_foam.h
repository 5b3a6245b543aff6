// SPDX-License-Identifier: Apache-2.0
// Streamed foam: which cascades' streams carry foam. Foam is a history, and one that starts walks
// through hundreds of ticks. It does so beside the stream, slice by slice; until it has come to where
// the stream is, the stream goes on for those who want no foam there.
//
// A start is two walks: to the keyframe of now, from where questions about now go on too, and from
// there to where the stream has come meanwhile. What time passes during the second one is left to
// the stream itself, so that a start ends on any machine. For one thread.
#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "server/simulation/effect_plan.h"
#include "server/simulation/keyframe_source.h"
#include "server/simulation/schedule.h"

namespace seaway::server {

class StreamedFoam {
  public:
    /// A start that there is no memory for is tried again so much later; until then its stream goes on without foam.
    static constexpr std::chrono::milliseconds pause{500};

    /// `warn` is told of each start that has to wait for memory, once.
    StreamedFoam(const RunningSea& sea, KeyframeSource& source, const Schedule& schedule,
                 std::function<void(const std::string&)> warn)
        : source_(source), schedule_(schedule), warn_(std::move(warn)),
          cascades_(sea.budget.cascades.size()) {}

    /// The plan with foam where the stream carries it; elsewhere what they want who want no foam.
    /// Starts foam where the plan has it and the stream does not.
    EffectPlan carried(EffectPlan plan, const Subscriptions& subscriptions, sea::TimeUs now_us);

    /// Foam of one of these cascades is on its way: whoever waits for it will find it made.
    bool starts(const Demand& demand) const;

    /// One slice of a start; false: none is under way, or all of them wait for memory.
    bool walk(sea::TimeUs now_us);
    /// Some wait: to be asked again after a `pause`.
    bool pauses() const;

  private:
    enum class State { none, to_now, to_stream, carried };
    struct Cascade {
        State state = State::none;
        sea::TimeUs goal_us = 0;
        std::chrono::steady_clock::time_point pauses_until = {};
        bool told = false; ///< that it waits

        bool starts() const { return state == State::to_now || state == State::to_stream; }
    };

    KeyframeSource& source_;
    const Schedule& schedule_;
    std::function<void(const std::string&)> warn_;
    std::vector<Cascade> cascades_;
};

} // namespace seaway::server
