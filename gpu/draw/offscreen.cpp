// SPDX-License-Identifier: Apache-2.0
#include "gpu/draw/offscreen.h"

#include "base/check.h"
#include "gpu/keep.h"

namespace seaway::gpu {

namespace {

constexpr VkImageLayout to_colour = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
constexpr VkImageLayout to_depth = VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL;
constexpr VkImageLayout to_sample = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
constexpr VkImageLayout to_copy = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;

VkRenderingAttachmentInfo attachment(const Image& image, VkImageLayout layout) {
    return {.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
            .imageView = image.view(),
            .imageLayout = layout,
            .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
            .storeOp = VK_ATTACHMENT_STORE_OP_STORE};
}

} // namespace

Result<Offscreen> Offscreen::create(Device& device, const OffscreenSize& size) {
    Offscreen made;
    made.size_ = size;
    constexpr VkImageUsageFlags drawn =
        VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;
    const auto image = [&](Image& target, const char* name, ImageSpec spec) {
        return keep(target, Image::create(device, name, spec));
    };
    SEAWAY_TRY(image(made.geometry_, "geometry",
                     {.width = size.width,
                      .height = size.height,
                      .format = format,
                      .usage = drawn,
                      .samples = size.samples,
                      .filtered = false}));
    SEAWAY_TRY(image(made.depth_, "depth",
                     {.width = size.width,
                      .height = size.height,
                      .format = depth_format,
                      .usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT,
                      .samples = size.samples}));
    SEAWAY_TRY(image(
        made.picture_, "picture",
        {.width = size.width,
         .height = size.height,
         .format = format,
         .usage = drawn | VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT}));
    SEAWAY_TRY(image(made.shown_, "shown picture",
                     {.width = size.shown_width,
                      .height = size.shown_height,
                      .format = shown_format,
                      .usage = drawn | VK_IMAGE_USAGE_TRANSFER_SRC_BIT}));
    SEAWAY_TRY(
        keep(made.pixels_, Buffer::create(device, "picture read back",
                                          std::size_t{size.width} * size.height * 4 * sizeof(float),
                                          BufferKind::readback)));
    SEAWAY_TRY(
        keep(made.bytes_, Buffer::create(device, "shown picture read back",
                                         std::size_t{size.shown_width} * size.shown_height * 4,
                                         BufferKind::readback)));
    return made;
}

void Offscreen::begin(Commands& commands, const Image& image,
                      const VkRenderingAttachmentInfo* depth, bool over) {
    record_transition(commands, image, over ? to_sample : VK_IMAGE_LAYOUT_UNDEFINED, to_colour);
    VkRenderingAttachmentInfo colour = attachment(image, to_colour);
    if (over)
        colour.loadOp = VK_ATTACHMENT_LOAD_OP_LOAD;
    const VkRect2D area{{0, 0}, {image.spec().width, image.spec().height}};
    const VkRenderingInfo info{.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                               .renderArea = area,
                               .layerCount = 1,
                               .colorAttachmentCount = 1,
                               .pColorAttachments = &colour,
                               .pDepthAttachment = depth};
    vkCmdBeginRendering(commands.get(), &info);
    const VkViewport viewport{
        0, 0, static_cast<float>(area.extent.width), static_cast<float>(area.extent.height), 0, 1};
    vkCmdSetViewport(commands.get(), 0, 1, &viewport);
    vkCmdSetScissor(commands.get(), 0, 1, &area);
}

void Offscreen::begin_geometry(Commands& commands) {
    record_transition(commands, depth_, VK_IMAGE_LAYOUT_UNDEFINED, to_depth);
    VkRenderingAttachmentInfo depth = attachment(depth_, to_depth);
    if (size_.samples != VK_SAMPLE_COUNT_1_BIT) // else begin_picture() may ask for it
        depth.storeOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
    begin(commands, geometry_, &depth);
}

void Offscreen::end_geometry(Commands& commands) {
    vkCmdEndRendering(commands.get());
    record_transition(commands, geometry_, to_colour, to_sample);
}

void Offscreen::begin_picture(Commands& commands, bool by_depth) {
    if (!by_depth) {
        begin(commands, picture_, nullptr);
        return;
    }
    SEAWAY_CHECK(size_.samples == VK_SAMPLE_COUNT_1_BIT, "the picture has one sample");
    record_transition(commands, depth_, to_depth, to_depth); // it is written before
    VkRenderingAttachmentInfo depth = attachment(depth_, to_depth);
    depth.loadOp = VK_ATTACHMENT_LOAD_OP_LOAD;
    begin(commands, picture_, &depth);
}

void Offscreen::begin_over_picture(Commands& commands) {
    begin(commands, picture_, nullptr, true);
}

void Offscreen::end_picture(Commands& commands) {
    vkCmdEndRendering(commands.get());
    record_transition(commands, picture_, to_colour, to_sample);
}

void Offscreen::begin_shown(Commands& commands) {
    begin(commands, shown_, nullptr);
}

void Offscreen::end_shown(Commands& commands) {
    vkCmdEndRendering(commands.get());
    record_transition(commands, shown_, to_colour, to_sample);
}

void Offscreen::read(Commands& commands, const Image& image, const Buffer& into) {
    record_transition(commands, image, to_sample, to_copy);
    const VkBufferImageCopy region{.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
                                   .imageExtent = {image.spec().width, image.spec().height, 1}};
    vkCmdCopyImageToBuffer(commands.get(), image.get(), to_copy, into.get(), 1, &region);
    commands.barrier(Stage::copy, Stage::host);
}

void Offscreen::read_picture(Commands& commands) {
    read(commands, picture_, pixels_);
}

void Offscreen::read_shown(Commands& commands) {
    read(commands, shown_, bytes_);
}

} // namespace seaway::gpu
