// SPDX-License-Identifier: Apache-2.0
#include "gpu/device.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "gpu/call.h"
#include "gpu/commands.h"

namespace seaway::gpu {

namespace {

constexpr VkMemoryPropertyFlags unified_flags =
    VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT | VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT |
    VK_MEMORY_PROPERTY_HOST_COHERENT_BIT | VK_MEMORY_PROPERTY_HOST_CACHED_BIT;

struct GivenUp {
    std::mutex mutex; // guards devices
    std::vector<VkDevice> devices;
};

/// Never destroyed: owners of handles may go later than anything here.
GivenUp& given_up() {
    static GivenUp* const all = new GivenUp;
    return *all;
}

} // namespace

void give_up(VkDevice device) {
    const std::lock_guard lock(given_up().mutex);
    given_up().devices.push_back(device);
}

bool is_given_up(VkDevice device) {
    const std::lock_guard lock(given_up().mutex);
    return std::ranges::find(given_up().devices, device) != given_up().devices.end();
}

Result<std::unique_ptr<Device>> Device::create(const DeviceOptions& options) {
    std::unique_ptr<Device> made(new Device);
    Result<std::unique_ptr<Instance>> instance =
        Instance::create(options.validation, options.instance_extensions);
    if (!instance)
        return instance.error();
    made->instance_ = std::move(*instance);
    SEAWAY_TRY(made->pick(options));
    if (options.staged)
        made->unified_memory_ = false;
    if (Result<void> created = made->create_device(options); !created)
        return Error{made->info_.name + ": " + created.error().message};
    for (Timeline* timeline : {&made->timeline_, &made->transfers_})
        if (Result<void> created = made->create(*timeline); !created)
            return Error{made->info_.name + ": " + created.error().message};
    return made;
}

Result<void> Device::pick(const DeviceOptions& options) {
    Result<std::vector<VkPhysicalDevice>> physical = instance_->physical_devices();
    if (!physical)
        return physical.error();
    std::vector<DeviceInfo> infos;
    for (VkPhysicalDevice device : *physical)
        infos.push_back(describe(device, static_cast<int>(infos.size())));
    Result<int> index = pick_device(infos, options.pick, options.draws);
    if (options.only)
        index = find_device(infos, *options.only, index ? *index : -1);
    if (!index)
        return index.error();
    physical_ = (*physical)[static_cast<std::size_t>(*index)];
    info_ = infos[static_cast<std::size_t>(*index)];
    if (!info_.is_cpu()) // Mesa's for processors comes and goes at ease, with all of LLVM
        Instance::keep_drivers();
    queue_family_ = static_cast<std::uint32_t>(pick_queue_family(physical_));
    const std::vector<VkQueueFamilyProperties> families = queue_families(physical_);
    transfer_family_ = pick_transfer_family(families).value_or(queue_family_);
    time_stamp_bits_ = families[queue_family_].timestampValidBits;

    VkPhysicalDeviceVulkan13Properties v13{
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_PROPERTIES};
    VkPhysicalDeviceProperties2 properties{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2,
                                           .pNext = &v13};
    vkGetPhysicalDeviceProperties2(physical_, &properties);
    limits_ = properties.properties.limits;
    buffer_bytes_max_ = v13.maxBufferSize;
    vkGetPhysicalDeviceMemoryProperties(physical_, &memory_);
    // Unified: the biggest device-local heap itself can be mapped and cached.
    for (std::uint32_t i = 0; i < memory_.memoryTypeCount; ++i) {
        const VkMemoryType& type = memory_.memoryTypes[i];
        if ((type.propertyFlags & unified_flags) == unified_flags &&
            memory_.memoryHeaps[type.heapIndex].size == info_.memory_bytes)
            unified_memory_ = true;
    }
    return {};
}

Result<void> Device::create_device(const DeviceOptions& options) {
    VkPhysicalDeviceFeatures available;
    vkGetPhysicalDeviceFeatures(physical_, &available);
    features_.samplerAnisotropy = available.samplerAnisotropy;
    features_.fillModeNonSolid = available.fillModeNonSolid;
    features_.independentBlend = available.independentBlend;

    VkPhysicalDeviceVulkan13Features v13{.sType =
                                             VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES,
                                         .subgroupSizeControl = VK_TRUE,
                                         .computeFullSubgroups = VK_TRUE,
                                         .synchronization2 = VK_TRUE,
                                         .dynamicRendering = VK_TRUE,
                                         .maintenance4 = VK_TRUE};
    VkPhysicalDeviceVulkan12Features v12{.sType =
                                             VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES,
                                         .pNext = &v13,
                                         .timelineSemaphore = VK_TRUE};
    const VkPhysicalDeviceFeatures2 features{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2,
                                             .pNext = &v12,
                                             .features = features_};

    const float priority = 1;
    const auto one_of = [&](std::uint32_t family) {
        return VkDeviceQueueCreateInfo{.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                       .queueFamilyIndex = family,
                                       .queueCount = 1,
                                       .pQueuePriorities = &priority};
    };
    const VkDeviceQueueCreateInfo queues[] = {one_of(queue_family_), one_of(transfer_family_)};
    std::vector<const char*> extensions;
    for (const std::string& extension : options.device_extensions)
        extensions.push_back(extension.c_str());
    const VkDeviceCreateInfo info{
        .sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
        .pNext = &features,
        .queueCreateInfoCount = transfer_family_ != queue_family_ ? 2u : 1u,
        .pQueueCreateInfos = queues,
        .enabledExtensionCount = static_cast<std::uint32_t>(extensions.size()),
        .ppEnabledExtensionNames = extensions.data()};
    SEAWAY_TRY(call("vkCreateDevice", vkCreateDevice, physical_, &info, nullptr, &device_));
    vkGetDeviceQueue(device_, queue_family_, 0, &queue_);
    vkGetDeviceQueue(device_, transfer_family_, 0, &transfer_queue_);
    return {};
}

Result<void> Device::create(Timeline& timeline) {
    const VkSemaphoreTypeCreateInfo type{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO,
                                         .semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE,
                                         .initialValue = 0};
    const VkSemaphoreCreateInfo info{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO,
                                     .pNext = &type};
    VkSemaphore semaphore = VK_NULL_HANDLE;
    SEAWAY_TRY(call("vkCreateSemaphore", vkCreateSemaphore, device_, &info, nullptr, &semaphore));
    timeline.semaphore = OwnedSemaphore(device_, semaphore);
    return {};
}

Device::~Device() {
    if (device_ == VK_NULL_HANDLE)
        return;
    if (is_given_up(device_)) {
        (void)instance_.release(); // its driver may still work for the device
        return;
    }
    vkDeviceWaitIdle(device_);
    timeline_.semaphore.reset();
    transfers_.semaphore.reset();
    vkDestroyDevice(device_, nullptr);
}

int Device::memory_type(std::uint32_t bits, VkMemoryPropertyFlags required,
                        VkMemoryPropertyFlags preferred) const {
    int best = -1;
    int best_score = -1;
    for (std::uint32_t i = 0; i < memory_.memoryTypeCount; ++i) {
        const VkMemoryPropertyFlags flags = memory_.memoryTypes[i].propertyFlags;
        if (!(bits & (1u << i)) || (flags & required) != required)
            continue;
        if (const int score = std::popcount(flags & preferred); score > best_score) {
            best = static_cast<int>(i);
            best_score = score;
        }
    }
    return best;
}

namespace {

VkSemaphoreSubmitInfo semaphore_info(VkSemaphore handle, std::uint64_t value) {
    return {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO,
            .semaphore = handle,
            .value = value,
            .stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT};
}

} // namespace

Result<std::uint64_t> Device::submit(const Commands& commands, VkSemaphore after,
                                     VkSemaphore done) {
    return submit(queue_, timeline_, commands, semaphore_info(after, 0), done);
}

Result<std::uint64_t> Device::submit_transfer(const Commands& commands, std::uint64_t after) {
    return submit(transfer_queue_, transfers_, commands,
                  semaphore_info(timeline_.semaphore.get(), after), VK_NULL_HANDLE);
}

Result<std::uint64_t> Device::submit(VkQueue queue, Timeline& timeline, const Commands& commands,
                                     const VkSemaphoreSubmitInfo& after, VkSemaphore done) {
    const std::lock_guard lock(submit_mutex_);
    if (is_given_up(device_))
        return no_answer();
    const std::uint64_t ticket = timeline.last_ticket + 1;
    const VkCommandBufferSubmitInfo buffer{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO,
                                           .commandBuffer = commands.get()};
    const VkSemaphoreSubmitInfo signals[] = {semaphore_info(timeline.semaphore.get(), ticket),
                                             semaphore_info(done, 0)};
    const VkSubmitInfo2 info{.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2,
                             .waitSemaphoreInfoCount = after.semaphore != VK_NULL_HANDLE ? 1u : 0u,
                             .pWaitSemaphoreInfos = &after,
                             .commandBufferInfoCount = 1,
                             .pCommandBufferInfos = &buffer,
                             .signalSemaphoreInfoCount = done != VK_NULL_HANDLE ? 2u : 1u,
                             .pSignalSemaphoreInfos = signals};
    SEAWAY_TRY(call("vkQueueSubmit2", vkQueueSubmit2, queue, 1u, &info, VkFence(VK_NULL_HANDLE)));
    timeline.last_ticket = ticket;
    return ticket;
}

Result<void> Device::present(const VkPresentInfoKHR& info) {
    const std::lock_guard lock(submit_mutex_);
    return call("vkQueuePresentKHR", vkQueuePresentKHR, queue_, &info);
}

double Device::patience_s() const {
    constexpr double of_a_gpu_s = 60;
    return info_.is_cpu() ? std::numeric_limits<double>::infinity() : of_a_gpu_s;
}

Result<void> Device::wait(std::uint64_t ticket) {
    return wait(timeline_, ticket);
}

Result<void> Device::wait_transfer(std::uint64_t ticket) {
    return wait(transfers_, ticket);
}

Error Device::no_answer() const {
    return {VK_TIMEOUT, info_.name + " did not answer in time, and is given up"};
}

Result<void> Device::wait(const Timeline& timeline, std::uint64_t ticket) {
    if (is_given_up(device_))
        return no_answer();
    const VkSemaphore semaphore = timeline.semaphore.get();
    const VkSemaphoreWaitInfo info{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO,
                                   .semaphoreCount = 1,
                                   .pSemaphores = &semaphore,
                                   .pValues = &ticket};
    const std::uint64_t patience_ns = std::isinf(patience_s())
                                          ? std::numeric_limits<std::uint64_t>::max()
                                          : static_cast<std::uint64_t>(patience_s() * 1e9);
    Result<void> waited = call("vkWaitSemaphores", vkWaitSemaphores, device_, &info, patience_ns);
    if (waited)
        return waited;
    // The caller will free what the device may still be using.
    const std::lock_guard lock(submit_mutex_);
    if (waited.error().is(VK_TIMEOUT)) // it may be busy for ever
        give_up(device_);
    if (!is_given_up(device_))
        vkDeviceWaitIdle(device_);
    return waited;
}

Result<void> Device::wait_idle() {
    std::unique_lock lock(submit_mutex_);
    const std::uint64_t last = timeline_.last_ticket, last_copy = transfers_.last_ticket;
    lock.unlock();
    SEAWAY_TRY(wait(last)); // with patience, which the wait for all of it has not
    SEAWAY_TRY(wait_transfer(last_copy));
    lock.lock();
    if (is_given_up(device_))
        return no_answer();
    return call("vkDeviceWaitIdle", vkDeviceWaitIdle, device_);
}

Result<void> Device::submit_and_wait(const Commands& commands) {
    const Result<std::uint64_t> ticket = submit(commands);
    if (!ticket)
        return ticket.error();
    return wait(*ticket);
}

} // namespace seaway::gpu
