// SPDX-License-Identifier: Apache-2.0
// Connection: the stream that is asked for, and asked for again without predictions.
#include <utility>

#include "client/link/connection.h"

namespace seaway::client {

namespace {

constexpr double again_timeout_s = 10;

} // namespace

void Connection::subscribe(const protocol::TileWish& wish, int credit, double timeout_s,
                           ReplyHandler handler) {
    const std::scoped_lock lock(stream_mutex_); // what is sent last is what streaming_ says
    protocol::TileWish full = compact(wish);
    full.predicted = predicts_;
    const auto answered = [this, before = std::exchange(streaming_, Stream{wish, credit}),
                           serial = ++stream_serial_,
                           handler = std::move(handler)](Result<Reply> reply) {
        if (!reply)
            goes_on(before, serial);
        handler(std::move(reply));
    };
    requests_.start(
        Lane::bulk,
        [&](std::uint32_t request_id) { return protocol::subscribe(request_id, full, credit); },
        deadline_us(timeout_s), answered, wish.fields);
}

/// What was refused leaves what was streamed before, if nothing else was asked for since.
void Connection::goes_on(const std::optional<Stream>& before, std::uint64_t serial) {
    const std::scoped_lock lock(stream_mutex_);
    if (serial == stream_serial_)
        streaming_ = before;
}

void Connection::subscribe_unpredicted() {
    if (std::exchange(subscribes_again_, true))
        return;
    predicts_ = false;
    const std::scoped_lock lock(stream_mutex_);
    if (const std::optional<Stream> same = streaming_)
        subscribe(same->wish, same->credit, again_timeout_s, [this](Result<Reply> reply) {
            subscribes_again_ = reply.has_value(); // refused: with the next one that comes
        });
}

void Connection::unsubscribe() {
    const std::scoped_lock lock(stream_mutex_);
    streaming_.reset();
    ++stream_serial_;
    send(protocol::unsubscribe());
}

} // namespace seaway::client
