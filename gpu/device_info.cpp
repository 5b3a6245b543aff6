// SPDX-License-Identifier: Apache-2.0
#include "gpu/device_info.h"

#include <algorithm>
#include <charconv>

#include "gpu/instance.h"

namespace seaway::gpu {

namespace {

std::string lower(std::string_view text) {
    std::string out(text);
    std::transform(out.begin(), out.end(), out.begin(), [](char c) {
        return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    });
    return out;
}

int rank(VkPhysicalDeviceType type) {
    switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
        return 4;
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
        return 3;
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
        return 2;
    case VK_PHYSICAL_DEVICE_TYPE_CPU:
        return 1;
    default:
        return 0;
    }
}

std::string names_of(std::span<const DeviceInfo> devices) {
    std::string text;
    for (const DeviceInfo& device : devices) {
        text += text.empty() ? "" : ", ";
        text += std::to_string(device.index) + " = " + device.name;
        if (!device.is_usable())
            text += " [" + device.unusable + "]";
    }
    return text.empty() ? "none" : text;
}

Error cannot_be_used(const DeviceInfo& device, const std::string& why) {
    return Error{"Vulkan device " + device.name + " cannot be used: " + why};
}

std::string why_unusable(const DeviceInfo& info, VkPhysicalDevice physical) {
    if (info.api_version < VK_API_VERSION_1_3)
        return "Vulkan " + std::to_string(VK_API_VERSION_MAJOR(info.api_version)) + "." +
               std::to_string(VK_API_VERSION_MINOR(info.api_version)) + ", 1.3 needed";
    if (pick_queue_family(physical) < 0)
        return "no compute queue";
    return {};
}

} // namespace

std::vector<VkQueueFamilyProperties> queue_families(VkPhysicalDevice physical) {
    std::uint32_t count = 0;
    vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, nullptr);
    std::vector<VkQueueFamilyProperties> families(count);
    vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, families.data());
    return families;
}

std::optional<std::uint32_t>
pick_transfer_family(std::span<const VkQueueFamilyProperties> families) {
    // What works on video or on optical flow copies too, as a sideline.
    constexpr VkQueueFlags beside = VK_QUEUE_SPARSE_BINDING_BIT | VK_QUEUE_PROTECTED_BIT;
    for (std::uint32_t i = 0; i < families.size(); ++i)
        if (families[i].queueCount > 0 &&
            (families[i].queueFlags & ~beside) == VK_QUEUE_TRANSFER_BIT)
            return i;
    return std::nullopt;
}

int pick_queue_family(VkPhysicalDevice physical) {
    const std::vector<VkQueueFamilyProperties> families = queue_families(physical);
    int compute = -1;
    for (std::uint32_t i = 0; i < families.size(); ++i) {
        if (!(families[i].queueFlags & VK_QUEUE_COMPUTE_BIT))
            continue;
        if (families[i].queueFlags & VK_QUEUE_GRAPHICS_BIT)
            return static_cast<int>(i);
        if (compute < 0)
            compute = static_cast<int>(i);
    }
    return compute;
}

DeviceInfo describe(VkPhysicalDevice physical, int index) {
    VkPhysicalDeviceVulkan13Properties v13{
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_PROPERTIES};
    VkPhysicalDeviceVulkan12Properties v12{
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_PROPERTIES, .pNext = &v13};
    VkPhysicalDeviceVulkan11Properties v11{
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_PROPERTIES, .pNext = &v12};
    VkPhysicalDeviceProperties2 properties{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2,
                                           .pNext = &v11};
    vkGetPhysicalDeviceProperties2(physical, &properties);
    VkPhysicalDeviceMemoryProperties memory;
    vkGetPhysicalDeviceMemoryProperties(physical, &memory);

    DeviceInfo info;
    info.index = index;
    info.name = properties.properties.deviceName;
    if (v12.driverID == VK_DRIVER_ID_MESA_LLVMPIPE)
        info.name = "lavapipe (" + info.name + ")";
    info.driver = std::string(v12.driverName) + " " + v12.driverInfo;
    info.type = properties.properties.deviceType;
    info.uuid = std::to_array(v11.deviceUUID);
    info.api_version = properties.properties.apiVersion;
    info.subgroup_size = v11.subgroupSize;
    info.subgroup_shuffle =
        (v11.subgroupSupportedStages & VK_SHADER_STAGE_COMPUTE_BIT) &&
        (v11.subgroupSupportedOperations & VK_SUBGROUP_FEATURE_SHUFFLE_RELATIVE_BIT) &&
        (v11.subgroupSupportedOperations & VK_SUBGROUP_FEATURE_SHUFFLE_BIT);
    info.subgroup_size_min = v13.minSubgroupSize;
    info.subgroup_size_max = v13.maxSubgroupSize;
    for (std::uint32_t i = 0; i < memory.memoryHeapCount; ++i)
        if (memory.memoryHeaps[i].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT)
            info.memory_bytes = std::max(info.memory_bytes, memory.memoryHeaps[i].size);
    info.unusable = why_unusable(info, physical);
    if (const int family = pick_queue_family(physical); family >= 0)
        info.graphics = queue_families(physical)[static_cast<std::size_t>(family)].queueFlags &
                        VK_QUEUE_GRAPHICS_BIT;
    return info;
}

Result<std::vector<DeviceInfo>> list_devices() {
    Result<std::unique_ptr<Instance>> instance = Instance::create(false, {});
    if (!instance)
        return instance.error();
    Result<std::vector<VkPhysicalDevice>> physical = (*instance)->physical_devices();
    if (!physical)
        return physical.error();
    std::vector<DeviceInfo> devices;
    for (VkPhysicalDevice device : *physical)
        devices.push_back(describe(device, static_cast<int>(devices.size())));
    return devices;
}

Result<int> pick_device(std::span<const DeviceInfo> devices, std::string_view wish, bool draws) {
    const auto why_not = [draws](const DeviceInfo& device) -> std::string {
        return device.is_usable() && draws && !device.graphics ? "it cannot draw" : device.unusable;
    };
    if (wish == "auto") {
        const DeviceInfo* best = nullptr;
        for (const DeviceInfo& device : devices)
            if (why_not(device).empty() && (!best || rank(device.type) > rank(best->type)))
                best = &device;
        if (!best)
            return Error{std::string("no usable Vulkan device") + (draws ? " that can draw" : "") +
                         "; there are: " + names_of(devices) +
                         " (mesa-vulkan-drivers has one that needs no GPU)"};
        return best->index;
    }
    int index = -1;
    const auto [end, status] = std::from_chars(wish.data(), wish.data() + wish.size(), index);
    const bool is_number = status == std::errc() && end == wish.data() + wish.size();
    for (const DeviceInfo& device : devices) {
        const bool named = is_number ? device.index == index
                                     : lower(device.name).find(lower(wish)) != std::string::npos;
        if (!named || wish.empty())
            continue;
        if (const std::string why = why_not(device); !why.empty())
            return cannot_be_used(device, why);
        return device.index;
    }
    return Error{"no Vulkan device \"" + std::string(wish) + "\"; there are: " + names_of(devices)};
}

Result<int> find_device(std::span<const DeviceInfo> devices, const DeviceIdentity& which,
                        int likely) {
    auto found = std::ranges::find(devices, which, &DeviceInfo::identity);
    for (auto twin = found; twin != devices.end(); ++twin)
        if (twin->index == likely && twin->identity() == which)
            found = twin;
    if (found == devices.end())
        return Error{"Vulkan device " + which.name +
                     " is not there; there are: " + names_of(devices)};
    if (!found->is_usable())
        return cannot_be_used(*found, found->unusable);
    return found->index;
}

} // namespace seaway::gpu
