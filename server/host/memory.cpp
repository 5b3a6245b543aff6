// SPDX-License-Identifier: Apache-2.0
#include "server/host/memory.h"

#include <algorithm>
#include <numeric>

#include "base/check.h"
#include "server/host/metrics_text.h"

namespace seaway::server {

namespace {

/// For what is small: some replies, points and tiles, whatever the sea.
constexpr std::size_t small_things_bytes = 16u * 1024 * 1024;

std::size_t sum(const MemoryNeeds& needs) {
    return std::accumulate(needs.begin(), needs.end(), std::size_t{0});
}

} // namespace

std::size_t Memory::least_bytes(const MemoryNeeds& needs) {
    return sum(needs) + small_things_bytes;
}

std::size_t Memory::default_bytes(const MemoryNeeds& needs) {
    return std::max(bytes_default, sum(needs) + bytes_default / 3);
}

Memory::Memory(std::size_t bytes, const MemoryNeeds& needs, std::chrono::milliseconds trims_every)
    : bytes_(bytes), trims_every_(trims_every) {
    SEAWAY_CHECK(bytes >= sum(needs), "a budget of memory has room for one of each");
    const std::size_t left = bytes - sum(needs);
    for (std::size_t i = 0; i < memory_uses; ++i)
        rooms_[i] = Room::of(needs[i] + left / memory_parts *
                                            static_cast<std::size_t>(memory_shares[i].parts));
}

std::string Memory::metrics_text() const {
    MetricsText text("seaway_memory_");
    const auto each = [&](std::string_view name, std::string_view help, const auto& value) {
        text.family(name, "gauge", help);
        for (const MemoryShare& share : memory_shares)
            text.value({{"of", share.name}}, value(*room(share.use)));
    };
    text.one("budget_bytes", "gauge", "What may be held for those who ask, all in all.", bytes_);
    each("share_bytes", "What of it each use may hold.",
         [](const Room& room) { return room.bytes_max(); });
    each("held_bytes", "What each use holds.", [](const Room& room) { return room.held_bytes(); });
    each("held_most_bytes", "The most that each use has held since the start.",
         [](const Room& room) { return room.held_bytes_most(); });
    return text.take();
}

} // namespace seaway::server
