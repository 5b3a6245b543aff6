// SPDX-License-Identifier: Apache-2.0
// Bytes as the messages of one client, through Session, Outbox and a small sea: whatever comes, the
// session ends in order and what waits stays bounded. Input: two bytes of length, then a message,
// and so on; length 0 lets the client read one message.
#include <cstdint>
#include <cstdlib>

#include <spdlog/spdlog.h>

#include "protocol/limits.h"
#include "server/net/session.h"
#include "tests/server/simulation/small_sea.h"

using namespace seaway;

namespace {

class Nowhere : public server::Link {
  public:
    void drop() noexcept override {}
    void send_more() override {}
    void close(protocol::SharedBytes, wire::ErrorCode, const std::string&) override {}
};

/// Host callbacks come at once; what they post runs after the message that caused them.
struct World {
    std::vector<server::Core::Work> work;
    tests::SmallSea sea;
    std::shared_ptr<server::Core> core = std::make_shared<server::Core>(
        server::NetOptions(), sea,
        [this](server::Core::Work w) {
            const std::lock_guard lock(mutex);
            work.push_back(std::move(w));
        },
        [] { return server::Turns::Clock::time_point(); }); // the same whatever machine it runs on
    std::mutex mutex;

    void run() {
        std::vector<server::Core::Work> now;
        {
            const std::lock_guard lock(mutex);
            now.swap(work);
        }
        for (const server::Core::Work& one : now)
            one();
    }
};

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static World* world = [] {
        spdlog::set_level(spdlog::level::off);
        auto made = new World;
        made->sea.size = 4;
        return made;
    }();
    Nowhere link;
    {
        server::Session session(*world->core, link,
                                {.name = "fuzz", .address = world->core->addresses.of("::1", {})},
                                server::Standing::stranger);
        const protocol::Bytes hello = protocol::hello("fuzz", "");
        session.receive(hello);
        while (size >= 2 && !session.ended()) {
            const std::size_t length = static_cast<std::size_t>(data[0]) << 8 | data[1];
            data += 2;
            size -= 2;
            const std::size_t taken = length < size ? length : size;
            if (length == 0)
                (void)session.next_message();
            else if (session.wants_requests())
                session.receive({data, taken});
            data += taken;
            size -= taken;
            world->run();
            if (session.outbox().bytes_waiting() >
                protocol::limits::replies_bytes_max + protocol::limits::fetch_bytes_max +
                    2 * protocol::limits::server_message_bytes_max)
                std::abort();
        }
    }
    world->run();
    if (!world->core->sessions.empty() || world->sea.subscriptions().size() != 0)
        std::abort();
    return 0;
}
