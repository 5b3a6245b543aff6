// SPDX-License-Identifier: Apache-2.0
// Allocations of device memory, counted, and refused as a device refuses them that is full. One at a time, for one thread, while there
// is a device.
#pragma once

#include <utility>

#include "gpu/vulkan.h"

namespace seaway::gpu {

class CountedMemory {
  public:
    CountedMemory()
        : allocate_(std::exchange(vkAllocateMemory, &on_allocate)),
          free_(std::exchange(vkFreeMemory, &on_free)) {
        there_ = this;
    }
    ~CountedMemory() {
        vkAllocateMemory = allocate_;
        vkFreeMemory = free_;
    }
    CountedMemory(const CountedMemory&) = delete;
    CountedMemory& operator=(const CountedMemory&) = delete;

    /// The one behind so many more, and none after it.
    void refuse_after(int more) { until_refused_ = more + 1; }
    int asked() const { return asked_; }
    int refused() const { return refused_; }
    /// Made since this began, less what was freed since.
    int alive() const { return alive_; }

  private:
    static VkResult on_allocate(VkDevice device, const VkMemoryAllocateInfo* info,
                                const VkAllocationCallbacks* callbacks, VkDeviceMemory* memory) {
        CountedMemory& own = *there_;
        ++own.asked_;
        if (own.until_refused_ > 0 && --own.until_refused_ == 0) {
            ++own.refused_;
            return VK_ERROR_OUT_OF_DEVICE_MEMORY;
        }
        const VkResult result = own.allocate_(device, info, callbacks, memory);
        own.alive_ += result == VK_SUCCESS;
        return result;
    }
    static void on_free(VkDevice device, VkDeviceMemory memory,
                        const VkAllocationCallbacks* callbacks) {
        --there_->alive_;
        there_->free_(device, memory, callbacks);
    }

    static inline CountedMemory* there_ = nullptr;
    const PFN_vkAllocateMemory allocate_;
    const PFN_vkFreeMemory free_;
    int until_refused_ = 0; ///< 0: none is
    int asked_ = 0, refused_ = 0, alive_ = 0;
};

} // namespace seaway::gpu
