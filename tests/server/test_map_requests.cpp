// SPDX-License-Identifier: Apache-2.0
// Bulk maps: what may be asked for, and what the world makes of it.
#include <atomic>
#include <chrono>
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <new>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "server/host/refusal.h"
#include "server/map_source.h"
#include "server/world.h"
#include "tests/server/simulation/simulation_bench.h"
#include "tests/server/stopped_clock.h"
#include "tests/support/allocations.h"
#include "tests/support/eventually.h"

namespace seaway::server {
namespace {

using Parameters = std::map<std::string, std::string>;
const Parameters some_map{
    {"width_m", "70.5"}, {"height_m", "30.25"}, {"columns", "8"}, {"rows", "5"}};

Parameters with(Parameters parameters, const std::string& name, const std::string& value) {
    parameters[name] = value;
    return parameters;
}

TEST(MapRequests, every_parameter_goes_where_it_says_and_has_its_default) {
    const auto defaults = read_map_request(some_map, 77);
    ASSERT_TRUE(defaults) << defaults.error().message;
    EXPECT_EQ(defaults->kind, sea::MapKind::height);
    EXPECT_EQ(defaults->x0_m, 0);
    EXPECT_EQ(defaults->y0_m, 0);
    EXPECT_EQ(defaults->width_m, 70.5);
    EXPECT_EQ(defaults->height_m, 30.25);
    EXPECT_EQ(defaults->columns, 8);
    EXPECT_EQ(defaults->rows, 5);
    EXPECT_EQ(defaults->time_us, 77);
    Parameters all = some_map;
    all.insert({{"kind", "normal"}, {"x0_m", "-3.5"}, {"y0_m", "1e3"}, {"t_s", "-2.5"}});
    const auto request = read_map_request(all, 77);
    ASSERT_TRUE(request) << request.error().message;
    EXPECT_EQ(request->kind, sea::MapKind::normal);
    EXPECT_EQ(request->x0_m, -3.5);
    EXPECT_EQ(request->y0_m, 1000);
    EXPECT_EQ(request->time_us, -2'500'000);
}

TEST(MapRequests, each_is_taken_up_to_its_limits_and_refused_by_name_and_value_beyond_them) {
    const auto expect = [](const char* name, const std::string& value, bool fine) {
        const auto request = read_map_request(with(some_map, name, value), 0);
        EXPECT_EQ(request.has_value(), fine) << name << " = " << value;
        if (request || fine)
            return;
        EXPECT_TRUE(request.error().is(Refusal::bad_value));
        EXPECT_NE(request.error().message.find(name), std::string::npos) << request.error().message;
    };
    struct Limits {
        const char* name;
        std::vector<std::string> within, beyond;
    };
    for (const Limits& row : {Limits{"kind", {"height", "displacement", "normal"}, {"foam", ""}},
                              {"x0_m", {"1e9", "-1e9", "1e-400"}, {"1.01e9", "-1e999", "nan"}},
                              {"y0_m", {"1e9", "-1e9"}, {"1.01e9", "-1.01e9", "nan"}},
                              {"width_m", {"1e6", "1e-3"}, {"1.01e6", "0", "-5", "nan", "inf"}},
                              {"height_m", {"1e6", "1e-3"}, {"1.01e6", "0", "-5", "nan", "inf"}},
                              {"columns", {"1", "4096"}, {"0", "4097", "-1", "8.5", "8x", ""}},
                              {"rows", {"1", "4096"}, {"0", "4097", "-1", "8.5", "8x", ""}},
                              {"t_s", {"1e12", "-1e12"}, {"1.01e12", "-1.01e12", "nan", "now"}},
                              {"colour", {}, {"blue"}}}) {
        for (const std::string& value : row.within)
            expect(row.name, value, true);
        for (const std::string& value : row.beyond)
            expect(row.name, value, false);
    }
}

// Naive: what no integer, or no double, can hold is called no number.
TEST(MapRequests, a_number_however_far_beyond_its_range_is_refused_with_that_range) {
    for (const auto& [name, value, range] : {std::tuple{"columns", "99999999999", "1 .. 4096"},
                                             {"rows", "-99999999999", "1 .. 4096"},
                                             {"x0_m", "1e999", "-1e9 .. 1e9"},
                                             {"t_s", "-1e999", "1000000000000"}}) {
        const auto request = read_map_request(with(some_map, name, value), 0);
        ASSERT_FALSE(request) << name;
        EXPECT_NE(request.error().message.find(range), std::string::npos)
            << request.error().message;
        EXPECT_NE(request.error().message.find(name), std::string::npos);
    }
    EXPECT_TRUE(read_map_request(with(some_map, "t_s", "1e-400"), 0)) << "which is 0";
}

// Without t_s a map is of now, and its header says so in its last eight bytes.
TEST(World, a_map_without_a_time_is_of_now) {
    Bench bench;
    const TimeUs now_us = 12'345'678;
    SeaClock clock = stopped_at(now_us);
    World world(bench.course, clock);
    world.attach(*bench.simulation);
    std::unique_ptr<ByteSource> map;
    std::atomic<bool> there = false;
    world.map({some_map, someone, [] {}}, [&](Result<std::unique_ptr<ByteSource>> made) {
        ASSERT_TRUE(made);
        map = *std::move(made);
        there = true;
    });
    ASSERT_TRUE(tests::eventually([&] { return there.load(); }));
    EXPECT_EQ(map->size(), 64u + 8 * 5 * 4);
    const std::vector<std::uint8_t> header = map->next();
    ASSERT_EQ(header.size(), 64u);
    TimeUs shown_us = 0;
    for (std::size_t i = 0; i < 8; ++i)
        shown_us |= static_cast<TimeUs>(header[56 + i]) << (8 * i);
    EXPECT_EQ(shown_us, now_us);
}

// Heights are one number a point, directions and places are three.
TEST(World, a_map_of_each_kind_is_as_long_as_it_says) {
    const std::pair<std::string, std::uint64_t> kinds[] = {
        {"height", 1}, {"displacement", 3}, {"normal", 3}};
    for (const auto& row : kinds) {
        const std::string& kind = row.first;
        const std::uint64_t numbers = row.second;
        Bench bench;
        SeaClock clock = stopped_at(0);
        World world(bench.course, clock);
        world.attach(*bench.simulation);
        std::map<std::string, std::string> parameters = some_map;
        parameters["kind"] = kind;
        std::unique_ptr<ByteSource> map;
        std::atomic<bool> there = false;
        world.map({parameters, someone, [] {}}, [&](Result<std::unique_ptr<ByteSource>> made) {
            ASSERT_TRUE(made) << kind;
            map = *std::move(made);
            there = true;
        });
        ASSERT_TRUE(tests::eventually([&] { return there.load(); }));
        EXPECT_EQ(map->size(), 64 + 8 * 5 * 4 * numbers) << kind;
        std::uint64_t bytes = 0;
        const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
        while (bytes < map->size() && std::chrono::steady_clock::now() < deadline) {
            const std::size_t more = map->next().size();
            bytes += more;
            if (more == 0) // not ready yet
                std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        EXPECT_EQ(bytes, map->size()) << kind;
        EXPECT_TRUE(map->next().empty()) << kind;
    }
}

/// A header and two chunks.
std::unique_ptr<ByteSource> map_in_three(const sea::Surface& surface) {
    const auto request = read_map_request(with(with(some_map, "columns", "512"), "rows", "512"), 0);
    EXPECT_TRUE(request);
    auto map = start_map(*request, surface, nullptr, [] {});
    EXPECT_TRUE(map);
    return *std::move(map);
}

void append_next(std::vector<std::uint8_t>& to, ByteSource& map) {
    std::vector<std::uint8_t> piece;
    EXPECT_TRUE(tests::eventually([&] { return !(piece = map.next()).empty(); }));
    to.insert(to.end(), piece.begin(), piece.end());
}

/// It has something to give, and nothing to put it into.
bool finds_no_memory(ByteSource& map) {
    try {
        const tests::NoMemoryOnce none(0);
        (void)map.next();
        return false;
    } catch (const std::bad_alloc&) {
        return true;
    }
}

// Naive: what there was no memory for is gone, and the rows behind it stand in its place.
TEST(MapRequests, rows_for_which_there_was_no_memory_come_when_they_are_asked_for_again) {
    Bench bench;
    const Result<SurfacePtr> surface = bench.surface(0);
    ASSERT_TRUE(surface);
    const auto map = map_in_three(**surface), same = map_in_three(**surface);
    std::vector<std::uint8_t> all, late;
    for (int piece = 0; piece < 3; ++piece) {
        append_next(all, *map);
        EXPECT_TRUE(tests::eventually([&] { return finds_no_memory(*same); })) << piece;
        append_next(late, *same);
    }
    EXPECT_EQ(all.size(), 64u + 512 * 512 * 4);
    EXPECT_TRUE(late == all);
}

TEST(Health, is_progress_not_only_life) {
    EXPECT_TRUE(health_of(true, std::chrono::seconds(0)).live);
    EXPECT_TRUE(health_of(true, stuck_after - std::chrono::milliseconds(1)).live);
    const Health stuck = health_of(true, std::chrono::milliseconds(42'900));
    EXPECT_FALSE(stuck.live);
    EXPECT_EQ(stuck.why, "the simulation has not come on for 42 s");
    EXPECT_FALSE(health_of(true, stuck_after).live);
    EXPECT_EQ(health_of(false, std::chrono::seconds(0)).why, "the simulation has failed");
}

} // namespace
} // namespace seaway::server
