// SPDX-License-Identifier: Apache-2.0
#include "client/link/requests.h"

#include <new>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "client/link/failure.h"

namespace seaway::client {
namespace {

Error late() {
    return failed(Failure::deadline, "the server did not answer in time");
}

/// In so few words that they need no memory, where there is none: who waits is told in any case.
template <class Make>
Result<Reply> reply_of_failure(Failure kind, const Make& make) {
    try {
        return make();
    } catch (const std::bad_alloc&) {
        return failed(kind, "no memory");
    }
}

/// One that runs out of memory itself has been told; those behind it are.
template <class Make>
void tell_all(std::span<const ReplyHandler> handlers, Failure kind, const Make& make) {
    for (const ReplyHandler& handler : handlers) {
        try {
            handler(reply_of_failure(kind, make));
        } catch (const std::bad_alloc&) {
        }
    }
}

} // namespace

Requests::~Requests() {
    fail_all(failed(Failure::lost, "the connection was closed by this client"));
}

void Requests::start(Lane lane, const Encode& encode, TimeUs deadline_us, ReplyHandler handler,
                     sea::FieldSet fields) {
    std::unique_lock lock(mutex_);
    std::optional<Error> refusal = end_;
    if (!refusal && state(lane).waiting.size() >= waiting_max)
        refusal = failed(Failure::refused,
                         fmt::format("{} requests wait already, which is the limit of this client",
                                     waiting_max));
    if (refusal) {
        lock.unlock();
        return handler(*refusal);
    }
    if (++last_id_ == 0) // 0 stands for no request
        ++last_id_;
    state(lane).waiting.push_back(
        {last_id_, encode(last_id_), deadline_us, std::move(handler), fields});
    lock.unlock();
    send_waiting(lane);
}

void Requests::send_waiting(Lane lane) {
    for (;;) {
        std::uint32_t request_id = 0;
        protocol::Bytes message;
        {
            const std::scoped_lock lock(mutex_);
            LaneState& queue = state(lane);
            if (end_ || queue.waiting.empty() || queue.in_flight >= places(lane))
                return;
            Waiting& next = queue.waiting.front();
            request_id = next.request_id;
            // Takes memory, and where there is none it waits on, whole.
            Open& open =
                open_.try_emplace(request_id, Open{lane, next.deadline_us, {}, next.fields, {}})
                    .first->second;
            open.handler = std::move(next.handler);
            message = std::move(next.message);
            queue.waiting.pop_front();
            ++queue.in_flight;
        }
        const auto lost = [&](const char* why) {
            settle(lane, request_id,
                   reply_of_failure(Failure::lost, [&] { return failed(Failure::lost, why); }));
        };
        try {
            if (!send_(request_id, std::move(message)))
                lost("the connection takes no more messages");
        } catch (const std::bad_alloc&) { // its place would be taken for ever
            lost("no memory to send it");
            throw;
        }
    }
}

void Requests::note_grant(std::uint32_t request_id, const Grant& grant) {
    const std::scoped_lock lock(mutex_);
    const auto found = open_.find(request_id);
    if (found == open_.end())
        return;
    found->second.grant = grant;
    found->second.fields = grant.fields;
}

bool Requests::finish(Lane lane, std::uint32_t request_id, Result<Reply> reply) {
    if (!settle(lane, request_id, std::move(reply)))
        return false;
    send_waiting(lane);
    return true;
}

bool Requests::settle(Lane lane, std::uint32_t request_id, Result<Reply> reply) {
    ReplyHandler handler;
    {
        const std::scoped_lock lock(mutex_);
        const auto found = open_.find(request_id);
        if (found == open_.end() || found->second.lane != lane)
            return false;
        handler = std::move(found->second.handler);
        if (reply)
            reply->grant = found->second.grant;
        open_.erase(found);
        --state(lane).in_flight;
    }
    if (handler)
        handler(std::move(reply));
    return true;
}

bool Requests::refuse(std::uint32_t request_id, const Error& error) {
    bool granted = false;
    {
        const std::scoped_lock lock(mutex_);
        const auto found = open_.find(request_id);
        granted = found != open_.end() && !found->second.grant.fields.empty();
    }
    const Result<Reply> outcome = granted ? Result<Reply>(Reply()) : Result<Reply>(error);
    return finish(Lane::query, request_id, outcome) || finish(Lane::bulk, request_id, outcome) ||
           finish(Lane::spectrum, request_id, outcome);
}

std::vector<sea::FieldSet> Requests::bulk_fields() const {
    const std::scoped_lock lock(mutex_);
    std::vector<sea::FieldSet> fields;
    for (const auto& [request_id, request] : open_)
        if (request.lane == Lane::bulk)
            fields.push_back(request.fields);
    return fields;
}

std::size_t Requests::handlers_held() const {
    std::size_t count = open_.size();
    for (const LaneState& lane : lanes_)
        count += lane.waiting.size();
    return count;
}

void Requests::expire(TimeUs now_us) {
    std::vector<ReplyHandler> expired;
    {
        const std::scoped_lock lock(mutex_);
        expired.reserve(handlers_held()); // or none has left its place
        for (auto& [request_id, request] : open_)
            if (request.handler && request.deadline_us <= now_us)
                expired.push_back(std::exchange(request.handler, nullptr));
        for (LaneState& lane : lanes_)
            for (auto waiting = lane.waiting.begin(); waiting != lane.waiting.end();) {
                if (waiting->deadline_us > now_us) {
                    ++waiting;
                    continue;
                }
                expired.push_back(std::move(waiting->handler));
                waiting = lane.waiting.erase(waiting);
            }
    }
    tell_all(expired, Failure::deadline, late);
}

void Requests::abandon(Lane lane, const Error& error) {
    std::vector<ReplyHandler> failed_handlers;
    {
        const std::scoped_lock lock(mutex_);
        failed_handlers.reserve(handlers_held()); // or none has left its place
        for (auto& [request_id, request] : open_)
            if (request.lane == lane && request.handler)
                failed_handlers.push_back(std::move(request.handler));
        std::erase_if(open_, [lane](const auto& open) { return open.second.lane == lane; });
        for (Waiting& waiting : state(lane).waiting)
            failed_handlers.push_back(std::move(waiting.handler));
        state(lane).waiting.clear();
        state(lane).in_flight = 0;
    }
    tell_all(failed_handlers, failure_of(error), [&] { return error; });
}

void Requests::fail_all(const Error& error) {
    {
        const std::scoped_lock lock(mutex_);
        end_ = error;
    }
    for (const Lane lane : {Lane::query, Lane::bulk, Lane::spectrum})
        abandon(lane, error);
}

} // namespace seaway::client
