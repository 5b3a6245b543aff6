// SPDX-License-Identifier: Apache-2.0
#include "server/net/deliveries.h"

#include <algorithm>
#include <new>

#include "base/undo.h"
#include "server/net/core.h"
#include "server/net/session.h"

namespace seaway::server {
namespace {

/// As many as hold more of the stream than there is memory for: whoever holds the oldest keyframe, then the next one.
/// What they hold is let go of in the next turns of the loop.
void close_who_is_furthest_behind(Core& core) {
    const Room& room = *core.memory->room(MemoryUse::streamed);
    for (std::size_t held = room.held_bytes(); held > room.bytes_max();) {
        Outbox::Streamed oldest;
        for (const auto& [id, session] : core.sessions)
            if (const Outbox::Streamed one = session->outbox().oldest_streamed();
                one.number != 0 && (oldest.number == 0 || one.number < oldest.number))
                oldest = one;
        if (oldest.number == 0)
            return; // what is held is remembered
        for (auto at = core.sessions.begin(); at != core.sessions.end();)
            if (Session& session = *(at++)->second;
                session.outbox().oldest_streamed().number == oldest.number)
                session.give_up("tiles that wait for readers fill the memory there is for them");
        held -= std::min(held, oldest.bytes);
    }
}

} // namespace

void Deliveries::add_to(Line& line, Delivery one) {
    line.waiting.push_back(std::move(one));
    core_.turns.first([this] { turn(); });
}

void Deliveries::turn() {
    if (!any())
        return;
    const Undo asks_again(
        [this] { // by an exception, too, which is of one session: the others have theirs all the same
            try {
                if (any())
                    core_.turns.first([this] { turn(); });
            } catch (const std::bad_alloc&) { // Turns has it
            }
        });
    Line& line = seas_.waiting.empty() ? keyframes_ : seas_;
    const Delivery delivered = line.waiting.front();
    const int threads = core_.senders.threads();
    bool all = false;
    core_.senders.together([&] {
        auto next = core_.sessions.upper_bound(line.last);
        for (int i = 1; next != core_.sessions.end(); ++i) {
            Session& session = *next->second; // which may end, and leave the map
            line.last = (next++)->first;
            if (delivered.keyframe != nullptr)
                session.deliver(delivered);
            else
                session.announce(delivered.sea_state);
            if (threads == 1 ? core_.turns.over() : i == sessions_a_turn * threads)
                break;
        }
        all = next == core_.sessions.end();
    });
    if (all) {
        line.waiting.pop_front();
        line.last = 0;
        close_who_is_furthest_behind(core_);
    }
}

} // namespace seaway::server
