// SPDX-License-Identifier: Apache-2.0
// One budget of bytes for all that is held for those who ask.
#include <atomic>
#include <chrono>
#include <thread>

#include <gtest/gtest.h>

#include "server/host/memory.h"
#include "server/simulation/memory_needs.h"
#include "server/simulation/point_question.h"
#include "tests/server/simulation/simulation_bench.h"
#include "tests/support/metrics_page.h"

namespace seaway::server {
namespace {

std::size_t sum_of_shares(const Memory& memory) {
    std::size_t sum = 0;
    for (const MemoryShare& share : memory_shares)
        sum += memory.share(share.use);
    return sum;
}

TEST(Memory, shares_are_all_of_the_budget_and_have_room_for_one_of_each) {
    const MemoryNeeds needs = needs_of(*running_sea());
    const std::size_t least = Memory::least_bytes(needs);
    for (const std::size_t bytes :
         {least, least + 12345, Memory::default_bytes(needs), 4 * least}) {
        const Memory memory(bytes, needs);
        EXPECT_LE(sum_of_shares(memory), bytes);
        EXPECT_GT(sum_of_shares(memory) + memory_parts, bytes) << "but for the last bytes";
        for (const MemoryShare& share : memory_shares)
            EXPECT_GE(memory.share(share.use), needs[static_cast<std::size_t>(share.use)])
                << share.name;
    }
    EXPECT_EQ(Memory::default_bytes({}), Memory::bytes_default);
    MemoryNeeds large{};
    large.back() = 2 * Memory::bytes_default;
    EXPECT_GT(Memory::default_bytes(large), large.back());
}

// Naive: where tiles are large, what is left beside one of each is what small things need, and an idle server refuses a client's second batch.
TEST(Memory, however_large_its_tiles_a_server_has_room_for_what_one_client_has_in_flight) {
    constexpr std::size_t points_of_a_query = 4096, queries_in_flight = 16; // protocol/limits.h
    constexpr std::size_t reply_bytes = 160u * 1024;
    MemoryNeeds needs{};
    for (const std::size_t mb : {0, 600, 800, 5000}) {
        needs[static_cast<std::size_t>(MemoryUse::keyframes)] = mb << 20;
        const Memory memory(Memory::default_bytes(needs), needs);
        const std::size_t batch = PointQuestion::bytes_of(points_of_a_query);
        EXPECT_GE(memory.share(MemoryUse::points) / 2, queries_in_flight * batch)
            << mb << " MB: who has one waiting finds half of it";
        EXPECT_GE(memory.share(MemoryUse::replies), queries_in_flight * reply_bytes) << mb;
    }
}

// A scene of large grids: a surface is 2 keyframes a cascade, of 6 fields and a spline of 8 numbers a point
// at least.
TEST(Memory, what_a_sea_needs_grows_with_its_grids) {
    const RunningSeaPtr sea = running_sea();
    double floats = 0;
    for (const sea::CascadeModes& modes : sea->realization->cascades)
        floats += 2.0 * modes.spec.size * modes.spec.size * (6 + 8);
    const MemoryNeeds needs = needs_of(*sea);
    const auto need = [&](MemoryUse use) {
        return static_cast<double>(needs[static_cast<std::size_t>(use)]);
    };
    for (const MemoryUse use :
         {MemoryUse::keyframes, MemoryUse::surfaces, MemoryUse::prompt_surfaces})
        EXPECT_GE(need(use), 4 * floats);
    EXPECT_LT(need(MemoryUse::surfaces), 3 * 4 * floats);
    EXPECT_GT(need(MemoryUse::maps), need(MemoryUse::surfaces));
    EXPECT_GE(need(MemoryUse::fetches), 4.0 * samples_per_slice) << "one part";
    EXPECT_EQ(need(MemoryUse::spectra), 4 * 4.0 * 2 * 64 * 64) << "four seas at once";
}

TEST(Memory, what_is_held_and_was_held_at_most_is_told_by_use) {
    const Memory memory(65'000);
    const auto value = [&](const std::string& name, const std::string& of) {
        return tests::read_metrics(memory.metrics_text())
            .values.at("seaway_memory_" + name + "{of=\"" + of + "\"}");
    };
    Room::Place maps = memory.room(MemoryUse::maps)->take(700);
    const Room::Place replies = memory.room(MemoryUse::replies)->take(11);
    EXPECT_EQ(value("held_bytes", "maps"), 700);
    EXPECT_EQ(value("held_bytes", "replies"), 11);
    EXPECT_EQ(value("share_bytes", "maps"), 3000);
    maps = nullptr;
    EXPECT_EQ(value("held_bytes", "maps"), 0);
    EXPECT_EQ(value("held_most_bytes", "maps"), 700);
    EXPECT_EQ(tests::read_metrics(memory.metrics_text()).values.at("seaway_memory_budget_bytes"),
              65'000);
}

// Each answer gives a place back: were all who wait woken by that, the network's thread would be held up by them.
TEST(Memory, only_who_lacked_room_is_called_when_there_is_some_again) {
    const auto room = Room::of(10);
    int calls = 0;
    room->on_freed([&] { ++calls; });
    (void)room->take(8);
    EXPECT_EQ(calls, 0) << "nobody lacked it";
    Room::Place held = room->take(8), small = room->take(1);
    EXPECT_FALSE(room->take(3));
    small = nullptr;
    EXPECT_EQ(calls, 1) << "who lacks it looks again";
    EXPECT_FALSE(room->fits(3));
    held = nullptr;
    EXPECT_EQ(calls, 2);
    EXPECT_TRUE(room->take(3)) << "and has it";
    EXPECT_EQ(calls, 2);
}

// One gives its only place back in the moment in which another looks, a hundred thousand times, or as often as two seconds let
// it on a busy machine: who finds none is called, or would wait for ever.
TEST(Memory, who_lacks_room_is_called_though_it_is_given_back_at_that_moment) {
    const auto room = Room::of(1);
    std::atomic<int> freed = 0, round = 0, gone = 0;
    room->on_freed([&] { ++freed; });
    constexpr int rounds = 100'000, no_more = rounds + 1;
    Room::Place held;
    std::thread gives([&] {
        for (int i = 1; i <= rounds; ++i) {
            while (round < i)
                ;
            if (round == no_more)
                return;
            held = nullptr;
            gone = i;
        }
    });
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(2);
    int never_called = 0;
    for (int i = 1; i <= rounds && std::chrono::steady_clock::now() < end; ++i) {
        held = room->take(1);
        const int before = freed;
        round = i;
        for (volatile int pause = i % 256;
             pause > 0;) // so that the two meet somewhere else each time
            pause = pause - 1;
        const bool found_none = room->take(1) == nullptr;
        while (gone < i)
            ;
        never_called += found_none && freed == before ? 1 : 0;
    }
    round = no_more;
    gives.join();
    EXPECT_EQ(never_called, 0);
}

TEST(Memory, a_thing_with_a_place_holds_it_until_its_last_holder_has_gone) {
    const auto room = Room::of(10);
    auto thing = with_place(room->take(8), std::make_shared<const int>(3));
    auto other = thing;
    thing = nullptr;
    EXPECT_EQ(*other, 3);
    EXPECT_EQ(room->held_bytes(), 8u);
    EXPECT_FALSE(room->take(8));
    const Room::Place more = room->take_anyway(8);
    EXPECT_TRUE(room->overfull());
    other = nullptr;
    EXPECT_FALSE(room->overfull());
}

} // namespace
} // namespace seaway::server
