// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/schedule.h"

#include <algorithm>

namespace seaway::server {

using sea::TimeUs;

TimeUs interval_start(TimeUs time_us, TimeUs interval_us) {
    const TimeUs rest = time_us % interval_us;
    return time_us - (rest < 0 ? rest + interval_us : rest);
}

std::vector<KeyframeRequest> keyframes_around(const sea::ErrorBudget& budget,
                                              std::span<const TimeUs> times_us,
                                              const Demand& demand) {
    std::vector<KeyframeRequest> wanted;
    for (int c = 0; c < static_cast<int>(budget.cascades.size()); ++c) {
        if (!demand.wants(c))
            continue;
        const TimeUs interval_us = budget.cascades[static_cast<std::size_t>(c)].interval_us;
        std::vector<TimeUs> keyframes_us;
        for (const TimeUs time_us : times_us) {
            SEAWAY_CHECK(sea::in_time_range(time_us), "such a time is refused where it is asked");
            const TimeUs start_us = interval_start(time_us, interval_us);
            keyframes_us.insert(keyframes_us.end(), {start_us, start_us + interval_us});
        }
        std::sort(keyframes_us.begin(), keyframes_us.end());
        const auto end = std::unique(keyframes_us.begin(), keyframes_us.end());
        for (auto at = keyframes_us.begin(); at != end; ++at)
            wanted.push_back({c, *at, demand.fields});
    }
    return wanted;
}

Schedule::Schedule(const sea::ErrorBudget& budget) {
    for (const sea::CascadeBudget& cascade : budget.cascades)
        streams_.push_back({cascade.interval_us});
}

/// The first subscriber fetches for itself what comes before.
TimeUs Schedule::Stream::first_us(TimeUs now_us) const {
    return interval_start(now_us + lead_us(), interval_us);
}

Schedule::Due Schedule::take_due(const EffectPlan& plan, TimeUs now_us) {
    Due due;
    for (std::size_t c = 0; c < streams_.size(); ++c) {
        Stream& stream = streams_[c];
        const sea::FieldSet fields = plan.cascades[c].fields;
        const bool wanted = !fields.empty();
        if (wanted && !stream.runs)
            stream.next_us = stream.first_us(now_us);
        stream.runs = wanted;
        if (!wanted || now_us < stream.next_us - stream.lead_us())
            continue;
        if (stream.next_us < now_us - catch_up_us) {
            const TimeUs resumed_us = interval_start(now_us, stream.interval_us);
            due.left_out +=
                static_cast<std::uint64_t>((resumed_us - stream.next_us) / stream.interval_us);
            stream.next_us = resumed_us;
        }
        due.keyframes.push_back({static_cast<int>(c), stream.next_us, fields});
        stream.next_us += stream.interval_us;
    }
    return due;
}

std::optional<TimeUs> Schedule::next_due_us(const EffectPlan& plan) const {
    std::optional<TimeUs> next_us;
    for (std::size_t c = 0; c < streams_.size(); ++c) {
        if (plan.cascades[c].fields.empty())
            continue;
        const TimeUs due_us = streams_[c].next_us - streams_[c].lead_us();
        next_us = std::min(next_us.value_or(due_us), due_us);
    }
    return next_us;
}

TimeUs Schedule::next_us(int cascade, TimeUs now_us) const {
    const Stream& stream = streams_[static_cast<std::size_t>(cascade)];
    return stream.runs ? stream.next_us : stream.first_us(now_us);
}

std::vector<KeyframeRequest> Schedule::current(const Demand& demand, TimeUs now_us) const {
    std::vector<KeyframeRequest> wanted;
    for (std::size_t c = 0; c < streams_.size(); ++c) {
        const Stream& stream = streams_[c];
        if (!demand.wants(static_cast<int>(c)))
            continue;
        const TimeUs end_us = next_us(static_cast<int>(c), now_us);
        for (TimeUs t_us = interval_start(now_us, stream.interval_us); t_us < end_us;
             t_us += stream.interval_us)
            wanted.push_back({static_cast<int>(c), t_us, demand.fields});
    }
    return wanted;
}

} // namespace seaway::server
