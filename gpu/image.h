// SPDX-License-Identifier: Apache-2.0
// Image: 2-D texels (with layers and mip levels) that shaders sample or that are drawn to, and
// samplers for it. One allocation an image: make few, keep them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "base/result.h"
#include "gpu/buffer.h"
#include "gpu/commands.h"
#include "gpu/device.h"

namespace seaway::gpu {

struct ImageSpec {
    std::uint32_t width = 1;
    std::uint32_t height = 1;
    std::uint32_t layers = 1;
    std::uint32_t mips = 1;
    VkFormat format = VK_FORMAT_R32G32B32A32_SFLOAT;
    VkImageUsageFlags usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
    VkSampleCountFlagBits samples = VK_SAMPLE_COUNT_1_BIT;
    bool array = false;   ///< sampled as an array even with one layer
    bool filtered = true; ///< linear filtering is needed: refused where the format has none
};

/// Mip levels of a full chain down to one texel.
std::uint32_t full_mip_count(std::uint32_t width, std::uint32_t height);

class Image {
  public:
    Image() = default;
    /// `name` is for messages. An error says which format or size the device lacks. Contents are
    /// undefined.
    static Result<Image> create(Device& device, std::string_view name, const ImageSpec& spec);

    VkImage get() const { return image_.get(); }
    VkImageView view() const { return view_.get(); }
    const ImageSpec& spec() const { return spec_; }
    VkImageAspectFlags aspect() const;

    /// Texels of all layers and mips, tightly packed: mip 0 of every layer, then mip 1, ...
    std::size_t texel_count() const;

  private:
    // View, image, memory go in this order: members are destroyed backwards.
    OwnedMemory memory_;
    OwnedImage image_;
    OwnedImageView view_;
    ImageSpec spec_;
};

/// Copies texels in the order of texel_count() from the start of `source` and leaves the image
/// ready for sampling in any shader. What it held before is lost.
void record_upload(Commands& commands, const Buffer& source, const Image& target,
                   std::size_t texel_bytes);

/// A layout transition that waits for everything before and blocks everything after it.
void record_transition(Commands& commands, const Image& image, VkImageLayout from,
                       VkImageLayout to);
/// The same of an image that is not ours: a swapchain's.
void record_transition(Commands& commands, VkImage image, const VkImageSubresourceRange& range,
                       VkImageLayout from, VkImageLayout to);

struct SamplerSpec {
    bool repeat = false;  ///< else the edge is continued
    float anisotropy = 1; ///< 1: none; lowered to what the device grants
};

/// Linear in space and between mips.
Result<OwnedSampler> create_sampler(Device& device, const SamplerSpec& spec);

} // namespace seaway::gpu
