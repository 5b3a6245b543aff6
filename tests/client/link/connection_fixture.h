// SPDX-License-Identifier: Apache-2.0
// A connection over a stream without sockets, whose other end is the test.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "client/link/connection.h"
#include "protocol/tile_codec.h"

namespace seaway::client {

/// The server's end: answers in the thread of whoever sends.
class FakeServer {
  public:
    std::function<void(const wire::Message&)> on_message;
    MessageStreamEvents events;
    std::string closed_because;
    std::vector<std::uint64_t> acknowledged; ///< keyframes
    std::vector<std::size_t> acks;           ///< how many of those each of them named
    bool open = true;
    bool takes = true; ///< what it is sent

    void send(const protocol::Bytes& bytes) { events.on_message(bytes); }

    void greet() {
        send(protocol::welcome(1, "fake", 5'000'000));
        protocol::SeaStateValues state;
        state.epoch = 1;
        state.cascades.push_back({.length_m = 10, .size = 16, .interval_us = 100'000});
        send(protocol::sea_state(state));
    }

    void end(const std::string& reason) {
        if (!open)
            return;
        open = false;
        closed_because = reason;
        events.on_closed(reason);
    }
};

class FakeStream final : public MessageStream {
  public:
    explicit FakeStream(FakeServer& server) : server_(server) {}
    ~FakeStream() override { server_.end("destroyed"); }
    void start(MessageStreamEvents events) override { server_.events = std::move(events); }
    bool send(protocol::Bytes message) override {
        if (!server_.takes)
            return false;
        if (!server_.open)
            return true;
        protocol::MessageReader reader(protocol::Sender::client);
        const Result<const wire::Message*> read = reader.read(message);
        EXPECT_TRUE(read);
        if (const auto* ack = (*read)->body_as_Ack())
            take(*ack);
        else if (server_.on_message)
            server_.on_message(**read);
        return true;
    }
    void close(std::string reason) override { server_.end(reason); }
    void end() override { server_.end("destroyed"); }

  private:
    void take(const wire::Ack& ack) {
        server_.acknowledged.push_back(ack.keyframe());
        if (ack.also() != nullptr)
            server_.acknowledged.insert(server_.acknowledged.end(), ack.also()->begin(),
                                        ack.also()->end());
        server_.acks.push_back(ack.also() != nullptr ? 1 + ack.also()->size() : 1);
    }

    FakeServer& server_;
};

class ConnectionTest : public ::testing::Test {
  protected:
    FakeServer server;
    std::vector<HeldKeyframePtr> keyframes;
    std::string lost;
    std::uint32_t stay_away_ms = 0;

    ConnectionTest() {
        server.on_message = [this](const wire::Message& message) {
            if (message.body_as_Hello())
                server.greet();
        };
    }

    Result<std::unique_ptr<Connection>> open(double timeout_s = 0.05,
                                             ConnectionEvents events = {}) {
        events.on_keyframe = [this](const HeldKeyframePtr& held) { keyframes.push_back(held); };
        events.on_closed = [this](const Error& reason) {
            lost = reason.message;
            stay_away_ms = reason.retry_after_ms;
        };
        return Connection::open(
            {.url = "ws://fake", .timeout_s = timeout_s}, std::move(events),
            [this](const Url&, const WebSocketOptions&) -> Result<std::unique_ptr<MessageStream>> {
                return std::unique_ptr<MessageStream>(std::make_unique<FakeStream>(server));
            });
    }

    protocol::Bytes tile(std::uint64_t keyframe, sea::Field field, std::uint32_t epoch = 1,
                         int size = 16) {
        const std::vector<float> map(static_cast<std::size_t>(size * size), 1.0f);
        const auto payload =
            protocol::encode_tile(map, {size, size}, static_cast<std::size_t>(size), 0.01f);
        return protocol::tile({.keyframe = keyframe,
                               .epoch = epoch,
                               .field = field,
                               .size = size,
                               .width = size,
                               .height = size,
                               .error = 0.01f},
                              *payload);
    }
};

} // namespace seaway::client
