// SPDX-License-Identifier: Apache-2.0
// Bloom: what lenses and eyes scatter of light, so that the sun and its path are brighter than white. Without a
// threshold, and no light is lost or made, but along the borders, whose pixels count for what lies beyond them: each pixel gives the same share of its light to those around it, in a spot that
// falls as about the third power of the distance.
//
//     Result<Bloom> bloom = Bloom::create(device, picture, 2, sampler);
//     bloom->record(commands);               // the picture is ready to be sampled
//     bloom->describe(pixels_a_pixel_shown, values);
//     // shaders/view/shown.frag mixes picture and texels()
//
// The picture is halved level by level by a quadratic spline, and the levels are added up from the coarsest one, each by
// a tent (dual filtering; Jimenez 2014, "Next Generation Post Processing in Call of Duty").
// Not thread-safe.
#pragma once

#include <vector>

#include "base/result.h"
#include "gpu/buffer.h"
#include "gpu/commands.h"
#include "gpu/image.h"
#include "gpu/kernel.h"
#include "shaders/shared/view.h"

namespace seaway::client {

class Bloom {
  public:
    static constexpr int levels_max = 9;

    Bloom() = default;
    /// pixels: of the picture a texel of the finest level, a side: 2, or 4, which is cheaper and coarser.
    static Result<Bloom> create(gpu::Device& device, const gpu::Image& picture, int pixels,
                                VkSampler sampler);

    /// After it texels() may be read by what is drawn.
    void record(gpu::Commands& commands) const;
    /// The finest level, [y][x]: the light around, normalised.
    const gpu::TexelView& texels() const { return finest_; }
    int columns() const { return levels_.front().columns; }
    int lines() const { return levels_.front().lines; }
    /// All levels, the finest first.
    const gpu::Buffer& buffer() const { return buffer_; }
    /// Where it lies; scale: pixels of the picture a pixel shown.
    void describe(double scale, shaders::ViewValues& values) const;

  private:
    struct Level {
        int first = 0, columns = 0, lines = 0; ///< as in shaders/view/bloom.glsl
        float share = 0;                       ///< of it that comes from the coarser ones
    };
    Result<void> create_kernels(gpu::Device& device, const gpu::Image& picture, VkSampler sampler);
    void record(gpu::Commands& commands, const gpu::Kernel& kernel, const gpu::Bindings& bindings,
                const Level& from, const Level& to) const;

    int pixels_ = 2;
    std::vector<Level> levels_; ///< finest first
    gpu::Buffer buffer_;
    gpu::TexelView texels_, finest_;
    gpu::Kernel first_, down_, up_;
    gpu::Bindings of_picture_, of_levels_, of_coarser_;
};

} // namespace seaway::client
