// SPDX-License-Identifier: Apache-2.0
// Connection: points that are asked about, and their answers.
#include <fmt/format.h>

#include "client/link/connection.h"
#include "client/link/failure.h"

namespace seaway::client {

namespace {

/// A server skips what it does not know of a query, and answers the rest.
Result<void> check_answers(const Reply& reply, std::size_t points, std::size_t depths,
                           bool chooses) {
    if (reply.answers.size() != points)
        return failed(Failure::refused,
                      fmt::format("{} points asked, {} answered", points, reply.answers.size()));
    if (depths != 0 && reply.below.empty())
        return failed(Failure::not_understood,
                      "this server is older and knows nothing of the water below");
    if (reply.below.size() != depths)
        return failed(Failure::refused,
                      fmt::format("{} depths asked, {} answered", depths, reply.below.size()));
    if (chooses && !reply.chose_waves)
        return failed(Failure::not_understood,
                      "this server is older and has answered for all waves: it knows of no choice "
                      "of cascades or wavelengths");
    return {};
}

} // namespace

void Connection::query(std::span<const sea::QueryPoint> points, bool exact, double timeout_s,
                       ReplyHandler handler, const sea::Looking& looking,
                       std::span<const double> z_m) {
    const bool by_sums = exact || !z_m.empty();
    const std::uint32_t points_max =
        by_sums ? welcome_.exact_points_per_query_max : welcome_.points_per_query_max;
    if (points.size() > points_max)
        return handler(failed(Failure::bad_argument, fmt::format("{} points in one query, the "
                                                                 "server takes {}",
                                                                 points.size(), points_max)));
    const auto expected = points.size();
    requests_.start(
        Lane::query,
        [&](std::uint32_t request_id) {
            return protocol::query(request_id, points, exact, looking, z_m);
        },
        deadline_us(timeout_s),
        [expected, depths = z_m.size(), chooses = looking != sea::Looking{},
         handler = std::move(handler)](Result<Reply> reply) {
            if (reply)
                if (const Result<void> whole = check_answers(*reply, expected, depths, chooses);
                    !whole)
                    return handler(whole.error());
            handler(std::move(reply));
        });
}

Result<void> Connection::take(const wire::QueryReply& reply) {
    SEAWAY_TRY(protocol::check(reply));
    Reply value;
    value.epoch = reply.epoch();
    value.chose_waves = reply.cascades().has_value();
    if (reply.answers()) {
        value.answers.reserve(reply.answers()->size());
        for (const wire::PointAnswer* answer : *reply.answers())
            value.answers.push_back(protocol::answer(*answer));
    }
    if (reply.below()) {
        value.below.reserve(reply.below()->size());
        for (const wire::Below* below : *reply.below())
            value.below.push_back(protocol::water(*below));
    }
    if (!requests_.finish(Lane::query, reply.request_id(), std::move(value)))
        return Error{fmt::format("an answer to query {}, which is not open", reply.request_id())};
    return {};
}

} // namespace seaway::client
