// SPDX-License-Identifier: Apache-2.0
#include "gpu/draw/offscreen.h"

namespace seaway::gpu {

namespace {

VkRenderingAttachmentInfo attachment(const Image& image, VkImageLayout layout) {
    return {.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
            .imageView = image.view(),
            .imageLayout = layout,
            .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
            .storeOp = VK_ATTACHMENT_STORE_OP_STORE};
}

} // namespace

Result<Offscreen> Offscreen::create(Device& device, std::uint32_t width, std::uint32_t height) {
    struct Wish {
        Image Offscreen::*image;
        const char* name;
        ImageSpec spec;
    };
    const Wish wishes[] = {
        {&Offscreen::geometry_,
         "geometry",
         {.format = format,
          .usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT,
          .samples = samples,
          .filtered = false}},
        {&Offscreen::depth_,
         "depth",
         {.format = depth_format,
          .usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT,
          .samples = samples}},
        {&Offscreen::picture_,
         "picture",
         {.format = format,
          .usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT}}};
    Offscreen made;
    for (const Wish& wish : wishes) {
        ImageSpec spec = wish.spec;
        spec.width = width;
        spec.height = height;
        Result<Image> image = Image::create(device, wish.name, spec);
        if (!image)
            return image.error();
        made.*wish.image = std::move(*image);
    }
    Result<Buffer> readback =
        Buffer::create(device, "picture read back", std::size_t{width} * height * 4 * sizeof(float),
                       BufferKind::readback);
    if (!readback)
        return readback.error();
    made.readback_ = std::move(*readback);
    return made;
}

void Offscreen::begin(Commands& commands, const VkRenderingAttachmentInfo& colour,
                      const VkRenderingAttachmentInfo* depth) {
    const VkRect2D area{{0, 0}, {width(), height()}};
    const VkRenderingInfo info{.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                               .renderArea = area,
                               .layerCount = 1,
                               .colorAttachmentCount = 1,
                               .pColorAttachments = &colour,
                               .pDepthAttachment = depth};
    vkCmdBeginRendering(commands.get(), &info);
    const VkViewport viewport{0, 0, static_cast<float>(width()), static_cast<float>(height()),
                              0, 1};
    vkCmdSetViewport(commands.get(), 0, 1, &viewport);
    vkCmdSetScissor(commands.get(), 0, 1, &area);
}

void Offscreen::begin_geometry(Commands& commands) {
    constexpr VkImageLayout to_colour = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
    constexpr VkImageLayout to_depth = VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL;
    record_transition(commands, geometry_, VK_IMAGE_LAYOUT_UNDEFINED, to_colour);
    record_transition(commands, depth_, VK_IMAGE_LAYOUT_UNDEFINED, to_depth);
    VkRenderingAttachmentInfo depth = attachment(depth_, to_depth);
    depth.storeOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
    begin(commands, attachment(geometry_, to_colour), &depth);
}

void Offscreen::end_geometry(Commands& commands) {
    vkCmdEndRendering(commands.get());
    record_transition(commands, geometry_, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                      VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
}

void Offscreen::begin_picture(Commands& commands) {
    constexpr VkImageLayout to_colour = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
    record_transition(commands, picture_, VK_IMAGE_LAYOUT_UNDEFINED, to_colour);
    begin(commands, attachment(picture_, to_colour), nullptr);
}

void Offscreen::end_picture(Commands& commands) {
    vkCmdEndRendering(commands.get());
    record_transition(commands, picture_, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                      VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    const VkBufferImageCopy region{.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
                                   .imageExtent = {width(), height(), 1}};
    vkCmdCopyImageToBuffer(commands.get(), picture_.get(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                           readback_.get(), 1, &region);
    commands.barrier(Stage::copy, Stage::host);
}

} // namespace seaway::gpu
