// SPDX-License-Identifier: Apache-2.0
// Offscreen: pictures without a window, drawn in three passes. The first draws geometry and keeps numbers of what is
// nearest (four floats a sample); the second turns them into a picture in linear 32-bit floats, one fragment a pixel;
// the third, for who wants to look at it, into bytes, at another size if need be.
//
//     target.begin_geometry(commands);  ... draw ...  target.end_geometry(commands);
//     target.begin_picture(commands);   ... draw, sampling geometry() ...  target.end_picture(commands);
//     target.begin_shown(commands);     ... draw, sampling picture() ...   target.end_shown(commands);
//     target.read_picture(commands);    // or read_shown()
//     device.submit_and_wait(commands);
//     use(target.pixels());
//
// Not thread-safe.
#pragma once

#include <cstdint>
#include <span>

#include "base/result.h"
#include "gpu/buffer.h"
#include "gpu/commands.h"
#include "gpu/image.h"

namespace seaway::gpu {

struct OffscreenSize {
    std::uint32_t width = 0, height = 0;                   ///< of geometry and picture
    std::uint32_t shown_width = 0, shown_height = 0;       ///< of the bytes
    VkSampleCountFlagBits samples = VK_SAMPLE_COUNT_4_BIT; ///< of the geometry
};

class Offscreen {
  public:
    static constexpr VkFormat format = VK_FORMAT_R32G32B32A32_SFLOAT; ///< of geometry and picture
    static constexpr VkFormat depth_format = VK_FORMAT_D32_SFLOAT;
    static constexpr VkFormat shown_format = VK_FORMAT_R8G8B8A8_UNORM;

    Offscreen() = default;
    static Result<Offscreen> create(Device& device, const OffscreenSize& size);

    /// Clears the numbers to zero and depth to infinitely far (0, reversed).
    void begin_geometry(Commands& commands);
    void end_geometry(Commands& commands);
    /// What the picture pass samples: as sampler2DMS, or sampler2D if it has one sample.
    const Image& geometry() const { return geometry_; }

    /// `by_depth`: pipelines may ask whether the geometry has drawn a pixel (GraphicsOptions::test), where that has one
    /// sample.
    void begin_picture(Commands& commands, bool by_depth = false);
    void end_picture(Commands& commands);
    /// More is laid over a picture that has ended; end_picture() ends that, too.
    void begin_over_picture(Commands& commands);
    const Image& picture() const { return picture_; }

    void begin_shown(Commands& commands);
    void end_shown(Commands& commands);
    const Image& shown() const { return shown_; }

    /// Copies to where the CPU sees it: what costs nothing where nobody asks. After end_picture() and end_shown().
    void read_picture(Commands& commands);
    void read_shown(Commands& commands);
    /// [y][x][rgba], row 0 on top; of the last recording that has finished.
    std::span<const float> pixels() const { return pixels_.mapped_as<const float>(); }
    std::span<const std::uint8_t> bytes() const { return bytes_.mapped_as<const std::uint8_t>(); }

    const OffscreenSize& size() const { return size_; }

  private:
    void begin(Commands& commands, const Image& image, const VkRenderingAttachmentInfo* depth,
               bool over = false);
    void read(Commands& commands, const Image& image, const Buffer& into);

    OffscreenSize size_;
    Image geometry_, depth_, picture_, shown_;
    Buffer pixels_, bytes_;
};

} // namespace seaway::gpu
