// SPDX-License-Identifier: Apache-2.0
// Instance: the Vulkan loader, and the validation layer where it is asked for. Made by Device;
// anything that only lists devices makes one for the moment.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "gpu/vulkan.h"

namespace seaway::gpu {

class Instance {
  public:
    /// `validation`: Khronos validation layer with synchronisation checks; an error if it is not
    /// installed. `extensions`: what a window system needs, else empty.
    static Result<std::unique_ptr<Instance>> create(bool validation,
                                                    std::span<const std::string> extensions);
    Instance(const Instance&) = delete;
    Instance& operator=(const Instance&) = delete;
    ~Instance();

    VkInstance get() const { return instance_; }
    Result<std::vector<VkPhysicalDevice>> physical_devices() const;

    /// Keeps drivers loaded for as long as the process runs, once and for all. One that goes with its last instance may not
    /// come again for ever: NVIDIA's (580) is found no more after some tens of times.
    static void keep_drivers();

    /// Warnings and errors of the validation layer so far: how many, and the first 16 of them.
    std::size_t validation_message_count() const { return message_count_; }
    std::vector<std::string> validation_messages() const;
    /// How many there were in all instances since the process began, those that are gone included.
    static std::size_t all_validation_messages();

    /// Called by the layer, on any thread.
    void note(const char* message);

  private:
    Instance() = default;
    Result<void> create_messenger();

    VkInstance instance_ = VK_NULL_HANDLE;
    VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
    std::atomic<std::size_t> message_count_{0};
    mutable std::mutex mutex_; // guards messages_
    std::vector<std::string> messages_;
};

} // namespace seaway::gpu
