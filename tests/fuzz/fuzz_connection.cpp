// SPDX-License-Identifier: Apache-2.0
// Bytes as the messages of a server, through Connection: whatever comes, a client reads on or ends the connection, and what it has
// asked for is answered or failed. Input: two bytes of length, then a message, and so on; length 0 lets time pass.
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <string>
#include <utility>

#include "client/link/connection.h"

using namespace seaway;
using namespace seaway::client;

namespace {

/// The other end, without a socket.
struct Server {
    MessageStreamEvents events;
    bool open = true;

    void end(const std::string& reason) {
        if (open) {
            open = false;
            events.on_closed(reason);
        }
    }
    void greet() {
        events.on_message(protocol::welcome(1, "fuzz", 5'000'000));
        protocol::SeaStateValues state;
        state.epoch = 1;
        state.cascades.push_back({.length_m = 10, .size = 16, .interval_us = 100'000});
        events.on_message(protocol::sea_state(state));
    }
};

class Stream final : public MessageStream {
  public:
    explicit Stream(Server& server) : server_(server) {}
    ~Stream() override { end(); }
    void end() override { server_.end("ended"); }
    void start(MessageStreamEvents events) override { server_.events = std::move(events); }
    bool send(protocol::Bytes) override {
        if (!std::exchange(greeted_, true)) // Hello is the first
            server_.greet();
        return true;
    }
    void close(std::string reason) override { server_.end(reason); }

  private:
    Server& server_;
    bool greeted_ = false;
};

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    Server server;
    int asked = 0, told = 0;
    {
        auto opened = Connection::open(
            {.url = "ws://fuzz", .timeout_s = 5}, {},
            [&](const Url&, const WebSocketOptions&) -> Result<std::unique_ptr<MessageStream>> {
                return std::unique_ptr<MessageStream>(std::make_unique<Stream>(server));
            });
        if (!opened)
            std::abort();
        Connection& connection = **opened;
        const auto count = [&told](const auto&) { ++told; };
        const sea::QueryPoint point{1, 2, 3};
        const sea::TimeUs time_us = 5'000'000;
        connection.subscribe({.fields = sea::surface_fields}, 8, 60, count);
        connection.subscribe_spectrum({}, 60, count);
        connection.query({&point, 1}, false, 60, count);
        connection.fetch({&time_us, 1}, {.fields = sea::surface_fields}, 60, count);
        asked = 4;
        while (size >= 2 && server.open) {
            const std::size_t length = static_cast<std::size_t>(data[0]) << 8 | data[1];
            data += 2;
            size -= 2;
            const std::size_t taken = length < size ? length : size;
            if (length == 0)
                server.events.on_tick();
            else
                server.events.on_message({data, taken});
            data += taken;
            size -= taken;
        }
    }
    if (told != asked) // each once, by its end at the latest
        std::abort();
    return 0;
}
