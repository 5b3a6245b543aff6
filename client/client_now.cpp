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

// Of a height that is a polynomial of second degree in so short a time no moment in between is further away than the further end.
Result<void> Client::add_clock(std::span<const QueryPoint> points, std::span<Answer> answers,
                               const Sampling& how) const {
    const TimeUs off_us = now_error_us();
    RecycledVector<QueryPoint> moved(points.begin(), points.end());
    RecycledVector<Answer> there(points.size());
    RecycledVector<double> further_m(points.size());
    std::ranges::fill(further_m, 0.0);
    for (const TimeUs by_us : {-off_us, off_us}) {
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
            further_m[i] = std::max(further_m[i], std::abs(then.height_m - here.height_m) +
                                                      std::max(then.error_m - here.error_m, 0.0));
        }
    }
    for (std::size_t i = 0; i < points.size(); ++i) {
        answers[i].error_m += further_m[i];
        if (!how.terms.empty())
            how.terms[i].clock_m = further_m[i];
    }
    return {};
}

} // namespace seaway::client
