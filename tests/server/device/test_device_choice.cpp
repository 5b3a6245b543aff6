// SPDX-License-Identifier: Apache-2.0
// What `--device` means, on machines that have been made up.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "server/device/device_choice.h"

namespace seaway::server {
namespace {

gpu::DeviceInfo device(int index, const char* name, VkPhysicalDeviceType type) {
    gpu::DeviceInfo info;
    info.index = index;
    info.name = name;
    info.type = type;
    return info;
}

const gpu::DeviceInfo lavapipe = device(0, "llvmpipe (lavapipe)", VK_PHYSICAL_DEVICE_TYPE_CPU);

std::vector<gpu::DeviceInfo> with(VkPhysicalDeviceType type) {
    return {lavapipe, device(1, "A GPU", type)};
}

TEST(DeviceChoice, auto_takes_hardware_of_every_kind) {
    for (const VkPhysicalDeviceType type :
         {VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU, VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU,
          VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU})
        EXPECT_EQ(choose_device(with(type), "auto")->vulkan, 1) << type;
}

TEST(DeviceChoice, auto_takes_native_and_never_a_driver_for_processors) {
    std::vector<gpu::DeviceInfo> broken = with(VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU);
    broken[1].unusable = "Vulkan 1.1, 1.3 needed";
    for (const auto& devices : {std::vector<gpu::DeviceInfo>{}, {lavapipe}, broken}) {
        const Result<DeviceChoice> choice = choose_device(devices, "auto");
        ASSERT_TRUE(choice) << choice.error().message;
        EXPECT_FALSE(choice->vulkan);
        EXPECT_EQ(choice->why, "there is no usable GPU");
    }
}

TEST(DeviceChoice, who_names_a_device_gets_it_or_is_told_what_there_is) {
    const auto devices = with(VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU);
    EXPECT_FALSE(choose_device(devices, "native")->vulkan);
    EXPECT_EQ(choose_device(devices, "lavapipe")->vulkan, 0);
    EXPECT_EQ(choose_device(devices, "1")->vulkan, 1);
    EXPECT_THAT(choose_device(devices, "abacus").error().message, testing::HasSubstr("1 = A GPU"));
}

TEST(DeviceChoice, lavapipe_by_name_is_lavapipe_and_native_needs_no_vulkan) {
    const auto lavapipe_made = make_synthesizer("lavapipe");
    ASSERT_TRUE(lavapipe_made) << lavapipe_made.error().message;
    EXPECT_THAT((*lavapipe_made)->description(), testing::HasSubstr("llvmpipe"));
    EXPECT_THAT((*make_synthesizer("native"))->description(), testing::HasSubstr("native"));
}

} // namespace
} // namespace seaway::server
