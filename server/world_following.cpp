// SPDX-License-Identifier: Apache-2.0
// World: how it stands with a log that others write too, and what it says of that.
#include <algorithm>

#include <fmt/format.h>

#include "protocol/limits.h"
#include "server/world.h"

namespace seaway::server {

namespace {

/// Whether this sea is that of the others is looked up so often at most: thousands of clients ask for the time.
constexpr std::int64_t unsure_looks_apart_us = 100'000;

} // namespace

// sqrt(m2), of a sea of this height and period.
double vertical_mps(const sea::SeaStatistics& sea) {
    if (!(sea.zero_crossing_period_s > 0))
        return 0;
    return 5 * 0.25 * sea.significant_height_m * 2 * sea::pi / sea.zero_crossing_period_s;
}

Health health_of(bool healthy, Heartbeat::Clock::duration turn) {
    if (!healthy)
        return {false, "the simulation has failed"};
    if (turn < stuck_after)
        return {};
    return {false, fmt::format("the simulation has not come on for {} s",
                               std::chrono::duration_cast<std::chrono::seconds>(turn).count())};
}

void World::follow_by(std::function<Following()> follow) {
    const std::scoped_lock lock(mutex_);
    follow_ = std::move(follow);
}

void World::hand_over_by(HandOver hand_over) {
    const std::scoped_lock lock(mutex_);
    hand_over_ = std::move(hand_over);
}

void World::hand_over(const std::string& why, const std::string& why_in_general) {
    HandOver hand_over;
    {
        const std::scoped_lock lock(mutex_);
        hand_over = hand_over_;
    }
    if (hand_over)
        hand_over(why, why_in_general);
}

std::optional<Following> World::following() const {
    std::function<Following()> follow;
    {
        const std::scoped_lock lock(mutex_);
        follow = follow_;
    }
    if (!follow)
        return std::nullopt;
    Following now = follow();
    const RunningSeaPtr sea = sea_now();
    now.height_error_m = sea->budget.height_error_m;
    double most_mps = vertical_mps(sea->summary.realised);
    if (sea->glide) // a little more once it has ended
        most_mps = std::max(most_mps, vertical_mps(sea->glide->realised));
    now.vertical_mps = most_mps * clock_.moment().pace_permille / sea::pace_unit;
    return now;
}

sea::SeaTime World::sea_time() const {
    const std::int64_t now_us = local_now_us();
    if (now_us - unsure_looked_us_ >= unsure_looks_apart_us) {
        unsure_looked_us_ = now_us;
        const std::optional<Following> now = following();
        const bool unsure = now && !now->doubt().empty();
        const std::int64_t since_us = unsure_since_us_;
        // It has been told of all changes up to when it heard of the log last, whoever looked meanwhile.
        const std::int64_t heard_us =
            now_us -
            (unsure ? std::max(now->writing_us, now->journal.current ? 0 : now->journal.unheard_us)
                    : 0);
        unsure_since_us_ = !unsure ? 0 : since_us == 0 ? heard_us : std::min(since_us, heard_us);
    }
    const SeaMoment moment = clock_.moment();
    sea::SeaTime time(moment.now_us, moment.elapsed_us);
    if (const std::int64_t since_us = unsure_since_us_)
        time.unsure_us = std::max<std::int64_t>(now_us - since_us, 1);
    // The clock has leapt, or the process stood still: the sea that runs by now is told of in a moment. Clients take it that they are
    // told of a change some time before it begins.
    if (const sea::TimeUs told_us = told_until_us_; moment.now_us >= told_us) {
        const double untold_us = static_cast<double>(moment.now_us - told_us) * sea::pace_unit /
                                 std::max(moment.pace_permille, 1);
        constexpr auto most_us = static_cast<double>(protocol::limits::unsure_us_max);
        time.unsure_us =
            std::max(time.unsure_us,
                     static_cast<sea::TimeUs>(std::min(untold_us + announced_ahead_us, most_us)));
    }
    return time;
}

Health World::health() const {
    Health health = health_of(simulation_->healthy(), simulation_->turn());
    if (!health.live)
        return health;
    if (const std::optional<Following> now = following()) {
        health.why = now->doubt();
        health.in_general = in_general(now->kind_of_doubt());
        if (health.why.empty() && now->journal.compares)
            health.why = health.in_general =
                "it has just begun to compare its clock with those of others";
        health.ready = health.why.empty();
    }
    return health;
}

} // namespace seaway::server
