// SPDX-License-Identifier: Apache-2.0
// What administrators ask of a server (client/link/connection.h).
#include <fmt/format.h>

#include "client/link/connection.h"

namespace seaway::client {

void Connection::change(const protocol::ChangeWish& wish, double timeout_s, ReplyHandler handler) {
    requests_.start(
        Lane::query, [&](std::uint32_t request_id) { return protocol::change(request_id, wish); },
        deadline_us(timeout_s), std::move(handler));
}

void Connection::administer(wire::Act act, std::uint64_t session, double timeout_s,
                            ReplyHandler handler) {
    requests_.start(
        Lane::query,
        [&](std::uint32_t request_id) { return protocol::administer(request_id, act, session); },
        deadline_us(timeout_s), std::move(handler));
}

Result<void> Connection::take(const wire::Changed& changed) {
    SEAWAY_TRY(protocol::check(changed));
    Reply value;
    value.epoch = changed.epoch();
    value.start_us = changed.start_us();
    value.end_us = changed.end_us();
    value.change = changed.change();
    if (!requests_.finish(Lane::query, changed.request_id(), std::move(value)))
        return Error{
            fmt::format("an answer to change {}, which is not open", changed.request_id())};
    return {};
}

Result<void> Connection::take(const wire::Administered& administered) {
    Reply value;
    value.text = administered.text() ? administered.text()->str() : std::string();
    if (!requests_.finish(Lane::query, administered.request_id(), std::move(value)))
        return Error{
            fmt::format("an answer to request {}, which is not open", administered.request_id())};
    return {};
}

} // namespace seaway::client
