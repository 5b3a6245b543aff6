// SPDX-License-Identifier: Apache-2.0
#include "gpu/commands.h"

#include <algorithm>

#include "base/check.h"
#include "gpu/call.h"

namespace seaway::gpu {

namespace {

struct Scope {
    VkPipelineStageFlags2 stage;
    VkAccessFlags2 access;
};

Scope scope(Stage stage) {
    switch (stage) {
    case Stage::compute:
        return {VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
                VK_ACCESS_2_SHADER_READ_BIT | VK_ACCESS_2_SHADER_WRITE_BIT};
    case Stage::copy:
        return {VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
                VK_ACCESS_2_TRANSFER_READ_BIT | VK_ACCESS_2_TRANSFER_WRITE_BIT};
    case Stage::host:
        return {VK_PIPELINE_STAGE_2_HOST_BIT,
                VK_ACCESS_2_HOST_READ_BIT | VK_ACCESS_2_HOST_WRITE_BIT};
    case Stage::graphics:
        break;
    }
    return {VK_PIPELINE_STAGE_2_ALL_GRAPHICS_BIT,
            VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT};
}

} // namespace

Result<Commands> Commands::create(Device& device, Queue queue) {
    Commands made;
    made.device_ = device.get();
    made.groups_max_ = std::to_array(device.limits().maxComputeWorkGroupCount);
    const VkCommandPoolCreateInfo pool_info{
        .sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
        .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
        .queueFamilyIndex =
            queue == Queue::main ? device.queue_family() : device.transfer_family()};
    VkCommandPool pool = VK_NULL_HANDLE;
    SEAWAY_TRY(
        call("vkCreateCommandPool", vkCreateCommandPool, device.get(), &pool_info, nullptr, &pool));
    made.pool_ = OwnedCommandPool(device.get(), pool);
    const VkCommandBufferAllocateInfo buffer_info{
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
        .commandPool = pool,
        .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
        .commandBufferCount = 1};
    SEAWAY_TRY(call("vkAllocateCommandBuffers", vkAllocateCommandBuffers, device.get(),
                    &buffer_info, &made.buffer_));
    return made;
}

Result<void> Commands::begin() {
    if (recording_)
        SEAWAY_TRY(call("vkResetCommandPool", vkResetCommandPool, device_, pool_.get(),
                        VkCommandPoolResetFlags{0}));
    const VkCommandBufferBeginInfo info{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    Result<void> begun = call("vkBeginCommandBuffer", vkBeginCommandBuffer, buffer_, &info);
    recording_ = begun.has_value();
    return begun;
}

Result<void> Commands::end() {
    Result<void> ended = call("vkEndCommandBuffer", vkEndCommandBuffer, buffer_);
    recording_ = !ended;
    return ended;
}

void Commands::barrier(Stage from, Stage to) {
    const Scope source = scope(from);
    const Scope target = scope(to);
    const VkMemoryBarrier2 memory{.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
                                  .srcStageMask = source.stage,
                                  .srcAccessMask = source.access,
                                  .dstStageMask = target.stage,
                                  .dstAccessMask = target.access};
    const VkDependencyInfo info{.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
                                .memoryBarrierCount = 1,
                                .pMemoryBarriers = &memory};
    vkCmdPipelineBarrier2(buffer_, &info);
}

void Commands::copy(const Buffer& source, const Buffer& target, std::size_t bytes,
                    std::size_t source_offset, std::size_t target_offset) {
    const VkBufferCopy region{source_offset, target_offset, bytes};
    vkCmdCopyBuffer(buffer_, source.get(), target.get(), 1, &region);
}

void Commands::fill(const Buffer& target, std::uint32_t word, std::size_t bytes,
                    std::size_t offset) {
    SEAWAY_CHECK(bytes % 4 == 0 && offset % 4 == 0, "words are filled");
    vkCmdFillBuffer(buffer_, target.get(), offset, bytes, word);
}

void Commands::update(const Buffer& target, std::span<const std::byte> bytes) {
    SEAWAY_CHECK(bytes.size() <= 65536 && bytes.size() % 4 == 0, "an update of this size");
    vkCmdUpdateBuffer(buffer_, target.get(), 0, bytes.size(), bytes.data());
}

void Commands::dispatch(const Kernel& kernel, const Bindings& bindings,
                        std::span<const std::byte> push, std::uint32_t groups_x,
                        std::uint32_t groups_y, std::uint32_t groups_z) {
    SEAWAY_CHECK(push.size() == kernel.push_constant_bytes(), "push constants of another kernel");
    SEAWAY_CHECK(groups_x <= groups_max_[0] && groups_y <= groups_max_[1] &&
                     groups_z <= groups_max_[2],
                 "more groups than the device takes at once");
    vkCmdBindPipeline(buffer_, VK_PIPELINE_BIND_POINT_COMPUTE, kernel.get());
    const VkDescriptorSet set = bindings.get();
    vkCmdBindDescriptorSets(buffer_, VK_PIPELINE_BIND_POINT_COMPUTE, kernel.layout(), 0, 1, &set, 0,
                            nullptr);
    if (!push.empty())
        vkCmdPushConstants(buffer_, kernel.layout(), VK_SHADER_STAGE_COMPUTE_BIT, 0,
                           static_cast<std::uint32_t>(push.size()), push.data());
    vkCmdDispatch(buffer_, groups_x, groups_y, groups_z);
}

FlatGroups flat_groups(std::size_t invocations, int group) {
    const auto side = static_cast<std::size_t>(group);
    const std::size_t groups = std::max<std::size_t>((invocations + side - 1) / side, 1);
    const std::size_t rows = (groups + FlatGroups::row_max - 1) / FlatGroups::row_max;
    return {static_cast<std::uint32_t>((groups + rows - 1) / rows),
            static_cast<std::uint32_t>(rows)};
}

void Commands::dispatch_all(const Kernel& kernel, const Bindings& bindings,
                            std::span<const std::byte> push, std::size_t invocations, int group,
                            std::uint32_t layers) {
    const FlatGroups groups = flat_groups(invocations, group);
    dispatch(kernel, bindings, push, groups.a_row, groups.rows, layers);
}

Result<void> run_once(Device& device, const std::function<void(Commands&)>& record) {
    Result<Commands> commands = Commands::create(device);
    if (!commands)
        return commands.error();
    SEAWAY_TRY(commands->begin());
    record(*commands);
    SEAWAY_TRY(commands->end());
    return device.submit_and_wait(*commands);
}

} // namespace seaway::gpu
