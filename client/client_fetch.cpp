// SPDX-License-Identifier: Apache-2.0
// Client: keyframes that are asked for, in pieces that the server sends and this client can hold.
#include <algorithm>

#include <fmt/format.h>

#include "client/link/failure.h"
#include "client/link/patience.h"
#include "client/wanted.h"
#include "protocol/limits.h"
#include "sea/surface/by_time.h"

namespace seaway::client {

using sea::Answer;
using sea::QueryPoint;
using sea::TimeUs;

Client::Wanted::Wanted(Client& client) : client_(client) {
    const std::scoped_lock lock(client_.mutex_);
    client_.wanted_.push_back(this);
}

Client::Wanted::~Wanted() {
    const std::scoped_lock lock(client_.mutex_);
    std::erase(client_.wanted_, this);
}

bool Client::Wanted::add(const SeaState& state, TimeUs time_us, sea::FieldSet fields) {
    const TimeCell cell = time_cell(state, time_us);
    const std::scoped_lock lock(client_.mutex_);
    for (std::size_t c = 0; c < cell.size(); ++c)
        for (const TimeUs n : {cell[c], cell[c] + 1})
            keys_.insert({state.epoch, static_cast<int>(c), n * state.cascades[c].interval_us});
    // From here on whatever comes is kept; what came before is in the client's ring, if anywhere.
    for (std::size_t c = 0; c < cell.size(); ++c) {
        const std::optional<KeyframePair> pair = client_.ring_.around(
            static_cast<int>(c), state.epoch, time_us, state.cascades[c].interval_us, fields);
        if (!pair || !pair->covers)
            continue;
        ring_.insert(pair->before);
        ring_.insert(pair->after);
    }
    return covers(state, ring_, time_us, fields);
}

void Client::Wanted::offer(const HeldKeyframePtr& keyframe) {
    const sea::Keyframe& k = keyframe->keyframe();
    if (keys_.contains({k.epoch, k.cascade, k.time_us}))
        ring_.insert(keyframe);
}

void Client::Wanted::give_to(KeyframeRing& ring, sea::FieldSet fields) const {
    for (const auto& [epoch, cascade, time_us] : keys_)
        for (const sea::FieldSet with : {sea::FieldSet{}, fields}) {
            const std::optional<KeyframePair> held = ring_.around(cascade, epoch, time_us, 1, with);
            if (held && held->before->keyframe().time_us == time_us)
                ring.insert(held->before);
        }
}

namespace {

/// Times that one fetch may ask for where tiles are as small as usual: the server bounds their
/// number and the bytes that wait for a session.
std::size_t times_of_one_fetch(const SeaState& state, sea::FieldSet fields, std::size_t times_max) {
    std::size_t samples = 0; // of the two keyframes of every cascade around one time
    for (const protocol::CascadeInfo& cascade : state.cascades)
        samples += 2 * static_cast<std::size_t>(fields.size()) *
                   static_cast<std::size_t>(cascade.size) * static_cast<std::size_t>(cascade.size);
    constexpr std::size_t bytes_per_sample = 1; // tiles take a third of it at usual bounds
    const std::size_t fit =
        protocol::limits::fetch_bytes_max / std::max<std::size_t>(bytes_per_sample * samples, 1);
    return std::clamp<std::size_t>(fit, 1, std::max<std::size_t>(times_max, 1));
}

} // namespace

Result<void> Client::fetch(std::span<const TimeUs> times_us, sea::FieldSet fields,
                           double timeout_s) {
    protocol::TileWish wish;
    wish.fields = fields;
    std::uint32_t cascades_left = 0; // of the first time, where cascades come apart
    Patience patience(timeout_s);
    while (!times_us.empty()) {
        const SeaStatePtr state = sea_state(times_us.front());
        const std::uint32_t all_cascades = (1u << state->cascades.size()) - 1u;
        std::size_t count = std::min(
            times_us.size(), times_of_one_fetch(*state, fields, welcome().times_per_fetch_max));
        {
            const std::scoped_lock lock(mutex_);
            count = std::min(count, times_taken_max_);
            if (cascades_apart_ && cascades_left == 0)
                cascades_left = all_cascades;
        }
        wish.cascades = cascades_left & (0u - cascades_left); // the lowest of them
        if (cascades_left == 0)
            wish.cascades = all_cascades;
        Waiter waiter;
        const ConnectionPtr connection = link();
        connection->fetch(times_us.first(count), wish, patience.left_s(), waiter.handler());
        const Result<Reply> reply = reply_of(waiter);
        if (reply) {
            patience = Patience(timeout_s);
            note_offer(wish.fields, reply->fields);
            cascades_left &= ~wish.cascades;
            if (cascades_left == 0)
                times_us = times_us.subspan(count);
            continue;
        }
        if (const auto again = patience.again(reply.error())) {
            rest_until(*again, connection);
            continue;
        }
        if (failure_of(reply.error()) != Failure::too_large)
            return reply.error();
        // The tiles are finer than usual: ask for less at once, from now on.
        patience = Patience(timeout_s);
        const std::scoped_lock lock(mutex_);
        if (count > 1)
            times_taken_max_ = count / 2;
        else if (!cascades_apart_ && state->cascades.size() > 1)
            cascades_apart_ = true;
        else
            return failed(Failure::refused, reply.error().message);
    }
    return {};
}

std::size_t Client::cells_at_once(const SeaState& state, sea::FieldSet fields) const {
    std::size_t cells = std::numeric_limits<std::size_t>::max();
    for (const protocol::CascadeInfo& cascade : state.cascades)
        cells =
            std::min(cells, ring_.limits().room(HeldKeyframe::bytes_of(fields, cascade.size)) / 2);
    return std::max<std::size_t>(cells, 1);
}

/// A server tells of a sea that this client had not heard of when it sends its keyframes: those that were waited for are
/// then of another epoch.
constexpr int tellings_max = 4;

bool Client::seas_are(std::span<const std::pair<TimeUs, SeaStatePtr>> expected) const {
    return std::ranges::all_of(expected, [this](const auto& one) {
        return sea_state(one.first)->epoch == one.second->epoch;
    });
}

bool Client::to_be_seen(TimeUs time_us) const {
    const std::scoped_lock lock(mutex_);
    if (silent(local_now_us())) // nobody could say
        return false;
    const KnownSea known = known_held(*sea_state_held(time_us));
    return !known.has(time_us) || (missed_.contains(time_us) && !known.was_seen(time_us));
}

bool Client::are_known(std::span<const TimeUs> times_us) const {
    const std::scoped_lock lock(mutex_);
    return silent(local_now_us()) || std::ranges::all_of(times_us, [this](TimeUs time_us) {
               return known_held(*sea_state_held(time_us)).has(time_us);
           });
}

Result<void> Client::hold(std::span<const TimeUs> times_us, double timeout_s, sea::FieldSet also) {
    for (int telling = 0;; ++telling) {
        SEAWAY_TRY_LET(const bool held, try_hold(times_us, timeout_s, also));
        if (held || telling == tellings_max)
            return {};
    }
}

Result<bool> Client::try_hold(std::span<const TimeUs> times_us, double timeout_s,
                              sea::FieldSet also) {
    for (const TimeUs time_us : times_us)
        SEAWAY_TRY(check_time(time_us));
    const sea::FieldSet fields = offered(sea::surface_fields | also);
    /// Where the server is asked about a cell, and whether it has to be.
    struct Cell {
        TimeUs time_us;
        bool asked;
    };
    std::map<std::pair<std::uint32_t, TimeCell>, Cell> cells;
    std::vector<std::pair<TimeUs, SeaStatePtr>> expected;
    Wanted wanted(*this);
    for (const TimeUs time_us : times_us) {
        const SeaStatePtr state = sea_state(time_us);
        expected.emplace_back(time_us, state);
        const auto [found, fresh] = cells.try_emplace(
            std::pair(state->epoch, time_cell(*state, time_us)), Cell{time_us, false});
        Cell& cell = found->second;
        if (fresh) {
            const std::size_t room = cells_at_once(*state, fields);
            if (cells.size() > room)
                return failed(Failure::bad_argument,
                              fmt::format("times in {} or more different intervals: this client "
                                          "holds the keyframes around {} of them at once",
                                          cells.size(), room));
            cell.asked = !wanted.add(*state, time_us, fields);
        }
        if (to_be_seen(time_us)) // the last of them: a sea that runs then has run before
            cell = {cell.asked ? std::max(cell.time_us, time_us) : time_us, true};
    }
    std::vector<TimeUs> missing;
    for (const auto& [key, cell] : cells)
        if (cell.asked)
            missing.push_back(cell.time_us);
    SEAWAY_TRY(fetch(missing, fields, timeout_s));
    // What only passed by stays from here on, and the oldest of the ring is put back where it made room.
    {
        const std::scoped_lock lock(mutex_); // a sea may be forgotten meanwhile, on another thread
        wanted.give_to(ring_, fields);
    }
    if (!seas_are(expected))
        return false;
    note_seen(expected);
    return are_known(times_us);
}

std::size_t Client::batch_end(std::span<const QueryPoint> points,
                              std::span<const std::size_t> order, std::size_t first,
                              std::vector<TimeUs>& times_us) const {
    const SeaStatePtr state = sea_state(points[order[first]].time_us);
    const std::size_t cells_max = cells_at_once(*state, sampled_fields());
    TimeCell cell;
    std::size_t next = first;
    for (; next < order.size(); ++next) {
        const TimeUs time_us = points[order[next]].time_us;
        if (sea_state(time_us) != state)
            break;
        TimeCell cell_now = time_cell(*state, time_us);
        if (!times_us.empty() && cell_now == cell) {
            if (to_be_seen(time_us)) // a sea that runs then has run before
                times_us.back() = time_us;
            continue;
        }
        if (times_us.size() == cells_max)
            break;
        times_us.push_back(time_us);
        cell = std::move(cell_now);
    }
    return next;
}

Result<std::vector<Answer>> Client::fetch_and_sample(std::span<const QueryPoint> points,
                                                     double timeout_s) {
    for (const QueryPoint& point : points)
        SEAWAY_TRY(check_point(point));
    const std::vector<std::size_t> order = sea::order_by_time(points);
    std::vector<Answer> answers(points.size());
    const int seas = seas_;
    int tellings = 0;
    for (std::size_t first = 0; first < order.size();) {
        std::vector<TimeUs> times_us;
        const std::size_t next = batch_end(points, order, first, times_us);
        std::vector<QueryPoint> batch;
        for (std::size_t i = first; i < next; ++i)
            batch.push_back(points[order[i]]);
        const sea::FieldSet fields = sampled_fields();
        Wanted wanted(*this);
        std::vector<TimeUs> missing;
        std::vector<std::pair<TimeUs, SeaStatePtr>> expected;
        for (const TimeUs time_us : times_us) {
            expected.emplace_back(time_us, sea_state(time_us));
            if (!wanted.add(*expected.back().second, time_us, fields) || to_be_seen(time_us))
                missing.push_back(time_us);
        }
        SEAWAY_TRY(fetch(missing, fields, timeout_s));
        const bool as_expected = seas_are(expected);
        if (as_expected)
            note_seen(expected);
        std::vector<TimeUs> asked_us;
        for (const QueryPoint& point : batch) // in order of time
            if (asked_us.empty() || asked_us.back() != point.time_us)
                asked_us.push_back(point.time_us);
        if (!(as_expected && are_known(asked_us)) && tellings++ < tellings_max)
            continue;
        tellings = 0;
        std::vector<Answer> sampled(batch.size());
        HeldSurfaces surfaces;
        SEAWAY_TRY(sample_from(wanted.ring(), surfaces, batch, sampled, {}));
        for (std::size_t i = first; i < next; ++i) {
            answers[order[i]] = sampled[i - first];
            if (answers[order[i]].flags & sea::answer_extrapolated)
                return failed(Failure::not_held,
                              fmt::format("the server did not send the keyframes around {} s",
                                          sea::seconds_from_us(points[order[i]].time_us)));
        }
        first = next;
    }
    if (seas_ != seas)
        return failed(Failure::lost, "the sea became another one meanwhile");
    return answers;
}

} // namespace seaway::client
