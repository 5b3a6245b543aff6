// SPDX-License-Identifier: Apache-2.0
// The keyframe store against a plain model of what it holds.
#include <algorithm>
#include <array>
#include <cmath>
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
    for (int i = 0; i < 2; ++i)
        EXPECT_EQ(store.trim(), 0u) << "who begins to subscribe wants those of the stream";
    EXPECT_EQ(store.trim(), both / 2);
    EXPECT_EQ(store.counters().bytes, 0u);
    EXPECT_EQ(store.counters().keyframes, 0u);
}

TEST(KeyframeStore, what_was_made_for_a_question_and_the_stream_finds_is_of_the_stream) {
    const FieldSet height{Field::height, Field::height_rate};
    KeyframeStore store(Room::of(1u << 28));
    const sea::KeyframePtr asked = keyframe(0, 0, height);
    store.insert(asked);
    EXPECT_EQ(store.counters().asked, 1u);
    EXPECT_EQ(store.find({0, 0, height}, true), asked);
    EXPECT_EQ(store.counters().asked, 0u);
    store.spline(asked);
    EXPECT_EQ(store.held({0, 0, height}), asked) << "it is about to be sent";
    for (int i = 0; i < 3; ++i)
        EXPECT_EQ(store.trim(), 0u);
    EXPECT_EQ(store.trim(), bytes_of(*asked) + sea::SplineMap::bytes_of(8));
    EXPECT_EQ(store.counters().bytes, 0u);
}

// Naive: the maps stay for as long as points are answered, which are answered from the spline.
TEST(KeyframeStore, maps_that_nobody_uses_go_before_a_spline_that_somebody_uses) {
    const FieldSet height{Field::height, Field::height_rate};
    const auto room = Room::of(1u << 28);
    KeyframeStore store(room);
    const sea::KeyframePtr streamed = keyframe(0, 0, height), asked = keyframe(0, 1, height);
    const std::size_t spline = store.spline(asked)->bytes();
    for (const sea::KeyframePtr& one : {streamed, asked}) {
        store.insert(one, one == streamed);
        store.spline(one);
    }
    for (int i = 0; i < 3; ++i) {
        EXPECT_EQ(store.trim(), 0u);
        for (TimeUs t = 0; t < 2; ++t)
            EXPECT_TRUE(store.find_spline({0, t, height}));
        EXPECT_TRUE(store.find({0, 0, height})) << "of this one the maps are used, too";
    }
    EXPECT_EQ(store.trim(), bytes_of(*asked));
    EXPECT_EQ(store.counters().bytes, 2 * spline + bytes_of(*streamed));
    EXPECT_EQ(room->held_bytes(), store.counters().bytes);
    EXPECT_TRUE(store.held({0, 0, height}));
    EXPECT_FALSE(store.find({0, 1, height})) << "to be made again for who wants them";
    EXPECT_FALSE(store.held({0, 1, {}}));
    EXPECT_TRUE(store.splined({0, 1, height}));
    EXPECT_FALSE(store.splined({0, 1, sea::surface_fields})) << "it was made of heights alone";
    store.insert(asked);
    EXPECT_EQ(store.held({0, 1, {}}), asked);
    EXPECT_TRUE(store.splined({0, 1, height})) << "who asks for heights has them as before";
    store.insert(keyframe(0, 1, sea::surface_fields));
    EXPECT_FALSE(store.splined({0, 1, {}})) << "that one was made of fewer fields";
    for (int i = 0; i < 5; ++i)
        store.trim();
    EXPECT_EQ(store.counters().keyframes, 0u);
    EXPECT_EQ(room->held_bytes(), 0u);
    store.insert(asked);
    store.spline(asked);
    EXPECT_EQ(store.counters().bytes, spline) << "nothing is streamed that could want its maps";
    EXPECT_EQ(room->held_bytes(), spline);
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
    EXPECT_FALSE(store.splined({0, 0, {}}));
    const auto near_2 = [](const sea::SplineMapPtr& spline) { // rounding of floats
        return std::abs(spline->sample(1, 1).value[0] - 2.0f) < 1e-4f;
    };
    EXPECT_TRUE(near_2(store.spline(changed)))
        << "the spline of the one that was replaced has not taken its place";
    EXPECT_TRUE(near_2(store.find_spline({0, 0, {}})));
    EXPECT_EQ(store.spline(old)->sample(1, 1).value[0], 0.0f);
}

/// The store as a list, oldest use last.
struct Model {
    struct Entry {
        sea::KeyframePtr keyframe;
        bool has_maps = true;
        std::size_t spline_bytes = 0;
        FieldSet splined = {}; ///< of the keyframe that it was made of
        std::uint64_t used = 0, maps_used = 0;
        sea::KeyframePtr maps() const { return has_maps ? keyframe : nullptr; }
        std::size_t bytes() const { return (has_maps ? bytes_of(*keyframe) : 0) + spline_bytes; }
    };
    std::list<Entry> entries;
    std::size_t bytes_max;
    bool streamed; ///< all of them, or none
    std::uint64_t trims = 0;

    auto place(int cascade, TimeUs time_us) {
        return std::find_if(entries.begin(), entries.end(), [&](const Entry& entry) {
            return entry.keyframe->cascade == cascade && entry.keyframe->time_us == time_us;
        });
    }
    std::size_t bytes() const {
        std::size_t sum = 0;
        for (const Entry& entry : entries)
            sum += entry.bytes();
        return sum;
    }
    void insert(const sea::KeyframePtr& keyframe) {
        Entry made{keyframe};
        const auto held = place(keyframe->cascade, keyframe->time_us);
        if (held != entries.end()) {
            if (!held->has_maps && held->splined.contains(keyframe->fields & sea::surface_fields)) {
                made.spline_bytes = held->spline_bytes;
                made.splined = held->splined;
            }
            entries.erase(held);
        }
        made.maps_used = trims;
        entries.push_front(made);
        use(entries.begin());
    }
    void use(std::list<Entry>::iterator entry) {
        entry->used = trims;
        entries.splice(entries.begin(), entries, entry);
        while (bytes() > bytes_max)
            entries.pop_back();
    }
    /// That this is what it holds.
    void expect(const KeyframeStore& store) {
        ASSERT_EQ(store.counters().bytes, bytes());
        ASSERT_EQ(store.counters().keyframes, entries.size());
        ASSERT_LE(bytes(), bytes_max);
        for (int c = 0; c < 2; ++c)
            for (TimeUs t = 0; t < 12; ++t) {
                const auto expected = place(c, t);
                ASSERT_EQ(store.held({c, t, {}}),
                          expected == entries.end() ? nullptr : expected->maps());
            }
    }
    void trim() {
        const std::uint64_t longer = streamed ? 2 : 0;
        std::erase_if(entries, [&](const Entry& one) { return one.used + longer < trims; });
        for (Entry& one : entries)
            if (one.spline_bytes > 0 && one.maps_used + longer < trims)
                one.has_maps = false;
        ++trims;
    }
};

TEST(KeyframeStore, any_mix_of_uses_leaves_the_count_equal_to_the_bytes_held_and_below_the_limit) {
    const FieldSet field_sets[] = {{Field::height, Field::height_rate},
                                   sea::surface_fields,
                                   sea::surface_fields | FieldSet{Field::foam}};
    std::mt19937_64 numbers(16);
    const auto below = [&](std::uint64_t n) { return numbers() % n; };
    for (int run = 0; run < 6; ++run) {
        const std::size_t bytes_max = std::array{3'000u, 20'000u, 100'000u}[run / 2u];
        const auto room = Room::of(bytes_max);
        KeyframeStore store(room);
        Model model{{}, bytes_max, run % 2 == 0};
        for (int step = 0; step < 20'000; ++step) {
            const int cascade = static_cast<int>(below(2));
            const TimeUs time_us = static_cast<TimeUs>(below(12));
            const auto held = model.place(cascade, time_us);
            const bool known = held != model.entries.end();
            const std::uint64_t action = below(100);
            if (action < 40) { // inserts, or replaces
                const sea::KeyframePtr made =
                    keyframe(cascade, time_us, field_sets[below(3)], 4 << below(2));
                model.insert(made);
                store.insert(made, model.streamed);
            } else if (action < 65) {
                const FieldSet wanted = field_sets[below(3)];
                const bool found = known && held->maps() && held->keyframe->fields.contains(wanted);
                EXPECT_EQ(store.find({cascade, time_us, wanted}) != nullptr, found);
                if (found) {
                    held->maps_used = model.trims;
                    model.use(held);
                }
            } else if (action < 95) {
                const sea::KeyframePtr of =
                    known ? held->keyframe : keyframe(cascade, time_us, field_sets[1]);
                const sea::SplineMapPtr found =
                    store.find_spline({cascade, time_us, of->fields & sea::surface_fields});
                EXPECT_EQ(found != nullptr, known && held->spline_bytes > 0);
                const std::size_t spline_bytes = (found ? found : store.spline(of))->bytes();
                if (known) {
                    held->has_maps = held->has_maps && (found || model.streamed);
                    held->spline_bytes = spline_bytes;
                    if (!found)
                        held->splined = of->fields;
                    model.use(held);
                }
            } else {
                model.trim();
                store.trim();
            }
            ASSERT_EQ(room->held_bytes(), store.counters().bytes) << "step " << step;
            ASSERT_NO_FATAL_FAILURE(model.expect(store)) << "step " << step;
        }
    }
}

} // namespace
} // namespace seaway::server
