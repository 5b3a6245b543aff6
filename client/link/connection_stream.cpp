// SPDX-License-Identifier: Apache-2.0
// Connection: the stream that is asked for, and asked for again without predictions.
#include <optional>
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
    const Stream stream{wish, credit};
    const auto answered = [this, stream, serial = streaming_.ask(stream),
                           handler = std::move(handler)](Result<Reply> reply) {
        {
            const std::scoped_lock answering(stream_mutex_);
            if (reply)
                streaming_.granted(serial, stream);
            else
                streaming_.failed(serial, stream, reply.error());
        }
        handler(std::move(reply));
    };
    requests_.start(
        Lane::bulk,
        [&](std::uint32_t request_id) { return protocol::subscribe(request_id, full, credit); },
        deadline_us(timeout_s), answered, wish.fields);
}

void Connection::subscribe_unpredicted() {
    if (std::exchange(subscribes_again_, true))
        return;
    predicts_ = false;
    const std::scoped_lock lock(stream_mutex_);
    if (const std::optional<Stream> same = streaming_.wanted())
        subscribe(same->wish, same->credit, again_timeout_s, [this](Result<Reply> reply) {
            subscribes_again_ = reply.has_value(); // refused: with the next one that comes
        });
    else
        subscribes_again_ = false;
}

void Connection::unsubscribe() {
    const std::scoped_lock lock(stream_mutex_);
    streaming_.end();
    send(protocol::unsubscribe());
}

} // namespace seaway::client
