// SPDX-License-Identifier: Apache-2.0
// What Vulkan devices there are, in words and numbers, and which of them a user means.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "gpu/vulkan.h"

namespace seaway::gpu {

/// Which device it is, wherever it is listed: a number of its own that stays over instances, drivers and reboots
/// (deviceUUID), and its name, for drivers that leave the number 0.
struct DeviceIdentity {
    std::array<std::uint8_t, VK_UUID_SIZE> uuid{};
    std::string name;

    bool operator==(const DeviceIdentity&) const = default;
};

struct DeviceInfo {
    int index = 0;      ///< position in list_devices()
    std::string name;   ///< "lavapipe (llvmpipe (LLVM 15.0.6, 256 bits))", "NVIDIA L4"
    std::string driver; ///< "Mesa 22.3.6", "NVIDIA 550.54"
    VkPhysicalDeviceType type = VK_PHYSICAL_DEVICE_TYPE_OTHER;
    std::uint32_t api_version = 0;
    std::uint32_t subgroup_size = 0;
    bool subgroup_shuffle = false;       ///< shuffles in compute shaders
    std::uint32_t subgroup_size_min = 0; ///< a kernel may find itself in any size between these
    std::uint32_t subgroup_size_max = 0;
    std::uint64_t memory_bytes = 0;                ///< largest device-local heap
    bool graphics = false;                         ///< its queue can draw
    std::array<std::uint8_t, VK_UUID_SIZE> uuid{}; ///< see DeviceIdentity
    std::string unusable;                          ///< empty, or why Seaway cannot run on it

    bool is_cpu() const { return type == VK_PHYSICAL_DEVICE_TYPE_CPU; }
    bool is_usable() const { return unusable.empty(); }
    DeviceIdentity identity() const { return {uuid, name}; }
};

/// Every device of this machine, usable or not. An error: no Vulkan loader, no driver.
Result<std::vector<DeviceInfo>> list_devices();

DeviceInfo describe(VkPhysicalDevice physical, int index);

/// Queue family for everything: graphics and compute if there is one, else compute; -1: none.
int pick_queue_family(VkPhysicalDevice physical);

/// A family that copies and does nothing else, as copying engines beside a GPU are; none where the device has none.
std::optional<std::uint32_t>
pick_transfer_family(std::span<const VkQueueFamilyProperties> families);
std::vector<VkQueueFamilyProperties> queue_families(VkPhysicalDevice physical);

/// `wish`: "auto" (discrete, integrated, virtual, then CPU), an index, or part of a name, case
/// ignored; `draws`: one that can draw. Returns the index; the error lists what there is.
Result<int> pick_device(std::span<const DeviceInfo> devices, std::string_view wish,
                        bool draws = false);

/// Where that very device is listed now; the error lists what there is.
Result<int> find_device(std::span<const DeviceInfo> devices, const DeviceIdentity& which,
                        int likely = -1);

} // namespace seaway::gpu
