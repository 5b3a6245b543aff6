// SPDX-License-Identifier: Apache-2.0
#include "gpu/buffer.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <string>

#include "base/check.h"
#include "gpu/call.h"
#include "gpu/commands.h"

namespace seaway::gpu {

namespace {

constexpr VkBufferUsageFlags all_usages =
    VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT |
    VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT | VK_BUFFER_USAGE_VERTEX_BUFFER_BIT |
    VK_BUFFER_USAGE_INDEX_BUFFER_BIT | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT |
    VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;

struct MemoryWish {
    VkMemoryPropertyFlags required;
    VkMemoryPropertyFlags preferred;
};

MemoryWish wish(BufferKind kind, bool unified) {
    constexpr VkMemoryPropertyFlags host =
        VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    constexpr VkMemoryPropertyFlags local = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
    constexpr VkMemoryPropertyFlags cached = VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
    switch (kind) {
    case BufferKind::upload:
        return {host, 0};
    case BufferKind::readback:
        return {host, cached};
    case BufferKind::device:
        break;
    }
    return unified ? MemoryWish{host | local, cached} : MemoryWish{0, local};
}

// Buffers are of both families, so that a run that fails on the way leaves none half handed over. What that may cost, images
// pay: it is their layout that hardware compresses.
Result<OwnedBuffer> create_handle(Device& device, std::size_t bytes) {
    const std::array<std::uint32_t, 2> families{device.queue_family(), device.transfer_family()};
    const bool shared = families[0] != families[1];
    const VkBufferCreateInfo info{.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                                  .size = bytes,
                                  .usage = all_usages,
                                  .sharingMode = shared ? VK_SHARING_MODE_CONCURRENT
                                                        : VK_SHARING_MODE_EXCLUSIVE,
                                  .queueFamilyIndexCount = shared ? 2u : 0u,
                                  .pQueueFamilyIndices = families.data()};
    VkBuffer buffer = VK_NULL_HANDLE;
    SEAWAY_TRY(call("vkCreateBuffer", vkCreateBuffer, device.get(), &info, nullptr, &buffer));
    return OwnedBuffer(device.get(), buffer);
}

} // namespace

Result<Buffer> Buffer::create(Device& device, std::string_view name, std::size_t bytes,
                              BufferKind kind) {
    SEAWAY_CHECK(bytes > 0, "a buffer needs a size");
    const auto failed = [&](const Error& error) {
        return Error{error.kind, "buffer \"" + std::string(name) + "\", " + std::to_string(bytes) +
                                     " bytes: " + error.message};
    };
    if (bytes > device.buffer_bytes_max())
        return failed(
            {device.info().name + " allows " + std::to_string(device.buffer_bytes_max())});
    Buffer made;
    made.bytes_ = bytes;
    Result<OwnedBuffer> handle = create_handle(device, bytes);
    if (!handle)
        return failed(handle.error());
    made.buffer_ = std::move(*handle);

    VkMemoryRequirements needs;
    vkGetBufferMemoryRequirements(device.get(), made.buffer_.get(), &needs);
    const MemoryWish memory_wish = wish(kind, device.unified_memory());
    const int type =
        device.memory_type(needs.memoryTypeBits, memory_wish.required, memory_wish.preferred);
    if (type < 0)
        return failed({"the device has no memory of the kind needed"});
    const VkMemoryAllocateInfo allocate{.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                        .allocationSize = needs.size,
                                        .memoryTypeIndex = static_cast<std::uint32_t>(type)};
    VkDeviceMemory memory = VK_NULL_HANDLE;
    if (Result<void> allocated =
            call("vkAllocateMemory", vkAllocateMemory, device.get(), &allocate, nullptr, &memory);
        !allocated)
        return failed(allocated.error());
    made.memory_ = OwnedMemory(device.get(), memory);
    if (Result<void> bound = call("vkBindBufferMemory", vkBindBufferMemory, device.get(),
                                  made.buffer_.get(), memory, VkDeviceSize{0});
        !bound)
        return failed(bound.error());
    if (!(memory_wish.required & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT))
        return made;
    void* address = nullptr;
    if (Result<void> mapped =
            call("vkMapMemory", vkMapMemory, device.get(), memory, VkDeviceSize{0},
                 VkDeviceSize{VK_WHOLE_SIZE}, VkMemoryMapFlags{0}, &address);
        !mapped)
        return failed(mapped.error());
    made.mapped_ = {static_cast<std::byte*>(address), bytes};
    return made;
}

std::size_t bound_bytes_max(const Device& device, std::size_t texel_bytes) {
    const VkPhysicalDeviceLimits& limits = device.limits();
    return std::min({std::size_t{limits.maxStorageBufferRange},
                     std::size_t{limits.maxTexelBufferElements} * texel_bytes,
                     std::size_t{device.buffer_bytes_max()}});
}

Result<void> upload(Device& device, Buffer& buffer, std::span<const std::byte> bytes) {
    SEAWAY_CHECK(bytes.size() <= buffer.size_bytes(), "upload is longer than the buffer");
    if (!buffer.mapped().empty()) {
        std::memcpy(buffer.mapped().data(), bytes.data(), bytes.size());
        return {};
    }
    Result<Buffer> staging =
        Buffer::create(device, "staging for upload", bytes.size(), BufferKind::upload);
    if (!staging)
        return staging.error();
    std::memcpy(staging->mapped().data(), bytes.data(), bytes.size());
    return run_once(device,
                    [&](Commands& commands) { commands.copy(*staging, buffer, bytes.size()); });
}

Result<void> download(Device& device, const Buffer& buffer, std::span<std::byte> bytes) {
    SEAWAY_CHECK(bytes.size() <= buffer.size_bytes(), "download is longer than the buffer");
    if (!buffer.mapped().empty()) {
        std::memcpy(bytes.data(), buffer.mapped().data(), bytes.size());
        return {};
    }
    Result<Buffer> staging =
        Buffer::create(device, "staging for download", bytes.size(), BufferKind::readback);
    if (!staging)
        return staging.error();
    Result<void> copied = run_once(device, [&](Commands& commands) {
        // Who waited for what was written has made it available, but not visible to this submission.
        commands.barrier(Stage::compute, Stage::copy);
        commands.barrier(Stage::copy, Stage::copy);
        commands.copy(buffer, *staging, bytes.size());
        commands.barrier(Stage::copy, Stage::host);
    });
    if (copied)
        std::memcpy(bytes.data(), staging->mapped().data(), bytes.size());
    return copied;
}

Result<TexelView> TexelView::create(Device& device, const Buffer& buffer, VkFormat format,
                                    std::size_t texel_bytes, std::size_t offset_bytes,
                                    std::size_t range_bytes) {
    const std::size_t texels = range_bytes / texel_bytes;
    if (texels > device.limits().maxTexelBufferElements)
        return Error{"texel view of " + std::to_string(texels) + " texels: " + device.info().name +
                     " allows " + std::to_string(device.limits().maxTexelBufferElements)};
    const VkBufferViewCreateInfo info{.sType = VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO,
                                      .buffer = buffer.get(),
                                      .format = format,
                                      .offset = offset_bytes,
                                      .range = range_bytes};
    VkBufferView view = VK_NULL_HANDLE;
    SEAWAY_TRY(call("vkCreateBufferView", vkCreateBufferView, device.get(), &info, nullptr, &view));
    TexelView made;
    made.view_ = OwnedBufferView(device.get(), view);
    return made;
}

} // namespace seaway::gpu
