// SPDX-License-Identifier: Apache-2.0
// Client: points that the server answers.
#include <algorithm>
#include <condition_variable>
#include <deque>

#include "client/client.h"
#include "client/link/failure.h"
#include "client/link/patience.h"

namespace seaway::client {

using sea::Answer;
using sea::QueryPoint;

namespace {

/// Batches of one ask() under way: enough to hide the round trip.
constexpr std::size_t batches_in_flight = 4;

struct Batch {
    std::size_t first; ///< of its points
    Patience patience;
};

/// Of one ask().
struct Progress {
    std::mutex mutex;
    std::condition_variable changed;
    std::size_t first_unsent = 0; ///< of the points
    std::size_t under_way = 0;
    std::deque<Batch> to_send; ///< refused, those that were sent first first; or the next one
    Patience::Clock::time_point rests_until; ///< so that the server is not asked for more meanwhile
    Below found;
    std::optional<Error> problem;

    bool has_more() const { return first_unsent < found.answers.size() || !to_send.empty(); }
    bool may_send() const { return has_more() && under_way < batches_in_flight; }
    bool rests() const { return Patience::Clock::now() < rests_until; }
    bool over() const { return problem || (!has_more() && under_way == 0); }

    Batch next(std::size_t batch_size, double timeout_s) {
        if (to_send.empty()) {
            to_send.push_back({first_unsent, Patience(timeout_s)});
            first_unsent += batch_size;
        }
        const Batch batch = to_send.front();
        to_send.pop_front();
        ++under_way;
        return batch;
    }
    /// Whoever waits is woken, whatever there is no memory for.
    void take(const Batch& batch, const Result<Reply>& reply) {
        const std::scoped_lock lock(mutex);
        --under_way;
        if (reply)
            keep(batch, *reply);
        else if (!problem)
            try {
                refuse(batch, reply.error());
            } catch (const std::bad_alloc&) {
                problem = failed(failure_of(reply.error()), "no memory");
            }
        changed.notify_all();
    }

  private:
    void keep(const Batch& batch, const Reply& reply) {
        const auto at = static_cast<std::ptrdiff_t>(batch.first);
        std::ranges::copy(reply.answers, found.answers.begin() + at);
        if (!reply.below.empty())
            std::ranges::copy(reply.below, found.water.begin() + at);
    }
    void refuse(const Batch& batch, const Error& why) {
        const auto at = batch.patience.again(why);
        if (at) {
            to_send.insert(std::ranges::upper_bound(to_send, batch.first, {}, &Batch::first),
                           batch);
            rests_until = std::max(rests_until, *at);
        }
        if (!at || !to_send.front().patience.lasts_beyond(rests_until))
            problem = why;
    }
};

} // namespace

Result<std::vector<Answer>> Client::ask(std::span<const QueryPoint> points, const Asking& asking) {
    SEAWAY_TRY_LET(Below found, ask_all(points, {}, asking));
    return std::move(found.answers);
}

Result<Below> Client::ask_below(std::span<const QueryPoint> points, std::span<const double> z_m,
                                const Asking& asking) {
    SEAWAY_CHECK(points.size() == z_m.size(), "one depth a point");
    return ask_all(points, z_m, asking);
}

Result<Below> Client::ask_all(std::span<const QueryPoint> points, std::span<const double> z_m,
                              const Asking& asking) {
    SEAWAY_TRY(check_asked(points, asking.looking));
    const std::size_t batch_size =
        std::max(asking.exact || !z_m.empty() ? welcome().exact_points_per_query_max
                                              : welcome().points_per_query_max,
                 1u);
    const auto progress = std::make_shared<Progress>();
    progress->found.answers.resize(points.size());
    progress->found.water.resize(z_m.size());
    ConnectionPtr connection = link();
    std::unique_lock lock(progress->mutex);
    constexpr auto for_ever = Patience::Clock::time_point::max();
    const auto wait = [&](Patience::Clock::time_point until, const std::function<bool()>& ready) {
        if (!threadless())
            return (void)progress->changed.wait_until(lock, until, ready);
        lock.unlock();
        work_until(until, [&] {
            const std::scoped_lock inner(progress->mutex);
            return ready();
        });
        lock.lock();
    };
    const auto send = [&](const Batch& batch) {
        const std::size_t first = batch.first;
        const auto some = points.subspan(first, std::min(batch_size, points.size() - first));
        const auto depths = z_m.empty() ? z_m : z_m.subspan(first, some.size());
        const auto answered = [progress, batch](const Result<Reply>& reply) {
            progress->take(batch, reply);
        };
        connection->query(some, asking.exact, batch.patience.left_s(), answered, asking.looking,
                          depths);
    };
    for (;;) {
        wait(for_ever, [&] { return progress->over() || progress->may_send(); });
        if (progress->under_way > 0) {
            wait(progress->rests_until, [&] { return progress->over(); });
        } else if (progress->rests()) {
            const auto until = progress->rests_until;
            lock.unlock();
            rest_until(until, connection);
            connection = link();
            lock.lock();
            progress->rests_until = {};
        }
        if (progress->over())
            break;
        if (!progress->may_send() || progress->rests())
            continue;
        const Batch batch = progress->next(batch_size, asking.timeout_s);
        lock.unlock();
        send(batch);
        lock.lock();
    }
    wait(for_ever, [&] { return progress->under_way == 0; });
    if (progress->problem)
        return *progress->problem;
    mark_unsure(points, progress->found.answers);
    return std::move(progress->found);
}

Result<void> Client::check_asked(std::span<const QueryPoint> points, const Looking& looking) const {
    for (const QueryPoint& point : points)
        SEAWAY_TRY(check_point(point));
    return points.empty() ? Result<void>()
                          : check_cascades(*sea_state(points.front().time_us), looking);
}

Result<void> Client::ask_async(std::span<const QueryPoint> points, const Asking& asking,
                               ReplyHandler handler) {
    SEAWAY_TRY(check_asked(points, asking.looking));
    const auto marked = [this, asked = std::vector(points.begin(), points.end()),
                         handler = std::move(handler)](Result<Reply> reply) {
        if (reply)
            mark_unsure(asked, reply->answers);
        handler(std::move(reply));
    };
    link()->query(points, asking.exact, asking.timeout_s, marked, asking.looking);
    wake();
    return {};
}

} // namespace seaway::client
