// SPDX-License-Identifier: Apache-2.0
// A device is found again by what it is, and not by its place in a list.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "gpu/device.h"
#include "gpu/device_info.h"

namespace seaway::gpu {
namespace {

DeviceInfo numbered(int index, const char* name, std::uint8_t number) {
    DeviceInfo info;
    info.index = index;
    info.name = name;
    info.uuid[0] = number;
    return info;
}

TEST(DeviceIdentity, a_device_is_found_wherever_it_is_listed_and_no_other_of_its_name) {
    const DeviceInfo wanted = numbered(0, "NVIDIA L4", 7);
    const std::vector<DeviceInfo> before{wanted, numbered(1, "lavapipe (llvmpipe)", 0)};
    EXPECT_EQ(*find_device(before, wanted.identity()), 0);
    EXPECT_EQ(*find_device(before, before[1].identity()), 1);
    // Twins whose driver tells no two apart: the one that was meant, as long as it is there.
    const std::vector<DeviceInfo> twins{numbered(0, "NVIDIA L4", 0), numbered(1, "NVIDIA L4", 0)};
    EXPECT_EQ(*find_device(twins, twins[1].identity(), 1), 1);
    EXPECT_EQ(*find_device(twins, twins[1].identity(), 7), 0);
    std::vector<DeviceInfo> now{numbered(0, "lavapipe (llvmpipe)", 0), numbered(1, "NVIDIA L4", 8),
                                numbered(2, "NVIDIA L4", 7)};
    EXPECT_EQ(*find_device(now, wanted.identity()), 2);
    now[2].unusable = "no compute queue";
    EXPECT_THAT(find_device(now, wanted.identity()).error().message,
                testing::HasSubstr("NVIDIA L4 cannot be used: no compute queue"));
    now.pop_back();
    const Result<int> gone = find_device(now, wanted.identity());
    ASSERT_FALSE(gone);
    EXPECT_EQ(gone.error().message, "Vulkan device NVIDIA L4 is not there; there are: 0 = lavapipe "
                                    "(llvmpipe), 1 = NVIDIA L4");
    EXPECT_FALSE(find_device({}, wanted.identity()));
}

TEST(DeviceIdentity, a_device_is_the_same_in_each_instance_and_made_whatever_is_picked) {
    const std::vector<DeviceInfo> devices = list_devices().value(), again = list_devices().value();
    const DeviceInfo& first = devices.at(*pick_device(devices, "auto"));
    EXPECT_EQ(*find_device(again, first.identity()), first.index);
    const auto made = Device::create({.pick = "no such device", .only = first.identity()});
    ASSERT_TRUE(made) << made.error().message;
    EXPECT_EQ((*made)->info().identity(), first.identity());
    DeviceIdentity other = first.identity();
    other.uuid[3] ^= 1;
    EXPECT_FALSE(Device::create({.pick = std::to_string(first.index), .only = other}));
}

} // namespace
} // namespace seaway::gpu
