// SPDX-License-Identifier: Apache-2.0
// Device: one logical device with one queue that computes, copies and (where it can) draws, and one that copies beside it
// where the hardware has such (a queue family of nothing but transfers); else both are the same.
//
//     Result<std::unique_ptr<Device>> device = Device::create({.pick = "auto"});
//     ... record Commands ...
//     Result<void> done = (*device)->submit_and_wait(commands);
//
// Everything made from a device must be gone before it. submit and wait are thread-safe; the rest
// is read-only after creation.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "gpu/device_info.h"
#include "gpu/instance.h"
#include "gpu/vulkan.h"

namespace seaway::gpu {

class Commands;

struct DeviceOptions {
    std::string pick = "auto";               ///< see pick_device()
    std::optional<DeviceIdentity> only = {}; ///< this very device, whatever `pick` says
    bool draws = false;                      ///< one that can draw is wanted
    bool validation = false;                 ///< Khronos validation layer; for tests
    bool staged = false; ///< copy as if the CPU could not see device memory; for tests
    std::vector<std::string> instance_extensions; ///< of a window system
    std::vector<std::string> device_extensions;   ///< VK_KHR_swapchain
};

class Device {
  public:
    /// An error names what is missing and lists the devices that there are.
    static Result<std::unique_ptr<Device>> create(const DeviceOptions& options);
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;
    ~Device();

    VkDevice get() const { return device_; }
    VkPhysicalDevice physical() const { return physical_; }
    VkInstance instance() const { return instance_->get(); }
    std::uint32_t queue_family() const { return queue_family_; }
    /// Of submit_transfer(); the same where the device has none beside.
    std::uint32_t transfer_family() const { return transfer_family_; }
    const DeviceInfo& info() const { return info_; }
    const VkPhysicalDeviceLimits& limits() const { return limits_; }
    const VkPhysicalDeviceFeatures& features() const { return features_; }
    /// The largest buffer that may be asked for (maxBufferSize).
    std::uint64_t buffer_bytes_max() const { return buffer_bytes_max_; }
    /// Of the time stamps of its queue (timestampValidBits); 0: it has none.
    std::uint32_t time_stamp_bits() const { return time_stamp_bits_; }

    /// True where device memory can be read and written in place by the CPU at full speed
    /// (lavapipe; GPUs that share memory which the processor caches, as Intel's): device buffers are mapped and need no copies.
    bool unified_memory() const { return unified_memory_; }

    /// Memory type for `bits` that has all of `required` and as many of `preferred` as there are;
    /// -1: none.
    int memory_type(std::uint32_t bits, VkMemoryPropertyFlags required,
                    VkMemoryPropertyFlags preferred) const;

    /// Queues recorded commands; the ticket is for wait(). Tickets grow. They start when `after` is signalled, and
    /// signal `done`, where a window system gives and wants semaphores.
    Result<std::uint64_t> submit(const Commands& commands, VkSemaphore after = VK_NULL_HANDLE,
                                 VkSemaphore done = VK_NULL_HANDLE);
    Result<void> present(const VkPresentInfoKHR& info);
    /// How long a wait lasts, s: a GPU that takes longer hangs. A processor is merely slow, and is waited for.
    double patience_s() const;
    /// Until that ticket's work is done; an error after patience_s() or if the device is lost. After
    /// an error nothing of this device runs any more; or, after patience_s(), it is given up: nobody waits for it again, submit() and
    /// wait() are errors at once, and what is made from it stays taken until the process ends, for it may still be written to.
    Result<void> wait(std::uint64_t ticket);
    /// Until nothing of it runs, or as wait() of what was submitted last.
    Result<void> wait_idle();
    Result<void> submit_and_wait(const Commands& commands);

    /// Queues copies, recorded for the transfer queue, that start when `after`, a ticket of submit(), is done. They have
    /// tickets of their own, for wait_transfer(), which is as wait().
    Result<std::uint64_t> submit_transfer(const Commands& commands, std::uint64_t after);
    Result<void> wait_transfer(std::uint64_t ticket);

    const Instance& validation() const { return *instance_; }

  private:
    Device() = default;
    Result<void> pick(const DeviceOptions& options);
    Result<void> create_device(const DeviceOptions& options);
    /// What was submitted to one queue, in order: tickets are its values. Those of two queues end in any order, so that
    /// each has its own.
    struct Timeline {
        OwnedSemaphore semaphore;
        std::uint64_t last_ticket = 0;
    };
    Result<void> create(Timeline& timeline);
    Result<std::uint64_t> submit(VkQueue queue, Timeline& timeline, const Commands& commands,
                                 const VkSemaphoreSubmitInfo& after, VkSemaphore done);
    Result<void> wait(const Timeline& timeline, std::uint64_t ticket);
    Error no_answer() const;

    // Order of members is order of construction; the destructor goes backwards.
    std::unique_ptr<Instance> instance_;
    VkPhysicalDevice physical_ = VK_NULL_HANDLE;
    DeviceInfo info_;
    VkPhysicalDeviceLimits limits_{};
    std::uint64_t buffer_bytes_max_ = 0;
    std::uint32_t time_stamp_bits_ = 0;
    VkPhysicalDeviceFeatures features_{};
    VkPhysicalDeviceMemoryProperties memory_{};
    bool unified_memory_ = false;
    VkDevice device_ = VK_NULL_HANDLE;
    VkQueue queue_ = VK_NULL_HANDLE;
    VkQueue transfer_queue_ = VK_NULL_HANDLE; ///< may be the same
    std::uint32_t queue_family_ = 0;
    std::uint32_t transfer_family_ = 0;
    Timeline timeline_, transfers_;
    std::mutex submit_mutex_; // guards the queues and last tickets
};

} // namespace seaway::gpu
