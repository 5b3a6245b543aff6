// SPDX-License-Identifier: Apache-2.0
// Each piece of memory that a device's host side asks for is refused once: an error of that kind, nothing is under way any
// more, no map stays taken, and what comes next is right. Without the validation layer, which asks for memory on the same
// thread and would not survive that.
#include <functional>

#include <gtest/gtest.h>

#include "server/device/vulkan_batch.h"
#include "server/device/vulkan_synthesizer.h"
#include "tests/gpu/held_drivers.h"
#include "tests/gpu/read_in_place.h"
#include "tests/server/device/random_sea.h"
#include "tests/support/allocations.h"

namespace seaway::server {
namespace {

using sea::Field;
using sea::FieldSet;

const FieldSet four{Field::height, Field::displacement_x, Field::slope_y, Field::jacobian};

/// `work` must keep nothing. What comes after each refusal is the caller's to look at.
void refuse_each(const std::function<Result<void>()>& work, const std::function<void()>& then) {
    for (int i = 0; i < 2; ++i) // what stays is there
        ASSERT_TRUE(work());
    const tests::Allocations counted;
    ASSERT_TRUE(work());
    const std::size_t count = counted.count();
    std::size_t refused = 0;
    for (std::size_t n = 0; n < count; ++n) {
        const Result<void> worked = [&] {
            const tests::NoMemoryOnce none(n);
            return work();
        }();
        if (!worked) {
            EXPECT_TRUE(worked.error().is(DeviceError::out_of_memory)) << worked.error().message;
            ++refused;
        }
        SCOPED_TRACE(n);
        then();
    }
    // Of keyframes whose values another try has left behind there is less to ask for.
    EXPECT_GT(refused, count / 2);
}

class HostMemory : public testing::Test {
  protected:
    void make(const VulkanOptions& options) {
        device_ = make_vulkan_synthesizer(options).value();
        ASSERT_TRUE(device_->set_sea(random_.realization(), 1));
    }
    std::vector<KeyframeRequest> requests(std::span<const float> rounding = {}) const {
        std::vector<KeyframeRequest> all;
        for (int i = 0; i < 9; ++i)
            all.push_back({0, i * 700'000, four, 1, nullptr, rounding});
        return all;
    }
    void refuse_each_of(const std::vector<KeyframeRequest>& asked) {
        const auto right = device_->synthesize(asked).value();
        // Each is a run: all places of the ring, the first of them once more, and the one of a run that nothing follows.
        const auto next = std::span(asked).first(VulkanBatch::ring_slots + 2);
        refuse_each(
            [&]() -> Result<void> {
                SEAWAY_TRY_LET(const auto made, device_->synthesize(asked));
                return {};
            },
            [&] {
                const auto again = device_->synthesize(next);
                ASSERT_TRUE(again) << again.error().message;
                for (std::size_t i = 0; i < next.size(); ++i)
                    ASSERT_EQ((*again)[i]->values, right[i]->values) << i;
            });
    }

    RandomSea random_{64, 200.0, 1, {1.1, 0.9}};
    std::unique_ptr<VulkanSynthesizer> device_;
};

TEST_F(HostMemory, keyframes_that_travel_are_right_after_none_once) {
    make({.staged = true});
    refuse_each_of(requests());
}

TEST_F(HostMemory, rounded_keyframes_are_right_after_none_once) {
    make({.staged = true});
    // Heights do not fit 16 bits, and travel again.
    const std::vector<float> rounding{1e-6f, 0.002f, 0.0005f, 0.0003f};
    refuse_each_of(requests(rounding));
}

TEST_F(HostMemory, keyframes_that_stand_on_the_device_keep_no_place_after_none_once) {
    constexpr std::size_t map_bytes = 64 * 64 * sizeof(float);
    make({.held_map_bytes = 2 * 9 * 7 * map_bytes}); // twice what a run takes
    refuse_each_of(requests());
    if (gpu::reads_in_place()) {
        EXPECT_EQ(device_->counters().copies, 0u) << "there was room to the end";
    }
}

TEST_F(HostMemory, maps_that_stay_on_the_device_keep_no_place_after_none_once) {
    constexpr std::size_t map_bytes = 64 * 64 * sizeof(float);
    make({.held_map_bytes = 9 * 7 * map_bytes, .maps_stay = true});
    const auto asked = requests();
    const auto work = [&]() -> Result<void> {
        SEAWAY_TRY_LET(const auto made, device_->synthesize_there(asked));
        return {};
    };
    refuse_each(work, [&] { ASSERT_TRUE(work()); });
}

TEST_F(HostMemory, foam_maps_are_opened_after_none_once) {
    make({});
    const FoamMapPtr first = device_->open_foam(64, nullptr).value();
    const auto work = [&]() -> Result<void> {
        SEAWAY_TRY_LET(const FoamMapPtr opened, device_->open_foam(64, first.get()));
        return {};
    };
    refuse_each(work, [&] { ASSERT_TRUE(work()); });
}

} // namespace
} // namespace seaway::server
