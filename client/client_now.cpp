// SPDX-License-Identifier: Apache-2.0
// Client: the sea's time, what it may be off by, and what that costs the height of the water (decision 0062).
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "base/recycled.h"
#include "client/client.h"

namespace seaway::client {

using sea::Answer;
using sea::QueryPoint;
using sea::TimeUs;

namespace {

/// Moments that are asked about later than now: of a reply that was under way, of an estimate's other end, of a server that was
/// not sure of its sea for a while.
constexpr TimeUs paces_kept_us = protocol::limits::unsure_us_max;

} // namespace

void Client::take_times(ConnectionEvents& events, const JoiningPtr& joining) {
    events.on_clock = [this, joining](LocalUs sent_us, LocalUs received_us,
                                      const sea::SeaTime& said) {
        const Joining::Look look{sent_us, received_us, said.elapsed_us, said.unsure_us};
        ConnectionPtr over;
        {
            const std::scoped_lock lock(mutex_);
            if (!joining->joined)
                return joining->looks.push_back(look);
            if (what_is_lost(*joining, joining->told_epoch_max, look).empty())
                return hear(look);
            unsure_ = true; // of what is held this server says nothing
            if (joining_ == joining)
                over = connection_;
        }
        if (over) // who comes back finds another sea, and begins with it
            over->close("its sea is another one than before");
    };
    events.on_pace = [this, joining](const sea::Pace& pace) {
        std::unique_lock lock(mutex_);
        joining->paces.push_back(pace);
        if (joining->paces.size() > sea::paces_max)
            joining->paces.erase(joining->paces.begin());
        if (!joining->joined)
            return;
        paces_.add(pace);
        const bool back = show_where_it_is();
        lock.unlock();
        if (back)
            say_status();
    };
}

bool Client::show_where_it_is() {
    if (!paces_.are_far_behind(shown_us_, elapsed_held()))
        return false;
    ++seas_;
    shown_us_ = std::numeric_limits<TimeUs>::min();
    return true;
}

TimeUs Client::now_us() {
    const std::scoped_lock lock(mutex_);
    const TimeUs elapsed_us = clock_.now(local_now_us());
    paces_.forget_before(elapsed_us - paces_kept_us);
    // A pace that was heard of a little late changes what follows, not what was shown.
    shown_us_ = std::max(shown_us_, paces_.sea_time(elapsed_us));
    return shown_us_;
}

ClockStatus Client::clock() const {
    const std::scoped_lock lock(mutex_);
    return clock_.status(local_now_us());
}

TimeUs Client::now_error_us() const {
    const std::scoped_lock lock(mutex_);
    const LocalUs local_us = local_now_us();
    const ClockStatus clock = clock_.status(local_us);
    const double elapsed_us = clock.offset_us + static_cast<double>(local_us);
    const auto sea_time = [&](double us) { return paces_.sea_time(std::llround(us)); };
    const TimeUs shown_us = std::max(shown_us_, sea_time(elapsed_us - clock.slew_us));
    // A sea that runs faster is further off.
    return std::max(std::abs(sea_time(std::ceil(elapsed_us + clock.error_us)) - shown_us),
                    std::abs(shown_us - sea_time(std::floor(elapsed_us - clock.error_us))));
}

SeaMotion Client::motion_within(TimeSpan span, const Looking& looking) const {
    const std::scoped_lock lock(mutex_);
    const sea::WaveLaw fastest = fastest_law(sea_states_);
    SeaMotion motion;
    const auto add = [&](const SeaState& state, TimeUs time_us) {
        if (felt_cascades(state, looking) != 0)
            motion = motion.with(motion_of(state, time_us, fastest));
    };
    add(*sea_state_held(span.from_us), span.from_us);
    for (const SeaStatePtr& state : sea_states_)
        if (state->start_time_us > span.from_us && state->start_time_us < span.until_us)
            add(*state, state->start_time_us);
    return motion;
}

Result<void> Client::add_clock(std::span<const QueryPoint> points, std::span<Answer> answers,
                               const Sampling& how) const {
    const TimeUs off_us = now_error_us();
    if (points.empty())
        return {};
    const auto [first, last] = std::ranges::minmax_element(points, {}, &QueryPoint::time_us);
    const SeaMotion motion =
        motion_within({first->time_us - off_us, last->time_us + off_us + 1}, how.looking);
    const int each_way = looks_each_way(motion, sea::seconds_from_us(off_us));
    const auto looks = static_cast<std::size_t>(2 * each_way + 1);
    RecycledVector<QueryPoint> moved(points.begin(), points.end());
    RecycledVector<Answer> there(points.size());
    RecycledVector<double> heights_m(points.size() * looks); // all of a point together
    RecycledVector<double> less_sure_m(points.size());
    RecycledVector<std::uint32_t> folded(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        heights_m[i * looks + looks / 2] = answers[i].height_m;
        less_sure_m[i] = 0;
        folded[i] = answers[i].flags & sea::answer_folded;
    }
    for (std::size_t look = 0; look < looks; ++look) {
        if (look == looks / 2) // the answers themselves
            continue;
        const TimeUs by_us = off_us * (static_cast<TimeUs>(look) - each_way) / each_way;
        for (std::size_t i = 0; i < points.size(); ++i)
            moved[i].time_us =
                std::clamp(points[i].time_us + by_us, -sea::time_us_max, sea::time_us_max);
        SEAWAY_TRY(sample_from(ring_, surfaces_, moved, there,
                               {.parts = sea::AnswerParts::height,
                                .keyframes_first = how.keyframes_first,
                                .looking = how.looking,
                                .summed = how.summed}));
        for (std::size_t i = 0; i < points.size(); ++i) {
            const Answer &here = answers[i], &then = there[i];
            // What is no bound there is none of what lies in between.
            answers[i].flags |= then.flags & (sea::answer_extrapolated | sea::answer_stale);
            if (then.flags & sea::answer_open)
                answers[i].flags |= sea::answer_open | sea::answer_folded;
            folded[i] |= then.flags & sea::answer_folded;
            heights_m[i * looks + look] = then.height_m;
            less_sure_m[i] = std::max(less_sure_m[i], then.error_m - here.error_m);
        }
    }
    const double apart_s = sea::seconds_from_us(off_us) / each_way;
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (answers[i].flags & sea::answer_invalid)
            continue;
        const double further_m =
            furthest_m({&heights_m[i * looks], looks}, apart_s, motion, folded[i] != 0) +
            less_sure_m[i];
        answers[i].error_m += further_m;
        if (!how.terms.empty())
            how.terms[i].clock_m = further_m;
    }
    return {};
}

} // namespace seaway::client
