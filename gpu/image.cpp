// SPDX-License-Identifier: Apache-2.0
#include "gpu/image.h"

#include <algorithm>
#include <bit>
#include <string>
#include <vector>

#include "base/check.h"
#include "gpu/call.h"

namespace seaway::gpu {

namespace {

std::uint32_t at_mip(std::uint32_t side, std::uint32_t mip) {
    return std::max(1u, side >> mip);
}

Result<void> check_support(Device& device, const ImageSpec& spec) {
    VkFormatProperties format;
    vkGetPhysicalDeviceFormatProperties(device.physical(), spec.format, &format);
    const bool sampled = (spec.usage & VK_IMAGE_USAGE_SAMPLED_BIT) != 0;
    if (sampled && spec.filtered &&
        !(format.optimalTilingFeatures & VK_FORMAT_FEATURE_SAMPLED_IMAGE_FILTER_LINEAR_BIT))
        return Error{device.info().name + " has no linear filter for this format"};
    VkImageFormatProperties limits;
    SEAWAY_TRY(call("vkGetPhysicalDeviceImageFormatProperties",
                    vkGetPhysicalDeviceImageFormatProperties, device.physical(), spec.format,
                    VK_IMAGE_TYPE_2D, VK_IMAGE_TILING_OPTIMAL, spec.usage, VkImageCreateFlags{0},
                    &limits));
    if (spec.width > limits.maxExtent.width || spec.height > limits.maxExtent.height ||
        spec.layers > limits.maxArrayLayers || spec.mips > limits.maxMipLevels)
        return Error{device.info().name + " allows " + std::to_string(limits.maxExtent.width) +
                     "x" + std::to_string(limits.maxExtent.height) + ", " +
                     std::to_string(limits.maxArrayLayers) + " layers, " +
                     std::to_string(limits.maxMipLevels) + " mips"};
    if (!(limits.sampleCounts & spec.samples))
        return Error{device.info().name + " has no " + std::to_string(spec.samples) +
                     " samples a pixel for this format"};
    return {};
}

Result<OwnedMemory> allocate(Device& device, VkImage image) {
    VkMemoryRequirements needs;
    vkGetImageMemoryRequirements(device.get(), image, &needs);
    const int type =
        device.memory_type(needs.memoryTypeBits, 0, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
    if (type < 0)
        return Error{"the device has no memory of the kind needed"};
    const VkMemoryAllocateInfo info{.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                    .allocationSize = needs.size,
                                    .memoryTypeIndex = static_cast<std::uint32_t>(type)};
    VkDeviceMemory memory = VK_NULL_HANDLE;
    SEAWAY_TRY(call("vkAllocateMemory", vkAllocateMemory, device.get(), &info, nullptr, &memory));
    return OwnedMemory(device.get(), memory);
}

Result<OwnedImageView> create_view(Device& device, VkImage image, const ImageSpec& spec,
                                   VkImageAspectFlags aspect) {
    const VkImageViewCreateInfo info{.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                     .image = image,
                                     .viewType = spec.array ? VK_IMAGE_VIEW_TYPE_2D_ARRAY
                                                            : VK_IMAGE_VIEW_TYPE_2D,
                                     .format = spec.format,
                                     .subresourceRange = {aspect, 0, spec.mips, 0, spec.layers}};
    VkImageView view = VK_NULL_HANDLE;
    SEAWAY_TRY(call("vkCreateImageView", vkCreateImageView, device.get(), &info, nullptr, &view));
    return OwnedImageView(device.get(), view);
}

} // namespace

std::uint32_t full_mip_count(std::uint32_t width, std::uint32_t height) {
    return static_cast<std::uint32_t>(std::bit_width(std::max(width, height)));
}

VkImageAspectFlags Image::aspect() const {
    return spec_.format == VK_FORMAT_D32_SFLOAT ? VK_IMAGE_ASPECT_DEPTH_BIT
                                                : VK_IMAGE_ASPECT_COLOR_BIT;
}

std::size_t Image::texel_count() const {
    std::size_t count = 0;
    for (std::uint32_t mip = 0; mip < spec_.mips; ++mip)
        count += std::size_t{at_mip(spec_.width, mip)} * at_mip(spec_.height, mip) * spec_.layers;
    return count;
}

Result<Image> Image::create(Device& device, std::string_view name, const ImageSpec& spec) {
    SEAWAY_CHECK(spec.layers == 1 || spec.array, "layers are sampled as an array");
    const auto failed = [&](const Error& error) {
        return Error{error.kind, "image \"" + std::string(name) + "\", " +
                                     std::to_string(spec.width) + "x" +
                                     std::to_string(spec.height) + ": " + error.message};
    };
    if (Result<void> supported = check_support(device, spec); !supported)
        return failed(supported.error());
    Image made;
    made.spec_ = spec;
    const VkImageCreateInfo info{.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                                 .imageType = VK_IMAGE_TYPE_2D,
                                 .format = spec.format,
                                 .extent = {spec.width, spec.height, 1},
                                 .mipLevels = spec.mips,
                                 .arrayLayers = spec.layers,
                                 .samples = spec.samples,
                                 .tiling = VK_IMAGE_TILING_OPTIMAL,
                                 .usage = spec.usage,
                                 .sharingMode = VK_SHARING_MODE_EXCLUSIVE,
                                 .initialLayout = VK_IMAGE_LAYOUT_UNDEFINED};
    VkImage image = VK_NULL_HANDLE;
    if (Result<void> created =
            call("vkCreateImage", vkCreateImage, device.get(), &info, nullptr, &image);
        !created)
        return failed(created.error());
    made.image_ = OwnedImage(device.get(), image);
    Result<OwnedMemory> memory = allocate(device, image);
    if (!memory)
        return failed(memory.error());
    made.memory_ = std::move(*memory);
    if (Result<void> bound = call("vkBindImageMemory", vkBindImageMemory, device.get(), image,
                                  made.memory_.get(), VkDeviceSize{0});
        !bound)
        return failed(bound.error());
    Result<OwnedImageView> view = create_view(device, image, spec, made.aspect());
    if (!view)
        return failed(view.error());
    made.view_ = std::move(*view);
    return made;
}

void record_transition(Commands& commands, const Image& image, VkImageLayout from,
                       VkImageLayout to) {
    record_transition(commands, image.get(),
                      {image.aspect(), 0, image.spec().mips, 0, image.spec().layers}, from, to);
}

void record_transition(Commands& commands, VkImage image, const VkImageSubresourceRange& range,
                       VkImageLayout from, VkImageLayout to) {
    const VkImageMemoryBarrier2 barrier{.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
                                        .srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                                        .srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT,
                                        .dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                                        .dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT |
                                                         VK_ACCESS_2_MEMORY_WRITE_BIT,
                                        .oldLayout = from,
                                        .newLayout = to,
                                        .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                        .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                        .image = image,
                                        .subresourceRange = range};
    const VkDependencyInfo info{.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
                                .imageMemoryBarrierCount = 1,
                                .pImageMemoryBarriers = &barrier};
    vkCmdPipelineBarrier2(commands.get(), &info);
}

void record_upload(Commands& commands, const Buffer& source, const Image& target,
                   std::size_t texel_bytes) {
    const ImageSpec& spec = target.spec();
    SEAWAY_CHECK(source.size_bytes() >= target.texel_count() * texel_bytes,
                 "the buffer is shorter than the image");
    record_transition(commands, target, VK_IMAGE_LAYOUT_UNDEFINED,
                      VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    std::vector<VkBufferImageCopy> regions;
    VkDeviceSize offset = 0;
    for (std::uint32_t mip = 0; mip < spec.mips; ++mip) {
        const std::uint32_t width = at_mip(spec.width, mip);
        const std::uint32_t height = at_mip(spec.height, mip);
        regions.push_back({.bufferOffset = offset,
                           .imageSubresource = {target.aspect(), mip, 0, spec.layers},
                           .imageExtent = {width, height, 1}});
        offset += VkDeviceSize{width} * height * spec.layers * texel_bytes;
    }
    vkCmdCopyBufferToImage(commands.get(), source.get(), target.get(),
                           VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                           static_cast<std::uint32_t>(regions.size()), regions.data());
    record_transition(commands, target, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                      VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
}

Result<OwnedSampler> create_sampler(Device& device, const SamplerSpec& spec) {
    const VkSamplerAddressMode address =
        spec.repeat ? VK_SAMPLER_ADDRESS_MODE_REPEAT : VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
    const float anisotropy = device.features().samplerAnisotropy
                                 ? std::min(spec.anisotropy, device.limits().maxSamplerAnisotropy)
                                 : 1.0f;
    const VkSamplerCreateInfo info{.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO,
                                   .magFilter = VK_FILTER_LINEAR,
                                   .minFilter = VK_FILTER_LINEAR,
                                   .mipmapMode = VK_SAMPLER_MIPMAP_MODE_LINEAR,
                                   .addressModeU = address,
                                   .addressModeV = address,
                                   .addressModeW = address,
                                   .anisotropyEnable = anisotropy > 1.0f,
                                   .maxAnisotropy = anisotropy,
                                   .maxLod = VK_LOD_CLAMP_NONE};
    VkSampler sampler = VK_NULL_HANDLE;
    SEAWAY_TRY(call("vkCreateSampler", vkCreateSampler, device.get(), &info, nullptr, &sampler));
    return OwnedSampler(device.get(), sampler);
}

} // namespace seaway::gpu
