// SPDX-License-Identifier: Apache-2.0
#include "gpu/call.h"

namespace seaway::gpu {

namespace {

struct Known {
    VkResult result;
    const char* name;
    const char* words;
};

constexpr Known known_results[] = {
    {VK_TIMEOUT, "VK_TIMEOUT", "the device did not answer in time"},
    {VK_ERROR_OUT_OF_HOST_MEMORY, "VK_ERROR_OUT_OF_HOST_MEMORY", "out of memory"},
    {VK_ERROR_OUT_OF_DEVICE_MEMORY, "VK_ERROR_OUT_OF_DEVICE_MEMORY", "out of device memory"},
    {VK_ERROR_INITIALIZATION_FAILED, "VK_ERROR_INITIALIZATION_FAILED", "could not be initialised"},
    {VK_ERROR_DEVICE_LOST, "VK_ERROR_DEVICE_LOST", "device lost"},
    {VK_ERROR_MEMORY_MAP_FAILED, "VK_ERROR_MEMORY_MAP_FAILED", "memory could not be mapped"},
    {VK_ERROR_LAYER_NOT_PRESENT, "VK_ERROR_LAYER_NOT_PRESENT", "layer not installed"},
    {VK_ERROR_EXTENSION_NOT_PRESENT, "VK_ERROR_EXTENSION_NOT_PRESENT", "extension not there"},
    {VK_ERROR_FEATURE_NOT_PRESENT, "VK_ERROR_FEATURE_NOT_PRESENT", "feature not there"},
    {VK_ERROR_INCOMPATIBLE_DRIVER, "VK_ERROR_INCOMPATIBLE_DRIVER", "no driver found"},
    {VK_ERROR_TOO_MANY_OBJECTS, "VK_ERROR_TOO_MANY_OBJECTS", "too many objects"},
    {VK_ERROR_FORMAT_NOT_SUPPORTED, "VK_ERROR_FORMAT_NOT_SUPPORTED", "format not supported"},
    {VK_ERROR_FRAGMENTED_POOL, "VK_ERROR_FRAGMENTED_POOL", "descriptor pool fragmented"},
    {VK_ERROR_OUT_OF_POOL_MEMORY, "VK_ERROR_OUT_OF_POOL_MEMORY", "descriptor pool full"},
    {VK_ERROR_SURFACE_LOST_KHR, "VK_ERROR_SURFACE_LOST_KHR", "surface lost"},
    {VK_ERROR_OUT_OF_DATE_KHR, "VK_ERROR_OUT_OF_DATE_KHR", "swapchain out of date"},
    {VK_ERROR_UNKNOWN, "VK_ERROR_UNKNOWN", "unknown error"},
};

} // namespace

std::string result_name(VkResult result) {
    for (const Known& known : known_results)
        if (known.result == result)
            return known.name;
    return "VkResult " + std::to_string(static_cast<int>(result));
}

bool is_out_of_memory(const Error& error) {
    return error.is(VK_ERROR_OUT_OF_DEVICE_MEMORY) || error.is(VK_ERROR_OUT_OF_HOST_MEMORY) ||
           error.is(VK_ERROR_TOO_MANY_OBJECTS);
}

Error call_error(const char* name, VkResult result) {
    for (const Known& known : known_results)
        if (known.result == result)
            return {result, std::string(name) + ": " + known.words + " (" + known.name + ")"};
    return {result, std::string(name) + ": failed (" + result_name(result) + ")"};
}

namespace fault {
namespace {
std::atomic<std::uint64_t> nth_call{0};
std::atomic<VkResult> injected_result{VK_SUCCESS};
std::atomic<bool> for_ever{false};
} // namespace

namespace detail {
std::atomic<bool> armed{false};
std::atomic<std::uint64_t> count{0};

VkResult next() {
    const std::uint64_t n = count.load();
    const bool hit = n == nth_call.load() || (for_ever.load() && n > nth_call.load());
    return hit ? injected_result.load() : VK_SUCCESS;
}
} // namespace detail

void arm(std::uint64_t nth, VkResult result, bool persistent) {
    detail::armed = false;
    detail::count = 0;
    nth_call = nth;
    injected_result = result;
    for_ever = persistent;
    detail::armed = true;
}

void disarm() {
    detail::armed = false;
}

std::uint64_t calls() {
    return detail::count.load();
}
} // namespace fault

} // namespace seaway::gpu
