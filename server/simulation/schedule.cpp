// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/schedule.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <tuple>

#include "server/host/grant.h"

namespace seaway::server {

using sea::TimeUs;

namespace {

/// What has to be made of a sea: beside what is asked for what follows in the seas that it was granted for, and not in this one.
sea::FieldSet to_make_of(const Demand& demand, const RunningSea& sea) {
    return demand.fields |
           demand.follows.without(follows_of(sea.budget, sea.streamed(), demand.quality));
}

} // namespace

TimeUs interval_start(TimeUs time_us, TimeUs interval_us) {
    const TimeUs rest = time_us % interval_us;
    return time_us - (rest < 0 ? rest + interval_us : rest);
}

TimeUs next_meeting(TimeUs time_us, std::span<const TimeUs> intervals_us) {
    TimeUs together_us = 1;
    for (const TimeUs interval_us : intervals_us) {
        together_us = std::lcm(together_us, interval_us);
        if (together_us > meeting_us_max)
            return time_us;
    }
    return interval_start(time_us + together_us - 1, together_us);
}

std::vector<KeyframeRequest>
keyframes_around(const SeaCourse& course, std::span<const TimeUs> times_us, const Demand& demand) {
    return keyframes_around(
        [&](TimeUs time_us) {
            const RunningSeaPtr sea = course.at(time_us);
            return SeaOfTime{sea->epoch, sea};
        },
        times_us, demand);
}

std::vector<KeyframeRequest> keyframes_around(const std::function<SeaOfTime(TimeUs)>& sea_of,
                                              std::span<const TimeUs> times_us,
                                              const Demand& demand) {
    std::vector<KeyframeRequest> wanted;
    for (const TimeUs time_us : times_us) {
        SEAWAY_CHECK(sea::in_time_range(time_us), "such a time is refused where it is asked");
        const auto [epoch, sea] = sea_of(time_us);
        for (int c = 0; c < static_cast<int>(sea->budget.cascades.size()); ++c) {
            if (!demand.wants(c))
                continue;
            const TimeUs interval_us =
                sea->budget.cascades[static_cast<std::size_t>(c)].interval_us;
            const TimeUs start_us = interval_start(time_us, interval_us);
            for (const TimeUs t_us : {start_us, start_us + interval_us})
                wanted.push_back({c, t_us, to_make_of(demand, *sea), epoch});
        }
    }
    const auto order = [](const KeyframeRequest& r) {
        return std::tuple(r.cascade, r.time_us, r.epoch);
    };
    std::ranges::sort(wanted, {}, order);
    // Not that of std::ranges: clang 14, which builds the fuzzers, cannot read what it returns.
    const auto same = [&](const KeyframeRequest& a, const KeyframeRequest& b) {
        return order(a) == order(b);
    };
    wanted.erase(std::unique(wanted.begin(), wanted.end(), same), wanted.end());
    return wanted;
}

Schedule::Schedule(const SeaCourse& course)
    : course_(course), streams_(course.first()->budget.cascades.size()) {}

Schedule::Place Schedule::place(RunningSeaPtr sea, Lane lane, TimeUs time_us) {
    const sea::CascadeBudget& budget = sea->budget.cascades[lane.cascade];
    const TimeUs interval_us =
        sea::every_for(budget, rate_rungs_hz[lane.rate]) * budget.interval_us;
    return {std::move(sea), interval_us, interval_start(time_us, interval_us)};
}

Schedule::Place Schedule::around(Lane lane, TimeUs now_us) const {
    return place(course_.at(now_us), lane, now_us);
}

std::optional<Schedule::Place> Schedule::next_of_main(const Stream& stream) const {
    const Place& last = stream.main;
    if (last.time_us >= course_.window(last.sea->epoch).end_us)
        return std::nullopt;
    return Place{last.sea, last.interval_us, last.time_us + last.interval_us};
}

std::optional<Schedule::Place> Schedule::next_of_following(const Stream& stream, Lane lane,
                                                           const std::optional<Place>& main) const {
    const EpochWindow window = course_.window(stream.main.sea->epoch);
    if (window.end_us == std::numeric_limits<TimeUs>::max())
        return std::nullopt;
    // Of one that another has taken over from before it began that is before its own start: rare streams are ahead of it.
    const TimeUs from_us = window.end_us;
    const std::uint32_t epoch = course_.window_at(from_us).epoch;
    if (stream.following && stream.following->sea->epoch == epoch) {
        const Place& last = *stream.following;
        return Place{last.sea, last.interval_us, last.time_us + last.interval_us};
    }
    RunningSeaPtr sea = course_.sea_if_held(epoch);
    if (!sea && main && main->interval_begins_us() < from_us - made_ahead_us_)
        return std::nullopt;
    return place(sea ? std::move(sea) : course_.sea(epoch), lane, from_us);
}

std::pair<Schedule::Place, Schedule::Stream> Schedule::next(const Stream& stream, Lane lane) const {
    const std::optional<Place> main = next_of_main(stream);
    if (!main && stream.following) // over: the other one is the stream
        return next(Stream{*stream.following}, lane);
    const std::optional<Place> following = next_of_following(stream, lane, main);
    SEAWAY_CHECK(main || following, "where one sea ends another follows");
    if (main && (!following || main->interval_begins_us() <= following->interval_begins_us()))
        return {*main, Stream{*main, stream.following}};
    return {*following, main ? Stream{stream.main, *following} : Stream{*following}};
}

Schedule::Stream Schedule::started(Lane lane, TimeUs now_us) const {
    Stream stream{around(lane, now_us)};
    stream.main.time_us -= stream.main.interval_us;
    for (;;) {
        const Stream then = next(stream, lane).second;
        const Place after = next(then, lane).first;
        if (due_us(after) > now_us || after.sea->epoch != stream.main.sea->epoch)
            return stream;
        stream = then;
    }
}

sea::FieldSet Schedule::fields_of(const CascadePlan& plan, Lane lane, const Place& place) {
    sea::FieldSet fields = plan.at(lane.rate);
    // Foam is a history that goes with every keyframe, not some intervals ahead of it.
    for (std::size_t rate = 0; rate < rate_rungs_hz.size() && lane.rate != 0; ++rate)
        if (Schedule::place(place.sea, {lane.cascade, rate}, place.time_us).time_us ==
            place.time_us)
            fields |= plan.at(rate).without({sea::Field::foam});
    return fields;
}

void Schedule::Due::add(const KeyframeRequest& keyframe, std::size_t rate) {
    std::size_t at = 0;
    while (at < keyframes.size() &&
           (keyframes[at].cascade != keyframe.cascade ||
            keyframes[at].time_us != keyframe.time_us || keyframes[at].epoch != keyframe.epoch))
        ++at;
    if (at == keyframes.size()) {
        keyframes.push_back(keyframe);
        rates.emplace_back();
    }
    keyframes[at].fields |= keyframe.fields;
    rates[at].set(rate);
}

void Schedule::take_due(const CascadePlan& plan, Lane lane, TimeUs now_us, Due& due) {
    std::optional<Stream>& running = streams_[lane.cascade][lane.rate];
    if (plan.at(lane.rate).empty()) {
        running.reset();
        return;
    }
    auto [place, then] = next(stream(lane, now_us), lane);
    if (now_us < due_us(place))
        return;
    if (place.time_us < now_us - catch_up_us_) {
        const Place resumed = around(lane, now_us);
        due.left_out += static_cast<std::uint64_t>(
            std::max<TimeUs>(resumed.time_us - place.time_us, 0) / place.interval_us);
        place = resumed;
        then = Stream{resumed};
    }
    due.add({static_cast<int>(lane.cascade), place.time_us, fields_of(plan, lane, place),
             place.sea->epoch},
            lane.rate);
    running = std::move(then);
}

Schedule::Due Schedule::take_due(const EffectPlan& plan, TimeUs now_us) {
    if (now_us < seen_us_)
        for (auto& lanes : streams_)
            lanes.fill(std::nullopt);
    seen_us_ = now_us;
    Due due;
    for (std::size_t rate = 0; rate < rate_rungs_hz.size(); ++rate)
        for (std::size_t c = 0; c < streams_.size(); ++c)
            take_due(plan.cascades[c], {c, rate}, now_us, due);
    return due;
}

std::optional<TimeUs> Schedule::next_due_us(const EffectPlan& plan) const {
    std::optional<TimeUs> next_us;
    for (std::size_t c = 0; c < streams_.size(); ++c)
        for (std::size_t rate = 0; rate < rate_rungs_hz.size(); ++rate) {
            const Lane lane{c, rate};
            if (plan.cascades[c].at(rate).empty() || !running(lane))
                continue;
            const TimeUs this_us = due_us(next(*running(lane), lane).first);
            next_us = std::min(next_us.value_or(this_us), this_us);
        }
    return next_us;
}

TimeUs Schedule::next_us(int cascade, TimeUs now_us) const {
    const Lane lane{static_cast<std::size_t>(cascade)};
    return next(stream(lane, now_us), lane).first.time_us;
}

std::vector<KeyframeRequest> Schedule::current(const Demand& demand, TimeUs now_us) const {
    std::vector<KeyframeRequest> wanted;
    for (std::size_t c = 0; c < streams_.size(); ++c) {
        if (!demand.wants(static_cast<int>(c)))
            continue;
        const Lane lane{c, rung_of(demand.quality).rate};
        // What a stream that had begun with now would have had by the time that this one is where it is.
        const Stream end = stream(lane, now_us);
        Stream at{around(lane, now_us)};
        at.main.time_us -= at.main.interval_us;
        const auto add = [&](const Place& place) {
            wanted.push_back({static_cast<int>(c), place.time_us, to_make_of(demand, *place.sea),
                              place.sea->epoch});
        };
        const auto has = [](const Stream& stream, const Place& place) {
            for (const Place& last : {stream.main, stream.following.value_or(stream.main)})
                if (last.sea->epoch == place.sea->epoch && place.time_us <= last.time_us)
                    return true;
            return place.sea->epoch < stream.main.sea->epoch;
        };
        for (;;) {
            const auto [place, then] = next(at, lane);
            if (!has(end, place))
                break;
            add(place);
            at = then;
        }
    }
    return wanted;
}

} // namespace seaway::server
