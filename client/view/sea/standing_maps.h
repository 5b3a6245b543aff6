// SPDX-License-Identifier: Apache-2.0
// StandingMaps: the way from keyframes that stand on the device, as whoever computed them left them, to level 0 of the
// maps that are drawn. Nothing is copied and the CPU sees none of it: values are mixed in time, then made coefficients of
// splines along both axes.
//
// Not thread-safe; what a DeviceSea has for such seas.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "base/result.h"
#include "client/view/sea/sea_frame.h"
#include "gpu/buffer.h"
#include "gpu/commands.h"
#include "gpu/kernel.h"
#include "shaders/shared/view.h"

namespace seaway::client {

inline constexpr std::size_t texel_bytes = 4 * sizeof(float); ///< of all that views sample
inline constexpr std::array<std::uint32_t, 3> view_groups{shaders::view_group, 1, 1};

class StandingMaps {
  public:
    StandingMaps() = default;
    static Result<StandingMaps> create(gpu::Device& device);

    /// For other buffers of displacements, of so many bytes: all that was bound is forgotten.
    Result<void> fit(std::size_t displacement_bytes);
    /// The keyframes of this frame are what record() reads; they, and those of the frame before, which may be under way,
    /// stay where they are.
    Result<void> take(const SeaFrame& frame, const gpu::Buffer& values,
                      const gpu::Buffer& displacements, const gpu::TexelView& displacement_texels);
    void record(gpu::Commands& commands, const gpu::Buffer& values);

  private:
    struct Splines {
        gpu::Bindings along_x, along_y;
    };
    using Keyframes = std::vector<StandingKeyframePtr>;

    gpu::Device* device_ = nullptr;
    Keyframes taken_, taken_before_; ///< two a cascade
    gpu::Kernel planes_, splines_;
    gpu::Buffer half_way_; ///< coefficients along x, samples along y
    gpu::TexelView half_way_texels_;
    std::map<std::pair<VkBuffer, VkBufferView>, gpu::Bindings> planes_sets_; ///< values, maps
    std::map<VkBuffer, Splines> splines_sets_;                               ///< by values
};

} // namespace seaway::client
