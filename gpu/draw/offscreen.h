// SPDX-License-Identifier: Apache-2.0
// Offscreen: pictures without a window, drawn in two passes. The first draws geometry,
// multisampled, and keeps numbers of what is nearest (four floats a sample); the second turns them
// into a picture in linear 32-bit floats, one fragment a pixel, which is read back.
//
//     target.begin_geometry(commands);  ... draw ...  target.end_geometry(commands);
//     target.begin_picture(commands);   ... draw, sampling geometry() ...
//     target.end_picture(commands);
//     device.submit_and_wait(commands);
//     use(target.pixels());
//
// Not thread-safe.
#pragma once

#include <span>

#include "base/result.h"
#include "gpu/buffer.h"
#include "gpu/commands.h"
#include "gpu/image.h"

namespace seaway::gpu {

class Offscreen {
  public:
    static constexpr VkFormat format = VK_FORMAT_R32G32B32A32_SFLOAT; ///< of both passes
    static constexpr VkFormat depth_format = VK_FORMAT_D32_SFLOAT;
    static constexpr VkSampleCountFlagBits samples = VK_SAMPLE_COUNT_4_BIT; ///< of the geometry

    Offscreen() = default;
    static Result<Offscreen> create(Device& device, std::uint32_t width, std::uint32_t height);

    /// Clears the numbers to zero and depth to infinitely far (0, reversed).
    void begin_geometry(Commands& commands);
    void end_geometry(Commands& commands);
    /// What the picture pass samples, as sampler2DMS.
    const Image& geometry() const { return geometry_; }

    void begin_picture(Commands& commands);
    void end_picture(Commands& commands);

    /// [y][x][rgba], row 0 on top; of the last recording that has finished.
    std::span<const float> pixels() const { return readback_.mapped_as<const float>(); }

    std::uint32_t width() const { return picture_.spec().width; }
    std::uint32_t height() const { return picture_.spec().height; }

  private:
    void begin(Commands& commands, const VkRenderingAttachmentInfo& colour,
               const VkRenderingAttachmentInfo* depth);

    Image geometry_;
    Image depth_;
    Image picture_;
    Buffer readback_;
};

} // namespace seaway::gpu
