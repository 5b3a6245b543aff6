// SPDX-License-Identifier: Apache-2.0
// The one place that includes Vulkan, loaded at run time through volk: a host without Vulkan gets a
// sentence, not a linker error. Owned<> is the only owner of Vulkan handles in this room.
#pragma once

#define VK_NO_PROTOTYPES
#include <volk.h>

#include <utility>

namespace seaway::gpu {

/// A device that does not answer may still use what is of it: from now on nothing of that one is destroyed (Device::wait).
void give_up(VkDevice device);
bool is_given_up(VkDevice device);

/// Move-only owner of one device-level handle; `destroy` is volk's function pointer.
///     using OwnedFence = Owned<VkFence, &vkDestroyFence>;
template <class Handle, auto* destroy>
class Owned {
  public:
    Owned() = default;
    Owned(VkDevice device, Handle handle) : device_(device), handle_(handle) {}
    Owned(Owned&& other) noexcept
        : device_(other.device_), handle_(std::exchange(other.handle_, Handle{})) {}
    Owned& operator=(Owned&& other) noexcept {
        if (this != &other) {
            reset();
            device_ = other.device_;
            handle_ = std::exchange(other.handle_, Handle{});
        }
        return *this;
    }
    ~Owned() { reset(); }

    Handle get() const { return handle_; }
    explicit operator bool() const { return handle_ != Handle{}; }
    void reset() {
        const Handle gone = std::exchange(handle_, Handle{});
        if (gone != Handle{} && !is_given_up(device_))
            (*destroy)(device_, gone, nullptr);
    }

  private:
    VkDevice device_ = VK_NULL_HANDLE;
    Handle handle_{};
};

using OwnedBuffer = Owned<VkBuffer, &vkDestroyBuffer>;
using OwnedBufferView = Owned<VkBufferView, &vkDestroyBufferView>;
using OwnedMemory = Owned<VkDeviceMemory, &vkFreeMemory>;
using OwnedImage = Owned<VkImage, &vkDestroyImage>;
using OwnedImageView = Owned<VkImageView, &vkDestroyImageView>;
using OwnedSampler = Owned<VkSampler, &vkDestroySampler>;
using OwnedShaderModule = Owned<VkShaderModule, &vkDestroyShaderModule>;
using OwnedPipeline = Owned<VkPipeline, &vkDestroyPipeline>;
using OwnedPipelineLayout = Owned<VkPipelineLayout, &vkDestroyPipelineLayout>;
using OwnedSetLayout = Owned<VkDescriptorSetLayout, &vkDestroyDescriptorSetLayout>;
using OwnedDescriptorPool = Owned<VkDescriptorPool, &vkDestroyDescriptorPool>;
using OwnedCommandPool = Owned<VkCommandPool, &vkDestroyCommandPool>;
using OwnedSwapchain = Owned<VkSwapchainKHR, &vkDestroySwapchainKHR>;
using OwnedSemaphore = Owned<VkSemaphore, &vkDestroySemaphore>;
using OwnedQueryPool = Owned<VkQueryPool, &vkDestroyQueryPool>;

} // namespace seaway::gpu
