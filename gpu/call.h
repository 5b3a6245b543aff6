// SPDX-License-Identifier: Apache-2.0
// The one seam through which every fallible Vulkan call of this room goes: it turns a VkResult into
// an Error that names the call, and it is where a test makes the n-th call fail.
//
//     if (Result<void> made = call("vkCreateFence", vkCreateFence, device, &info, nullptr, &fence);
//         !made)
//         return made.error();
//
// Thread-safe. Cost beside the call: one relaxed atomic read.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>

#include "base/result.h"
#include "gpu/vulkan.h"

namespace seaway::gpu {

/// "VK_ERROR_DEVICE_LOST"; unknown codes as a number.
std::string result_name(VkResult result);

/// Is it that there is no memory, of the device or of this process, or no room in what a device keeps of it?
bool is_out_of_memory(const Error& error);

/// "vkQueueSubmit2: device lost (VK_ERROR_DEVICE_LOST)"; its kind is the VkResult.
Error call_error(const char* name, VkResult result);

namespace fault {

/// From now on the `nth` call (1 is the next one) is not made and returns `result` instead; with
/// `persistent` all later ones too, as after a lost device. For tests.
void arm(std::uint64_t nth, VkResult result, bool persistent = false);
void disarm();
/// Calls that went through the seam since the process began or since arm().
std::uint64_t calls();

namespace detail {
extern std::atomic<bool> armed;
extern std::atomic<std::uint64_t> count;
VkResult next(); ///< VK_SUCCESS, or what the armed fault says
} // namespace detail
} // namespace fault

template <class Function, class... Arguments>
Result<void> call(const char* name, Function function, Arguments... arguments) {
    fault::detail::count.fetch_add(1, std::memory_order_relaxed);
    if (fault::detail::armed.load(std::memory_order_relaxed))
        if (const VkResult injected = fault::detail::next(); injected != VK_SUCCESS)
            return call_error(name, injected);
    const VkResult result = function(arguments...);
    if (result < 0 || result == VK_TIMEOUT)
        return call_error(name, result);
    return {};
}

} // namespace seaway::gpu
