// SPDX-License-Identifier: Apache-2.0
// What only saves time is made at its first use, and done without where there is no memory for it: the ring of runs under way, and what
// maps are rounded in. lavapipe, treated as a device whose memory the CPU cannot read.
#include <memory>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "gpu/call.h"
#include "server/device/vulkan_synthesizer.h"
#include "tests/gpu/counted_memory.h"
#include "tests/server/device/random_sea.h"

namespace seaway::server {
namespace {

class MemoryOfRuns : public testing::Test {
  protected:
    void SetUp() override { begin(); }
    void TearDown() override { gpu::fault::disarm(); }
    void begin() {
        device_ = make_vulkan_synthesizer({.staged = true}).value();
        ASSERT_TRUE(device_->set_sea(random_.realization(), 1));
    }
    /// A run each, for their fields are others; `rounding`: of each field, or none.
    static std::vector<KeyframeRequest> three_runs(std::span<const float> rounding = {}) {
        return {{0, 0, {sea::Field::height}, 1, nullptr, rounding},
                {0, 1'000'000, {sea::Field::slope_x}, 1, nullptr, rounding},
                {0, 2'000'000, {sea::Field::slope_y}, 1, nullptr, rounding}};
    }
    std::vector<NewKeyframePtr> one_by_one() {
        std::vector<NewKeyframePtr> made;
        for (const KeyframeRequest& request : three_runs())
            made.push_back(device_->synthesize({&request, 1}).value()[0]);
        return made;
    }
    /// They are those, and travelled as they are.
    static void expect_exact(const Result<std::vector<NewKeyframePtr>>& made,
                             const std::vector<NewKeyframePtr>& right) {
        ASSERT_TRUE(made) << made.error().message;
        for (std::size_t i = 0; i < made->size(); ++i) {
            EXPECT_TRUE((*made)[i]->rounded.empty()) << i;
            EXPECT_EQ((*made)[i]->values, right[i]->values) << i;
        }
    }

    static constexpr float coarse_ = 1e-3f;
    const std::span<const float> rounding_{&coarse_, 1};
    RandomSea random_{64, 200.0, 6};
    std::unique_ptr<VulkanSynthesizer> device_;
};

/// Allocations of a place of the ring: its maps, and where they travel to.
constexpr int of_a_place = 2;

// Naive: the place that was under way when the next one was refused is kept for ever, and nobody asks for it again.
TEST_F(MemoryOfRuns, of_a_ring_that_there_is_no_memory_for_nothing_stays) {
    const auto right = one_by_one();
    gpu::CountedMemory memory;
    memory.refuse_after(of_a_place);
    expect_exact(device_->synthesize(three_runs()), right);
    EXPECT_EQ(memory.refused(), 1);
    EXPECT_EQ(memory.asked(), of_a_place + 1);
    EXPECT_EQ(memory.alive(), 0) << "the third run found the first one's place free";
    expect_exact(device_->synthesize(three_runs()), right);
    EXPECT_EQ(memory.asked(), of_a_place + 1) << "there is no ring any more";
}

TEST_F(MemoryOfRuns, of_such_a_ring_of_a_size_that_nobody_asks_for_nothing_stays_either) {
    const RandomSea wide(128, 400.0, 7);
    auto sea = std::make_shared<sea::Realization>();
    sea->cascades = {random_.cascade(), wide.cascade()};
    ASSERT_TRUE(device_->set_sea(sea, 2));
    const KeyframeRequest requests[] = {
        {0, 0, {sea::Field::height}}, {0, 0, {sea::Field::slope_x}}, {1, 0, {sea::Field::height}}};
    gpu::CountedMemory memory;
    memory.refuse_after(of_a_place);
    ASSERT_TRUE(device_->synthesize(requests));
    EXPECT_EQ(memory.refused(), 1);
    device_->trim();
    EXPECT_EQ(memory.alive(), 0);
}

// Naive: keyframes that could travel as they are, at twice the bytes, are refused for ever.
TEST_F(MemoryOfRuns, maps_travel_as_they_are_where_there_is_no_memory_to_round_them) {
    const auto right = one_by_one();
    const KeyframeRequest request = three_runs(rounding_)[0];
    gpu::CountedMemory memory;
    memory.refuse_after(0);
    expect_exact(device_->synthesize({&request, 1}), right);
    EXPECT_EQ(memory.asked(), 1);
    expect_exact(device_->synthesize({&request, 1}), right);
    EXPECT_EQ(memory.asked(), 1) << "it is not asked for in each run";
    EXPECT_EQ(device_->counters().maps_rounded, 0u);
}

TEST_F(MemoryOfRuns, runs_that_cannot_be_rounded_are_under_way_together_all_the_same) {
    const auto right = one_by_one();
    gpu::CountedMemory memory;
    memory.refuse_after(of_a_place);
    expect_exact(device_->synthesize(three_runs(rounding_)), right);
    EXPECT_EQ(memory.refused(), 1);
    EXPECT_EQ(memory.alive(), 2 * of_a_place);
    EXPECT_EQ(device_->counters().readbacks_beside, 2u);
}

TEST_F(MemoryOfRuns, where_the_rest_of_rounding_is_refused_its_memory_is_given_back) {
    const auto right = one_by_one();
    const KeyframeRequest request = three_runs(rounding_)[0];
    for (std::uint64_t n = 1; n <= 5; ++n) { // its buffer takes three calls, and what binds it two
        begin();
        gpu::CountedMemory memory;
        gpu::fault::arm(n, VK_ERROR_OUT_OF_DEVICE_MEMORY);
        const auto made = device_->synthesize({&request, 1});
        gpu::fault::disarm();
        expect_exact(made, right);
        EXPECT_EQ(memory.alive(), 0) << n;
    }
}

} // namespace
} // namespace seaway::server
