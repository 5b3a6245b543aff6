// SPDX-License-Identifier: Apache-2.0
// Keyframes of a device whose memory the CPU cannot read: several that are asked for together travel while the next are
// computed, in three places at most; one alone goes as it always did. lavapipe, treated as such a device: its one queue
// is the transfer queue, too.
#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "gpu/call.h"
#include "server/device/vulkan_synthesizer.h"
#include "tests/gpu/held_drivers.h"
#include "tests/gpu/read_in_place.h"
#include "tests/server/device/random_sea.h"

namespace seaway::server {
namespace {

using sea::Field;
using sea::FieldSet;

constexpr sea::TimeUs step_us = 1'000'000;
/// Of 13 maps that a sea of one cascade has room for at a time: four a run.
const FieldSet moved{Field::height, Field::displacement_x, Field::displacement_y};
constexpr int jobs_a_run = 4;

std::unique_ptr<VulkanSynthesizer> device_of(const sea::RealizationPtr& sea, bool staged) {
    auto made = make_vulkan_synthesizer({.validation = true, .staged = staged}).value();
    EXPECT_TRUE(made->set_sea(sea, 1));
    return made;
}

std::vector<KeyframeRequest> series(int count, sea::TimeUs from_us = 0) {
    std::vector<KeyframeRequest> requests;
    for (int i = 0; i < count; ++i)
        requests.push_back({0, from_us + i * step_us, moved});
    return requests;
}

class ReadbackRing : public testing::Test {
  protected:
    void TearDown() override {
        gpu::fault::disarm();
        for (const auto& device : {&ring_, &plain_})
            EXPECT_THAT((*device)->validation_messages(), testing::IsEmpty());
    }
    /// The same bits as one after the other, and as a device makes whose memory is read in place.
    void expect_same_bits(std::span<const KeyframeRequest> requests) {
        const auto together = ring_->synthesize(requests);
        ASSERT_TRUE(together) << together.error().message;
        for (std::size_t i = 0; i < requests.size(); ++i)
            for (const auto& device : {&ring_, &plain_}) {
                const auto alone = (*device)->synthesize({&requests[i], 1});
                ASSERT_TRUE(alone) << alone.error().message;
                EXPECT_EQ((*together)[i]->fields, requests[i].fields);
                EXPECT_EQ((*together)[i]->values, (*alone)[0]->values) << "request " << i;
            }
    }
    SynthesisCounters spent(std::span<const KeyframeRequest> requests) {
        const SynthesisCounters before = ring_->counters();
        EXPECT_TRUE(ring_->synthesize(requests));
        return ring_->counters() - before;
    }
    std::uint64_t calls_of(std::span<const KeyframeRequest> requests) {
        const std::uint64_t before = gpu::fault::calls();
        EXPECT_TRUE(ring_->synthesize(requests));
        return gpu::fault::calls() - before;
    }

    RandomSea random_{64, 200.0, 1, {1.1, 0.9}};
    /// A GPU's time stamps are read, once a run.
    std::uint64_t stamps_ = gpu::tested_device_info().is_cpu() ? 0 : 1;
    std::unique_ptr<VulkanSynthesizer> ring_ = device_of(random_.realization(), true);
    std::unique_ptr<VulkanSynthesizer> plain_ = device_of(random_.realization(), false);
};

TEST_F(ReadbackRing, keyframes_that_travel_beside_the_next_are_the_same_bits) {
    expect_same_bits(
        series(11 * jobs_a_run - 2)); // goes round the ring some times, and ends with a short run
    std::vector<KeyframeRequest> requests;
    for (int i = 0; i < 14;
         ++i) // of other lists of fields, with what they are made of and with none
        requests.push_back({0, i * step_us / 3,
                            i % 4 == 0   ? FieldSet{Field::jacobian}
                            : i % 4 == 1 ? FieldSet{}
                            : i % 4 == 2 ? moved
                                         : FieldSet{Field::slope_y, Field::height_rate}});
    expect_same_bits(requests);
}

TEST_F(ReadbackRing, cascades_of_any_sizes_share_it) {
    const RandomSea wide(128, 400.0, 2), narrow(64, 90.0, 3), third(512, 31.0, 4);
    auto sea = std::make_shared<sea::Realization>();
    sea->cascades = {wide.cascade(), narrow.cascade(), third.cascade()};
    for (const auto& device : {&ring_, &plain_})
        ASSERT_TRUE((*device)->set_sea(sea, 2));
    std::vector<KeyframeRequest> requests;
    for (int i = 0; i < 12; ++i)
        requests.push_back({(i * 2) % 3, i / 3 * step_us, moved});
    expect_same_bits(requests);
    // Those of 128 and of 64 are a run each; of 512 there is one a keyframe, but where a GPU takes them together.
    EXPECT_EQ(spent(requests).readbacks_beside, stamps_ == 0 ? 5u : 2u);
}

TEST_F(ReadbackRing, the_next_run_is_submitted_before_the_last_ones_maps_are_waited_for) {
    for (const int runs : {2, 3, 4, 9}) {
        const SynthesisCounters counts = spent(series(runs * jobs_a_run));
        EXPECT_EQ(counts.readbacks_beside, static_cast<std::uint64_t>(runs) - 1)
            << "all but the last, which nothing follows";
        EXPECT_EQ(counts.copies, static_cast<std::uint64_t>(runs * jobs_a_run));
        EXPECT_EQ(counts.readback_bytes, counts.copies * 3 * 64 * 64 * sizeof(float));
    }
}

// Begin, end, submit, wait: nothing else stands between a request and its keyframe.
TEST_F(ReadbackRing,
       one_alone_takes_no_call_of_the_driver_more_than_where_memory_is_read_in_place) {
    ASSERT_TRUE(ring_->synthesize(series(4 * jobs_a_run))); // the ring is there
    EXPECT_EQ(calls_of(series(1)), 4 + stamps_);
    EXPECT_EQ(spent(series(jobs_a_run)).readbacks_beside, 0u);
}

// What the ring has is made once: as many calls a run, whatever has been held since, and for how long. A run that another
// follows takes two recordings, two submissions and two waits; the last is one alone.
TEST_F(ReadbackRing, a_reader_that_holds_keyframes_costs_their_memory_and_no_place_of_the_ring) {
    ASSERT_TRUE(ring_->synthesize(series(4 * jobs_a_run)));
    const std::uint64_t followed = 8 + stamps_, last = 4 + stamps_, four = 3 * followed + last;
    EXPECT_EQ(calls_of(series(4 * jobs_a_run)), four);
    const auto held = ring_->synthesize(series(4 * jobs_a_run));
    ASSERT_TRUE(held);
    std::vector<sea::MapValues> before;
    for (const NewKeyframePtr& keyframe : *held)
        before.push_back(keyframe->values);
    for (int minute = 1; minute <= 20; ++minute) {
        const auto next = series(4 * jobs_a_run, minute * 60 * step_us);
        EXPECT_EQ(calls_of(next), four);
    }
    EXPECT_EQ(calls_of(series(40 * jobs_a_run)), four + 36 * followed);
    for (std::size_t i = 0; i < before.size(); ++i)
        EXPECT_EQ((*held)[i]->values, before[i]);
}

TEST_F(ReadbackRing, where_memory_is_read_in_place_nothing_travels) {
    if (!gpu::reads_in_place())
        GTEST_SKIP() << gpu::not_in_place;
    const SynthesisCounters before = plain_->counters();
    ASSERT_TRUE(plain_->synthesize(series(4 * jobs_a_run)));
    const SynthesisCounters counts = plain_->counters() - before;
    EXPECT_EQ(counts.readback_bytes, 0u);
    EXPECT_EQ(counts.readbacks_beside, 0u);
}

// Turns of one map in runs that are under way together: each begins where the one before it ended.
TEST_F(ReadbackRing, foam_goes_on_from_run_to_run) {
    std::vector<std::vector<NewKeyframePtr>> made;
    for (const auto& device : {&ring_, &plain_}) {
        FoamMapPtr map = (*device)->open_foam(64, nullptr).value();
        const FoamTurn turn{
            map.get(), some_tick, {sea::FoamTick::without_strains(1.0f, 0.0f), 1.0f}};
        std::vector<KeyframeRequest> requests;
        for (int i = 0; i < 12; ++i)
            requests.push_back({0, i * step_us,
                                i % 2 == 0 ? FieldSet{Field::height, Field::foam}
                                           : FieldSet{Field::foam, Field::slope_x},
                                1, &turn});
        auto keyframes = (*device)->synthesize(requests);
        ASSERT_TRUE(keyframes) << keyframes.error().message;
        made.push_back(std::move(*keyframes));
    }
    EXPECT_GT(ring_->counters().readbacks_beside, 6u) << "they were under way together";
    for (std::size_t i = 0; i < made[0].size(); ++i) {
        EXPECT_EQ(made[0][i]->values, made[1][i]->values) << i;
        if (i > 0) {
            EXPECT_FALSE(std::ranges::equal(made[0][i]->plane(Field::foam),
                                            made[0][i - 1]->plane(Field::foam)))
                << i;
        }
    }
}

TEST_F(ReadbackRing, after_any_call_that_fails_once_the_next_keyframes_are_right) {
    const std::vector<KeyframeRequest> requests = series(5 * jobs_a_run);
    const auto right = ring_->synthesize(requests);
    ASSERT_TRUE(right);
    const std::uint64_t calls = calls_of(requests);
    ASSERT_GT(calls, 20u);
    for (std::uint64_t n = 1; n <= calls; ++n) {
        gpu::fault::arm(n, VK_ERROR_OUT_OF_HOST_MEMORY);
        EXPECT_FALSE(ring_->synthesize(requests)) << "call " << n << " of " << calls;
        gpu::fault::disarm();
        const auto again = ring_->synthesize(requests);
        ASSERT_TRUE(again) << again.error().message << ", after call " << n;
        for (std::size_t i = 0; i < requests.size(); ++i)
            EXPECT_EQ((*again)[i]->values, (*right)[i]->values) << i << ", after call " << n;
    }
}

} // namespace
} // namespace seaway::server
