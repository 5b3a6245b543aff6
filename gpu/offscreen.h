// SPDX-License-Identifier: Apache-2.0
// Offscreen: a picture to draw to without a window: linear colour in 32-bit floats, multisampled
// where the device can, reversed depth, and the way back to the CPU.
//
//     target.begin(commands);  ... draw ...  target.end(commands);
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
    static constexpr VkFormat colour_format = VK_FORMAT_R32G32B32A32_SFLOAT;
    static constexpr VkFormat depth_format = VK_FORMAT_D32_SFLOAT;

    Offscreen() = default;
    /// samples_wanted: 1, 2, 4 or 8 a pixel; samples() says what was granted.
    static Result<Offscreen> create(Device& device, std::uint32_t width, std::uint32_t height,
                                    int samples_wanted);

    /// Clears to zero (colour) and infinitely far (depth 0); viewport and scissor are the picture.
    void begin(Commands& commands);
    /// Resolves the samples and copies to where pixels() reads.
    void end(Commands& commands);

    /// [y][x][rgba], row 0 on top; of the last recording that has finished.
    std::span<const float> pixels() const { return readback_.mapped_as<const float>(); }

    std::uint32_t width() const { return resolved_.spec().width; }
    std::uint32_t height() const { return resolved_.spec().height; }
    VkSampleCountFlagBits samples() const { return depth_.spec().samples; }

  private:
    Image resolved_;
    Image multisampled_; // empty with one sample
    Image depth_;
    Buffer readback_;
};

} // namespace seaway::gpu
