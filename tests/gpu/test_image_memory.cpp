// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "gpu/call.h"
#include "gpu/image.h"
#include "tests/gpu/device_for_tests.h"

namespace seaway::gpu {
namespace {

// Naive: the name of the image takes the place of what kind of error it is, and whoever would do with less gives up.
TEST_F(DeviceTest, an_image_that_there_is_no_memory_for_is_told_from_one_that_cannot_be) {
    const auto made_but_for = [&](std::uint64_t call) {
        fault::arm(call, VK_ERROR_OUT_OF_DEVICE_MEMORY);
        Result<Image> made = Image::create(*device_, "some", {.width = 8, .height = 8});
        fault::disarm();
        return made;
    };
    constexpr std::uint64_t calls = 5; // what the format can, image, memory, both bound, view
    for (std::uint64_t call = 1; call <= calls; ++call) {
        const Result<Image> made = made_but_for(call);
        ASSERT_FALSE(made) << call;
        EXPECT_TRUE(is_out_of_memory(made.error())) << made.error().message;
    }
    EXPECT_TRUE(made_but_for(calls + 1));
    const Result<Image> never = Image::create(*device_, "some", {.width = 1u << 30, .height = 8});
    ASSERT_FALSE(never);
    EXPECT_FALSE(is_out_of_memory(never.error())) << never.error().message;
}

} // namespace
} // namespace seaway::gpu
