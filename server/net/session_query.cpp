// SPDX-License-Identifier: Apache-2.0
// Session: points that are asked about.
#include <chrono>

#include <fmt/format.h>

#include "protocol/limits.h"
#include "server/net/fetch_job.h"
#include "server/net/refusals.h"
#include "server/net/session.h"
#include "server/net/session_behind.h"

namespace seaway::server {

namespace limits = protocol::limits;
using wire::ErrorCode;

namespace {

/// Of a session: whatever others leave unread, some points are answered.
constexpr std::size_t small_replies_bytes = 16 * 1024;

/// Whose query this thread is handing to the host, which may answer it meanwhile.
thread_local SessionId asking = 0;

class Asking {
  public:
    explicit Asking(SessionId session) { asking = session; }
    ~Asking() { asking = 0; }
    Asking(const Asking&) = delete;
    Asking& operator=(const Asking&) = delete;
};

} // namespace

void Session::on_query(const wire::Query& query) {
    const std::uint32_t request_id = query.request_id();
    if (const Result<void> fine = protocol::check(query); !fine)
        return refuse(request_id, fine.error());
    if (queries_in_flight_ >= limits::queries_in_flight_max)
        return refuse(request_id,
                      {ErrorCode::too_many_requests,
                       fmt::format("{} queries are not answered yet", queries_in_flight_)});
    const std::size_t points = query.points() == nullptr ? 0 : query.points()->size();
    const std::size_t depths = query.z_m() == nullptr ? 0 : query.z_m()->size();
    const std::size_t bytes = points * sizeof(wire::PointAnswer) + depths * sizeof(wire::Below);
    const Room::Place place = reply_place(bytes);
    if (!place)
        return refuse(request_id, no_room_for("answers"));
    QueryBatch batch{.exact = query.exact() || depths != 0,
                     .points = {},
                     .asker = Asker(here_),
                     .looking = protocol::looking(query)};
    if (depths != 0)
        batch.z_m.assign(query.z_m()->begin(), query.z_m()->end());
    if (query.points() != nullptr) {
        batch.points.reserve(points);
        for (const wire::Point* point : *query.points())
            batch.points.push_back({point->x_m(), point->y_m(), point->time_us()});
    }
    ++queries_in_flight_;
    replies_in_flight_bytes_ += bytes;
    ++core_.counters.queries;
    core_.counters.query_points += batch.points.size();
    const Asked asked{request_id, points, bytes, place};
    const Asking handing(id_);
    core_.host.query(std::move(batch), [core = core_.weak_from_this(), session = id_,
                                        asked](Result<QueryAnswers> answers) {
        const std::shared_ptr<Core> alive = core.lock();
        if (alive == nullptr)
            return;
        const Result<protocol::SharedBytes> reply = reply_of(asked, answers);
        if (asking == session) {
            if (Session* found = alive->find(session))
                found->or_drop([&] { found->answered(asked, reply); });
            return;
        }
        later(core, session, [asked, reply](Session& found) { found.answered(asked, reply); });
    });
}

Room::Place Session::reply_place(std::size_t bytes) const {
    Room& replies = *core_.memory->room(MemoryUse::replies);
    const std::size_t own = replies_in_flight_bytes_ + outbox_.reply_bytes_waiting() + bytes;
    return own <= small_replies_bytes ? replies.take_anyway(bytes) : replies.take(bytes);
}

/// On the thread that answers: for the io thread it is 0.2 ms where there are many points.
Result<protocol::SharedBytes> Session::reply_of(const Asked& asked,
                                                const Result<QueryAnswers>& answers) {
    if (!answers)
        return answers.error();
    return protocol::SharedBytes(
        with_place(asked.place, std::make_shared<const protocol::Bytes>(protocol::query_reply(
                                    asked.request_id, answers->epoch, answers->answers,
                                    answers->below, answers->cascades))));
}

void Session::answered(const Asked& asked, const Result<protocol::SharedBytes>& reply) {
    replies_in_flight_bytes_ -= asked.bytes;
    --queries_in_flight_;
    if (!reply)
        return refuse(asked.request_id, reply.error());
    outbox_.push_reply(*reply);
    link_.send_more();
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - asked.at;
    Counters& counters = core_.counters;
    (asked.points <= few_points ? counters.few_answered : counters.many_answered).add(took.count());
}

} // namespace seaway::server
