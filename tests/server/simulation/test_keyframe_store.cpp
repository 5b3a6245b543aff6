// SPDX-License-Identifier: Apache-2.0
// The keyframe store against a plain model of what it holds.
#include <algorithm>
#include <list>
#include <new>
#include <random>

#include <gtest/gtest.h>

#include "server/simulation/keyframe_store.h"
#include "tests/support/allocations.h"

namespace seaway::server {
namespace {

using sea::Field;
using sea::FieldSet;
using sea::TimeUs;

sea::KeyframePtr keyframe(int cascade, TimeUs time_us, FieldSet fields, int size = 8) {
    auto made = std::make_shared<sea::Keyframe>();
    made->epoch = 1;
    made->cascade = cascade;
    made->size = size;
    made->length_m = 10;
    made->time_us = time_us;
    made->fields = fields;
    made->values.assign(static_cast<std::size_t>(fields.size()) * made->plane_size(), 0.0f);
    return made;
}

std::size_t bytes_of(const sea::Keyframe& keyframe) {
    return keyframe.values.size() * sizeof(float);
}

TEST(KeyframeStore, memory_stays_below_its_limit_and_newest_use_stays) {
    const FieldSet height{Field::height, Field::height_rate};
    const std::size_t one = 2 * 64 * 64 * sizeof(float);
    KeyframeStore store(Room::of(4 * one));
    for (TimeUs t = 0; t < 100; ++t) {
        store.insert(keyframe(0, t, height, 64));
        EXPECT_TRUE(store.find({0, 0, {Field::height}})) << "used all the time, never dropped";
        EXPECT_LE(store.counters().bytes, 4 * one);
    }
    EXPECT_FALSE(store.find({0, 50, {Field::height}}));
    EXPECT_FALSE(store.find({0, 0, {Field::slope_x}})) << "held, but without this field";
}

// Naive: one order of use for all: a flood of far times throws out what everybody asks about.
TEST(KeyframeStore, what_is_streamed_stays_however_much_is_asked_for_elsewhere) {
    const FieldSet height{Field::height, Field::height_rate};
    const std::size_t one = 2 * 64 * 64 * sizeof(float);
    KeyframeStore store(Room::of(8 * one));
    for (TimeUs t = 0; t < 4; ++t)
        store.insert(keyframe(0, t, height, 64), true);
    for (TimeUs t = 1000; t < 1100; ++t)
        store.insert(keyframe(0, t, height, 64));
    for (TimeUs t = 0; t < 4; ++t)
        EXPECT_TRUE(store.find({0, t, height})) << t;
    EXPECT_EQ(store.counters().bytes, 8 * one);
    for (TimeUs t = 4; t < 100; ++t)
        store.insert(keyframe(0, t, height, 64), true);
    EXPECT_TRUE(store.find({0, 1099, height})) << "half of the room is for those who ask";
    EXPECT_TRUE(store.find({0, 99, height}));
    EXPECT_FALSE(store.find({0, 4, height}));
    EXPECT_EQ(store.counters().bytes, 8 * one);
}

// Naive: what was half added is counted when it is dropped, or is dropped where nothing stands.
TEST(KeyframeStore, one_for_which_there_is_no_memory_is_not_there_and_the_others_are) {
    const FieldSet height{Field::height, Field::height_rate};
    const std::size_t one = 2 * 64 * 64 * sizeof(float);
    int failed = 0;
    for (std::size_t after = 0; after < 40; ++after) {
        KeyframeStore store(Room::of(4 * one));
        store.insert(keyframe(0, 1, height, 64), true);
        const sea::KeyframePtr next = keyframe(0, 2, height, 64);
        const std::size_t before = store.counters().bytes;
        try {
            const tests::NoMemoryOnce none(after);
            store.insert(next);
            store.spline(next);
        } catch (const std::bad_alloc&) {
            ++failed;
            const bool held = store.find({0, 2, height}) != nullptr;
            EXPECT_EQ(store.counters().keyframes, held ? 2u : 1u) << after;
            EXPECT_EQ(store.counters().bytes, before + (held ? one : 0)) << after;
        }
        EXPECT_TRUE(store.find({0, 1, height})) << after;
        for (TimeUs t = 10; t < 20; ++t) { // all of the others have to make room
            store.insert(keyframe(0, t, height, 64));
            EXPECT_LE(store.counters().bytes, 4 * one) << after;
        }
    }
    EXPECT_GT(failed, 4);
}

TEST(KeyframeStore, what_nobody_uses_for_two_trims_is_let_go_with_its_spline) {
    const FieldSet height{Field::height, Field::height_rate};
    KeyframeStore store(Room::of(1u << 28));
    const sea::KeyframePtr used = keyframe(0, 0, height), unused = keyframe(0, 1, height);
    for (const sea::KeyframePtr& one : {used, unused}) {
        store.insert(one, one == used);
        store.spline(one);
    }
    const std::size_t both = store.counters().bytes;
    EXPECT_EQ(store.trim(), 0u) << "both have been used since";
    EXPECT_TRUE(store.find({0, 0, height}));
    EXPECT_EQ(store.trim(), both / 2);
    EXPECT_TRUE(store.splined({0, 0, {}}));
    EXPECT_FALSE(store.held({0, 1, {}}));
    store.trim();
    EXPECT_EQ(store.trim(), 0u);
    EXPECT_EQ(store.counters().bytes, 0u);
    EXPECT_EQ(store.counters().keyframes, 0u);
}

TEST(KeyframeStore, a_keyframe_larger_than_the_store_is_not_held_and_its_spline_is_still_made) {
    KeyframeStore store(Room::of(1000));
    const sea::KeyframePtr large = keyframe(0, 0, {Field::height, Field::height_rate}, 64);
    store.insert(large);
    EXPECT_EQ(store.counters().bytes, 0u);
    EXPECT_EQ(store.counters().keyframes, 0u);
    EXPECT_TRUE(store.spline(large));
    EXPECT_EQ(store.counters().bytes, 0u);
}

TEST(KeyframeStore, a_spline_is_of_the_keyframe_that_was_given_also_after_it_was_replaced) {
    KeyframeStore store(Room::of(1u << 28));
    const sea::KeyframePtr old = keyframe(0, 0, {Field::height, Field::height_rate});
    auto changed = std::make_shared<sea::Keyframe>(*old);
    std::fill(changed->values.begin(), changed->values.end(), 2.0f);
    store.insert(old);
    store.insert(changed);
    EXPECT_EQ(store.spline(old)->sample(1, 1).value[0], 0.0f);
    EXPECT_NEAR(store.spline(changed)->sample(1, 1).value[0], 2.0f, 1e-4f) // rounding of floats
        << "the spline of the one that was replaced has not taken its place";
    EXPECT_EQ(store.spline(old)->sample(1, 1).value[0], 0.0f);
}

/// The store as a list, oldest use last.
struct Model {
    struct Entry {
        sea::KeyframePtr keyframe;
        std::size_t spline_bytes = 0;
    };
    std::list<Entry> entries;
    std::size_t bytes_max;

    auto place(int cascade, TimeUs time_us) {
        return std::find_if(entries.begin(), entries.end(), [&](const Entry& entry) {
            return entry.keyframe->cascade == cascade && entry.keyframe->time_us == time_us;
        });
    }
    std::size_t bytes() const {
        std::size_t sum = 0;
        for (const Entry& entry : entries)
            sum += bytes_of(*entry.keyframe) + entry.spline_bytes;
        return sum;
    }
    void use(std::list<Entry>::iterator entry) {
        entries.splice(entries.begin(), entries, entry);
        while (bytes() > bytes_max)
            entries.pop_back();
    }
};

TEST(KeyframeStore, any_mix_of_uses_leaves_the_count_equal_to_the_bytes_held_and_below_the_limit) {
    const FieldSet field_sets[] = {{Field::height, Field::height_rate},
                                   sea::surface_fields,
                                   sea::surface_fields | FieldSet{Field::foam}};
    std::mt19937_64 numbers(16);
    const auto below = [&](std::uint64_t n) { return numbers() % n; };
    for (const std::size_t bytes_max : {3'000u, 20'000u, 100'000u}) {
        KeyframeStore store(Room::of(bytes_max));
        Model model{{}, bytes_max};
        for (int step = 0; step < 20'000; ++step) {
            const int cascade = static_cast<int>(below(2));
            const TimeUs time_us = static_cast<TimeUs>(below(12));
            const auto held = model.place(cascade, time_us);
            const std::uint64_t action = below(100);
            if (action < 40) { // inserts, or replaces
                const sea::KeyframePtr made =
                    keyframe(cascade, time_us, field_sets[below(3)], 4 << below(2));
                if (held != model.entries.end())
                    model.entries.erase(held);
                model.entries.push_front({made});
                model.use(model.entries.begin());
                store.insert(made);
            } else if (action < 70) {
                const FieldSet wanted = field_sets[below(3)];
                const bool found =
                    held != model.entries.end() && held->keyframe->fields.contains(wanted);
                EXPECT_EQ(store.find({cascade, time_us, wanted}) != nullptr, found);
                if (found)
                    model.use(held);
            } else {
                const bool known = held != model.entries.end();
                const sea::KeyframePtr of =
                    known ? held->keyframe : keyframe(cascade, time_us, field_sets[1]);
                const std::size_t spline_bytes = store.spline(of)->bytes();
                if (known) {
                    held->spline_bytes = spline_bytes;
                    model.use(held);
                }
            }
            const StoreCounters counters = store.counters();
            ASSERT_EQ(counters.bytes, model.bytes()) << "step " << step;
            ASSERT_EQ(counters.keyframes, model.entries.size()) << "step " << step;
            ASSERT_LE(counters.bytes, bytes_max);
            for (int c = 0; c < 2; ++c)
                for (TimeUs t = 0; t < 12; ++t) {
                    const auto expected = model.place(c, t);
                    ASSERT_EQ(store.held({c, t, {}}),
                              expected == model.entries.end() ? nullptr : expected->keyframe);
                }
        }
    }
}

} // namespace
} // namespace seaway::server
