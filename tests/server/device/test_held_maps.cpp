// SPDX-License-Identifier: Apache-2.0
// Keyframes that stand where they were computed: nothing is copied while there is room, and what a slow reader holds is
// within the bound and nobody else's loss.
#include <algorithm>
#include <deque>
#include <fstream>
#include <set>

#include <gtest/gtest.h>
#include <unistd.h>

#include "gpu/call.h"
#include "server/device/spare_buffers.h"
#include "server/device/vulkan_maps.h"
#include "server/device/vulkan_synthesizer.h"
#include "tests/gpu/held_drivers.h"
#include "tests/gpu/read_in_place.h"
#include "tests/server/device/random_sea.h"

namespace seaway::server {
namespace {

using sea::Field;
using sea::FieldSet;

constexpr std::size_t map_bytes = 64 * 64 * sizeof(float);
constexpr sea::TimeUs second_us = 1'000'000;
const FieldSet fields{Field::height, Field::displacement_x, Field::displacement_y};

class HeldMaps : public testing::Test {
  protected:
    void SetUp() override {
        if (!gpu::reads_in_place())
            GTEST_SKIP() << gpu::not_in_place;
    }
    /// A device whose keyframes may hold so many maps of 64 x 64.
    void make(std::size_t maps, bool staged = false) {
        device_ = make_vulkan_synthesizer(
                      {.validation = true, .staged = staged, .held_map_bytes = maps * map_bytes})
                      .value();
        ASSERT_TRUE(device_->set_sea(random_.realization(), 1));
    }
    void TearDown() override {
        EXPECT_TRUE(device_ == nullptr || device_->validation_messages().empty());
    }
    sea::KeyframePtr keyframe(sea::TimeUs time_us, FieldSet asked = fields) {
        const KeyframeRequest request{0, time_us, asked};
        return device_->synthesize({&request, 1}).value()[0];
    }
    std::uint64_t copies() const { return device_->counters().copies; }

    RandomSea random_{64, 200.0, 1};
    std::unique_ptr<VulkanSynthesizer> device_;
};

TEST_F(HeldMaps, a_keyframe_that_is_let_go_leaves_its_place_to_the_next_and_none_is_copied) {
    make(6);
    for (int i = 0; i < 100; ++i) {
        const sea::KeyframePtr first = keyframe(i * second_us),
                               second = keyframe(i * second_us + 1);
        EXPECT_TRUE(first->values.is_lent() && second->values.is_lent());
        EXPECT_NE(first->values.data(), second->values.data());
    }
    EXPECT_EQ(copies(), 0u);
}

TEST_F(HeldMaps, when_all_are_held_keyframes_are_copied_and_are_the_same_maps) {
    make(6);
    const sea::KeyframePtr first = keyframe(0);
    sea::KeyframePtr second = keyframe(second_us);
    const sea::KeyframePtr third = keyframe(2 * second_us);
    EXPECT_EQ(copies(), 1u);
    EXPECT_FALSE(third->values.is_lent());
    second = nullptr;
    const sea::KeyframePtr again = keyframe(2 * second_us);
    EXPECT_TRUE(again->values.is_lent()) << "there is room again";
    EXPECT_EQ(again->values, third->values);
    EXPECT_EQ(copies(), 1u);
    EXPECT_FALSE(keyframe(0, fields | FieldSet{Field::slope_x})->values.is_lent())
        << "one map more than there is room for";
}

// A slow reader: a minute of a stream of six keyframes a second goes by, of which two are read at any time.
TEST_F(HeldMaps, what_is_held_for_a_minute_stays_as_it_is_and_costs_its_own_memory_alone) {
    make(9);
    const sea::KeyframePtr slow = keyframe(0);
    const sea::MapValues before = slow->values;
    ASSERT_FALSE(before.is_lent()) << "a copy has memory of its own";
    std::deque<sea::KeyframePtr> stream;
    std::vector<const float*> places;
    for (int i = 1; i <= 360; ++i) {
        stream.push_back(nullptr);
        if (stream.size() > 2)
            stream.pop_front();
        stream.back() = keyframe(i * second_us / 6);
        places.push_back(stream.back()->values.data());
    }
    EXPECT_EQ(slow->values, before);
    EXPECT_EQ(copies(), 0u);
    EXPECT_EQ(std::set(places.begin(), places.end()).size(), 2u)
        << "the stream went round in two places";
}

TEST_F(HeldMaps, keyframes_outlive_the_device_that_made_them) {
    make(9);
    const sea::KeyframePtr kept = keyframe(0);
    const sea::MapValues before = kept->values;
    gpu::fault::arm(1, VK_ERROR_DEVICE_LOST, true);
    const KeyframeRequest request{0, 0, fields};
    EXPECT_FALSE(device_->synthesize({&request, 1}));
    gpu::fault::disarm();
    device_ = nullptr;
    EXPECT_EQ(kept->values, before);
}

TEST_F(HeldMaps, a_run_that_fails_holds_nothing) {
    make(3);
    const KeyframeRequest request{0, 0, fields};
    for (int i = 0; i < 5; ++i) {
        gpu::fault::arm(3, VK_ERROR_OUT_OF_HOST_MEMORY); // the submission
        EXPECT_FALSE(device_->synthesize({&request, 1}));
        gpu::fault::disarm();
    }
    EXPECT_TRUE(keyframe(0)->values.is_lent());
}

// Naive: what a flood has touched of a pool of 128 MB is held for good, where the device's memory is the process's.
TEST_F(HeldMaps, pages_that_nobody_needs_any_more_go_back_and_what_is_held_stays) {
    const bool own = gpu::tested_device_info().is_cpu();
    make(9);
    sea::KeyframePtr kept = keyframe(0), flood = keyframe(second_us);
    const sea::KeyframePtr last = keyframe(2 * second_us);
    const sea::MapValues before = kept->values, next = flood->values, behind = last->values;
    const float* const place = flood->values.data();
    const std::size_t inside = std::size_t{64} * 64; // among its pages, not at an end
    ASSERT_NE(place[inside], 0.0f);
    flood = nullptr;
    for (int trim = 1; trim < VulkanMaps::kept_trims; ++trim)
        device_->trim();
    EXPECT_NE(place[inside], 0.0f) << "the next may come for it";
    device_->trim();
    EXPECT_EQ(place[inside] == 0.0f, own) << "a fresh page";
    EXPECT_EQ(kept->values, before);
    EXPECT_EQ(last->values, behind);
    flood = keyframe(second_us);
    EXPECT_EQ(flood->values.data(), place);
    EXPECT_EQ(flood->values, next);
    for (int trim = 0; trim < 2 * VulkanMaps::kept_trims; ++trim)
        device_->trim();
    EXPECT_EQ(flood->values, next) << "it is held";
}

// Naive: memory between the passes is held as the largest keyframe touched it.
TEST_F(HeldMaps, what_stood_between_the_passes_of_a_large_keyframe_goes_back_too) {
    const bool own = gpu::tested_device_info().is_cpu();
    const RandomSea large(512, 1600.0, 1);
    device_ = make_vulkan_synthesizer({.validation = true}).value();
    ASSERT_TRUE(device_->set_sea(large.realization(), 1));
    const sea::MapValues before = keyframe(second_us, sea::linear_fields)->values;
    const auto resident_bytes = [] {
        std::size_t pages = 0, resident = 0;
        std::ifstream("/proc/self/statm") >> pages >> resident;
        return resident * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
    };
    const std::size_t held_bytes = resident_bytes();
    for (int trim = 0; trim < 3 * VulkanMaps::kept_trims; ++trim)
        device_->trim();
    const std::size_t maps_bytes = before.size() * sizeof(float); // which go, too
    const std::size_t left_bytes = resident_bytes();
    EXPECT_TRUE(!own || left_bytes + maps_bytes * 5 / 4 < held_bytes)
        << "between the passes stands half as much again: " << left_bytes << " of " << held_bytes;
    EXPECT_EQ(keyframe(second_us, sea::linear_fields)->values, before);
}

TEST_F(HeldMaps, what_maps_are_made_of_is_free_at_once) {
    make(5); // the Jacobian with its three strains, and one more
    const sea::KeyframePtr jacobian = keyframe(0, {Field::jacobian});
    EXPECT_TRUE(jacobian->values.is_lent());
    EXPECT_TRUE(keyframe(0, fields | FieldSet{Field::slope_x})->values.is_lent());
}

/// Which any device can do.
class CopiedMaps : public HeldMaps {
    void SetUp() override {}
};

TEST_F(CopiedMaps, without_memory_that_both_read_every_keyframe_is_copied_and_counted) {
    make(100, true);
    EXPECT_FALSE(keyframe(0)->values.is_lent());
    EXPECT_EQ(copies(), 1u);
    keyframe(0, {});
    EXPECT_EQ(copies(), 1u) << "of nothing there is no copy";
}

// Keyframes of no fields (ticks of foam) and of maps that are lent end between those that have memory of their own.
TEST(SpareBuffers, keyframes_that_leave_no_memory_take_no_place_of_those_that_do) {
    const auto spare = std::make_shared<SpareBuffers>();
    std::vector<float> memory(4);
    {
        const std::shared_ptr<sea::Keyframe> copied = make_keyframe(spare);
        copied->values = spare->take(16);
        copied->values[3] = 7.0f; // fresh memory holds zeros
    }
    for (int i = 0; i < 40; ++i) {
        const std::shared_ptr<sea::Keyframe> lent = make_keyframe(spare);
        lent->values = sea::MapValues::lent(memory, spare);
        make_keyframe(spare);
    }
    EXPECT_EQ(spare->take(16)[3], 7.0f) << "it is still there";
    EXPECT_EQ(spare->take(16)[3], 0.0f) << "once";
    EXPECT_TRUE(spare->take(0).empty());
}

// Naive: what one flood of larger keyframes left is kept for the next, which never comes.
TEST(SpareBuffers, what_no_keyframe_has_come_for_is_let_go_of_and_what_is_used_stays) {
    SpareBuffers spare;
    const auto marked = [&spare](std::size_t values, float mark) {
        sea::MapValues::Floats buffer = spare.take(values);
        buffer[0] = mark;
        return buffer;
    };
    sea::MapValues::Floats first = marked(16, 7.0f), second = marked(16, 8.0f),
                           other = marked(9, 9.0f);
    spare.give(std::move(other));
    spare.give(std::move(second));
    spare.give(std::move(first));
    for (int trim = 1; trim < SpareBuffers::kept_trims; ++trim) {
        spare.trim();
        spare.give(spare.take(16)); // a stream goes on, and needs one
    }
    EXPECT_EQ(spare.take(9)[0], 9.0f) << "it is still there";
    spare.trim();
    sea::MapValues::Floats used = spare.take(16);
    EXPECT_EQ(used[0], 7.0f) << "the one that the stream uses";
    EXPECT_EQ(spare.take(16)[0], 0.0f) << "nobody has come for it: fresh memory holds zeros";
}

TEST(MapValues, lent_ones_are_written_in_place_and_let_go_of_once) {
    std::vector<float> memory(4, 1.0f);
    int gone = 0;
    {
        sea::MapValues lent = sea::MapValues::lent(
            memory, std::shared_ptr<const void>(memory.data(), [&gone](const void*) { ++gone; }));
        lent[2] = 5.0f;
        EXPECT_EQ(memory[2], 5.0f);
        sea::MapValues moved = std::move(lent);
        EXPECT_TRUE(lent.empty()); // NOLINT(bugprone-use-after-move): that is what is promised
        EXPECT_EQ(gone, 0);
        sea::MapValues copy = moved;
        copy[2] = 6.0f;
        EXPECT_EQ(memory[2], 5.0f) << "a copy is its own";
        moved.insert(moved.end(), 1, 7.0f);
        EXPECT_EQ(gone, 1) << "what is made longer moves to memory of its own";
        EXPECT_FALSE(moved.is_lent());
        EXPECT_EQ(moved, sea::MapValues(std::vector<float>{1, 1, 5, 1, 7}));
    }
    EXPECT_EQ(gone, 1);
}

} // namespace
} // namespace seaway::server
