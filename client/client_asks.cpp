// SPDX-License-Identifier: Apache-2.0
// Client: points that the server answers.
#include <algorithm>
#include <condition_variable>

#include "client/client.h"
#include "client/link/failure.h"

namespace seaway::client {

using sea::Answer;
using sea::QueryPoint;

namespace {

/// Batches of one ask() under way: enough to hide the round trip.
constexpr std::size_t batches_in_flight = 4;

/// Of one ask().
struct Progress {
    std::mutex mutex;
    std::condition_variable changed;
    std::size_t under_way = 0;
    Below found;
    std::optional<Error> problem;

    /// Of the batch that begins with that point. Whoever waits is woken, whatever there is no memory for.
    void take(std::size_t first, const Result<Reply>& reply) {
        const std::scoped_lock lock(mutex);
        --under_way;
        const auto at = static_cast<std::ptrdiff_t>(first);
        if (reply) {
            std::ranges::copy(reply->answers, found.answers.begin() + at);
            if (!reply->below.empty())
                std::ranges::copy(reply->below, found.water.begin() + at);
        } else if (!problem) {
            try {
                problem = reply.error();
            } catch (const std::bad_alloc&) {
                problem = failed(failure_of(reply.error()), "no memory");
            }
        }
        changed.notify_all();
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
    const ConnectionPtr connection = link();
    std::unique_lock lock(progress->mutex);
    const auto wait = [&](const std::function<bool()>& ready) {
        if (!threadless())
            return progress->changed.wait(lock, ready);
        lock.unlock();
        work_until(std::chrono::steady_clock::time_point::max(), [&] {
            const std::scoped_lock inner(progress->mutex);
            return ready();
        });
        lock.lock();
    };
    for (std::size_t first = 0; first < points.size(); first += batch_size) {
        wait([&] { return progress->under_way < batches_in_flight; });
        if (progress->problem)
            break;
        ++progress->under_way;
        lock.unlock();
        const auto batch = points.subspan(first, std::min(batch_size, points.size() - first));
        const auto depths = z_m.empty() ? z_m : z_m.subspan(first, batch.size());
        const auto answered = [progress, first](const Result<Reply>& reply) {
            progress->take(first, reply);
        };
        connection->query(batch, asking.exact, asking.timeout_s, answered, asking.looking, depths);
        lock.lock();
    }
    wait([&] { return progress->under_way == 0; });
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
