// SPDX-License-Identifier: Apache-2.0
// Bytes as a message of either side: an error, or a message of which every checked value can be
// read, written again and read back.
#include <cstdint>
#include <cstdlib>

#include "protocol/messages.h"

using namespace seaway;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    for (const protocol::Sender sender : {protocol::Sender::client, protocol::Sender::server}) {
        protocol::MessageReader reader(sender);
        const auto message = reader.read({data, size});
        if (!message)
            continue;
        const wire::Message& m = **message;
        if (!protocol::check(m))
            continue;
        if (const auto* state = m.body_as_SeaState()) {
            const protocol::SeaStateValues values = protocol::values(*state);
            const protocol::Bytes again = protocol::sea_state(values);
            protocol::MessageReader second(sender);
            if (!second.read(again))
                std::abort();
        }
        if (const auto* tile = m.body_as_Tile()) {
            const protocol::TileHeader header = protocol::header(*tile);
            if (header.x0 + header.width > header.size || header.part >= header.parts)
                std::abort();
        }
        if (const auto* reply = m.body_as_QueryReply(); reply && reply->answers())
            for (const wire::PointAnswer* answer : *reply->answers())
                (void)protocol::answer(*answer);
    }
    return 0;
}
