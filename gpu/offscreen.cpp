// SPDX-License-Identifier: Apache-2.0
#include "gpu/offscreen.h"

namespace seaway::gpu {

namespace {

VkSampleCountFlags sample_counts(Device& device, VkFormat format, VkImageUsageFlags usage) {
    VkImageFormatProperties limits{};
    const VkResult known = vkGetPhysicalDeviceImageFormatProperties(
        device.physical(), format, VK_IMAGE_TYPE_2D, VK_IMAGE_TILING_OPTIMAL, usage, 0, &limits);
    return known == VK_SUCCESS ? limits.sampleCounts : 0;
}

VkSampleCountFlagBits granted_samples(Device& device, int wanted) {
    const VkSampleCountFlags counts =
        sample_counts(device, Offscreen::colour_format, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT) &
        sample_counts(device, Offscreen::depth_format, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT);
    for (int samples = wanted; samples > 1; samples /= 2)
        if (counts & static_cast<VkSampleCountFlags>(samples))
            return static_cast<VkSampleCountFlagBits>(samples);
    return VK_SAMPLE_COUNT_1_BIT;
}

} // namespace

Result<Offscreen> Offscreen::create(Device& device, std::uint32_t width, std::uint32_t height,
                                    int samples_wanted) {
    const VkSampleCountFlagBits samples = granted_samples(device, samples_wanted);
    Offscreen made;
    const ImageSpec colour{.width = width,
                           .height = height,
                           .format = colour_format,
                           .usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT |
                                    VK_IMAGE_USAGE_TRANSFER_SRC_BIT};
    Result<Image> resolved = Image::create(device, "picture", colour);
    if (!resolved)
        return resolved.error();
    made.resolved_ = std::move(*resolved);
    if (samples != VK_SAMPLE_COUNT_1_BIT) {
        ImageSpec spec = colour;
        spec.samples = samples;
        spec.usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
        Result<Image> multisampled = Image::create(device, "multisampled picture", spec);
        if (!multisampled)
            return multisampled.error();
        made.multisampled_ = std::move(*multisampled);
    }
    Result<Image> depth = Image::create(device, "depth",
                                        {.width = width,
                                         .height = height,
                                         .format = depth_format,
                                         .usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT,
                                         .samples = samples});
    if (!depth)
        return depth.error();
    made.depth_ = std::move(*depth);
    Result<Buffer> readback =
        Buffer::create(device, "picture read back", std::size_t{width} * height * 4 * sizeof(float),
                       BufferKind::readback);
    if (!readback)
        return readback.error();
    made.readback_ = std::move(*readback);
    return made;
}

void Offscreen::begin(Commands& commands) {
    const bool multisampling = samples() != VK_SAMPLE_COUNT_1_BIT;
    record_transition(commands, resolved_, VK_IMAGE_LAYOUT_UNDEFINED,
                      VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    if (multisampling)
        record_transition(commands, multisampled_, VK_IMAGE_LAYOUT_UNDEFINED,
                          VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    record_transition(commands, depth_, VK_IMAGE_LAYOUT_UNDEFINED,
                      VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL);
    const VkRenderingAttachmentInfo colour{
        .sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
        .imageView = multisampling ? multisampled_.view() : resolved_.view(),
        .imageLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
        .resolveMode = multisampling ? VK_RESOLVE_MODE_AVERAGE_BIT : VK_RESOLVE_MODE_NONE,
        .resolveImageView = multisampling ? resolved_.view() : VkImageView(VK_NULL_HANDLE),
        .resolveImageLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
        .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
        .storeOp = multisampling ? VK_ATTACHMENT_STORE_OP_DONT_CARE : VK_ATTACHMENT_STORE_OP_STORE};
    const VkRenderingAttachmentInfo depth{.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                          .imageView = depth_.view(),
                                          .imageLayout = VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL,
                                          .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
                                          .storeOp = VK_ATTACHMENT_STORE_OP_DONT_CARE};
    const VkRect2D area{{0, 0}, {width(), height()}};
    const VkRenderingInfo info{.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                               .renderArea = area,
                               .layerCount = 1,
                               .colorAttachmentCount = 1,
                               .pColorAttachments = &colour,
                               .pDepthAttachment = &depth};
    vkCmdBeginRendering(commands.get(), &info);
    const VkViewport viewport{0, 0, static_cast<float>(width()), static_cast<float>(height()),
                              0, 1};
    vkCmdSetViewport(commands.get(), 0, 1, &viewport);
    vkCmdSetScissor(commands.get(), 0, 1, &area);
}

void Offscreen::end(Commands& commands) {
    vkCmdEndRendering(commands.get());
    record_transition(commands, resolved_, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                      VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    const VkBufferImageCopy region{.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
                                   .imageExtent = {width(), height(), 1}};
    vkCmdCopyImageToBuffer(commands.get(), resolved_.get(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                           readback_.get(), 1, &region);
    commands.barrier(Stage::copy, Stage::host);
}

} // namespace seaway::gpu
