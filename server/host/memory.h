// SPDX-License-Identifier: Apache-2.0
// Memory: the one budget of bytes for what a server holds because somebody asks: keyframes, surfaces,
// questions, tiles, waves, replies and maps. Each use has a named share of it, with room for one of the largest
// things it is for; what is left is shared by the parts in the table. What stands for a share is a Room:
// who finds none waits, is refused, or makes room, as the table says. The program and its sea itself, and what is
// being read from sockets, are beside it (docs/operations.md).
//
//     const auto memory = std::make_shared<Memory>(640u << 20, needs_of(sea));
//     Room::Place place = memory->room(MemoryUse::maps).take(bytes);
//
// Thread-safe.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

#include "server/host/room.h"

namespace seaway::server {

enum class MemoryUse : std::size_t {
    keyframes,
    surfaces,
    prompt_surfaces,
    fetches,
    encoding,
    encoded,
    streamed,
    fetched,
    points,
    replies,
    maps,
    sums,
    spectra,
};
inline constexpr std::size_t memory_uses = 13;

/// Maps under way at a time: each takes two threads while it lasts.
inline constexpr int maps_at_once_max = 2;

struct MemoryShare {
    MemoryUse use;
    std::string_view name; ///< in /metrics
    int parts;             ///< of memory_parts
};

/// Parts as floods and long runs of the gale used them (docs/performance/load.md).
inline constexpr std::array<MemoryShare, memory_uses> memory_shares{{
    // The store: keyframes with their splines. Makes room itself, oldest use first out.
    {MemoryUse::keyframes, "keyframes", 14},
    // Of questions that take long, and of prompt ones: who finds no room waits.
    {MemoryUse::surfaces, "surfaces", 9},
    {MemoryUse::prompt_surfaces, "prompt_surfaces", 5},
    // Raw keyframes of fetches and of starts of subscriptions, until they are encoded: waits.
    {MemoryUse::fetches, "fetches", 8},
    // Raw keyframes on their way to subscribers, each once for all of its rungs: the oldest are left out and counted.
    {MemoryUse::encoding, "encoding", 2},
    // What the encoder remembers: oldest first out.
    {MemoryUse::encoded, "encoded", 2},
    // Encoded keyframes of the stream that somebody still has to send, or that the encoder remembers: the
    // sessions that are furthest behind are closed.
    {MemoryUse::streamed, "streamed", 4},
    // Fetched tiles that nobody has read yet: the next fetch is refused.
    {MemoryUse::fetched, "fetched", 7},
    // Points that wait, and their answers: who asks more is refused beyond a half, newcomers beyond all.
    {MemoryUse::points, "points", 6},
    // Answers that nobody has read yet: the next query is refused.
    {MemoryUse::replies, "replies", 3},
    // Maps under way, with the surface they are of: refused.
    {MemoryUse::maps, "maps", 3},
    // Waves at the times of exact questions that are under way: who finds no room sums them anew in each slice.
    {MemoryUse::sums, "sums", 1},
    // Encoded waves, held for whoever asks next or not all sent: those that nobody reads make room, oldest use first;
    // who finds none even so is refused, and what is owed to a session of a later sea waits.
    {MemoryUse::spectra, "spectra", 1},
}};
inline constexpr int memory_parts = 65;

static_assert([] {
    int parts = 0;
    for (std::size_t row = 0; row < memory_uses; ++row) {
        if (static_cast<std::size_t>(memory_shares[row].use) != row)
            return false;
        parts += memory_shares[row].parts;
    }
    return parts == memory_parts;
}());

/// Bytes of one of the largest things that each use is for; 0 where they are small.
using MemoryNeeds = std::array<std::size_t, memory_uses>;

class Memory {
  public:
    /// Where a sea needs less. With the program itself the gale stays below 1 GB under attack.
    static constexpr std::size_t bytes_default = 640u * 1024 * 1024;

    /// The least budget that has room for one of each; what small things need included.
    static std::size_t least_bytes(const MemoryNeeds& needs);
    /// bytes_default, or more where the sea needs it: then a third of that is left to be shared, by which one client may have
    /// all the points in flight that the wire lets it.
    static std::size_t default_bytes(const MemoryNeeds& needs);

    /// Shares add up to `bytes`, which is at least least_bytes(needs).
    explicit Memory(std::size_t bytes = bytes_default, const MemoryNeeds& needs = {},
                    std::chrono::milliseconds trims_every = std::chrono::milliseconds(500));

    std::size_t bytes() const { return bytes_; }
    const std::shared_ptr<Room>& room(MemoryUse use) const {
        return rooms_[static_cast<std::size_t>(use)];
    }
    std::size_t share(MemoryUse use) const { return room(use)->bytes_max(); }
    /// Keyframes that nobody has used for one to two of these are let go, and so are maps whose spline alone was used.
    std::chrono::milliseconds trims_every() const { return trims_every_; }

    /// Prometheus text, names seaway_memory_*: what each use holds, has held at most and may hold.
    std::string metrics_text() const;

  private:
    const std::size_t bytes_;
    const std::chrono::milliseconds trims_every_;
    std::array<std::shared_ptr<Room>, memory_uses> rooms_;
};

using MemoryPtr = std::shared_ptr<Memory>;

} // namespace seaway::server
