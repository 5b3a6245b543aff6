// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/streamed_foam.h"

#include <algorithm>

#include <fmt/format.h>

namespace seaway::server {

using sea::Field;
using sea::TimeUs;

EffectPlan StreamedFoam::carried(EffectPlan plan, const Subscriptions& subscriptions,
                                 TimeUs now_us) {
    for (std::size_t c = 0; c < cascades_.size(); ++c) {
        const int cascade = static_cast<int>(c);
        CascadePlan& planned = plan.cascades[c];
        Cascade& foam = cascades_[c];
        if (!planned.fields.contains(Field::foam)) {
            foam.state = State::none;
            continue;
        }
        if (foam.state == State::none) {
            foam = {State::to_now, interval_start(now_us, planned.interval_us)};
            if (source_.foam_ticks_to(cascade, schedule_.next_us(cascade, now_us)) <= 1)
                foam.state = State::carried; // as it does from keyframe to keyframe
        }
        if (!foam.starts())
            continue;
        planned.fields &= subscriptions.wanted_without(cascade, Field::foam);
        planned.transforms = transforms_for(planned.all());
    }
    return plan;
}

bool StreamedFoam::starts(const Demand& demand) const {
    if (!demand.fields.contains(Field::foam))
        return false;
    for (std::size_t c = 0; c < cascades_.size(); ++c)
        if (demand.wants(static_cast<int>(c)) && cascades_[c].starts())
            return true;
    return false;
}

bool StreamedFoam::pauses() const {
    return std::ranges::any_of(cascades_, &Cascade::starts);
}

bool StreamedFoam::walk(TimeUs now_us) {
    const auto now = std::chrono::steady_clock::now();
    for (std::size_t c = 0; c < cascades_.size(); ++c) {
        Cascade& foam = cascades_[c];
        if (!foam.starts() || now < foam.pauses_until)
            continue;
        const int cascade = static_cast<int>(c);
        const Result<bool> there = source_.walk_streamed_foam(cascade, foam.goal_us);
        if (!there && !source_.failure()) {
            foam.pauses_until = now + pause;
            if (!std::exchange(foam.told, true) && warn_)
                warn_(fmt::format("foam of cascade {} does not start yet: {}", cascade,
                                  there.error().message));
            continue;
        }
        if (!there || !*there)
            return true; // the source remembers why there is no more
        if (foam.state == State::to_stream) {
            foam.state = State::carried;
            return true;
        }
        source_.share_streamed_foam(cascade);
        foam = {State::to_stream, schedule_.next_us(cascade, now_us)};
        return true;
    }
    return false;
}

} // namespace seaway::server
