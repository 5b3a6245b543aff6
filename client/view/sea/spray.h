// SPDX-License-Identifier: Apache-2.0
// Spray: what a gale tears off breaking crests, as some thousand soft streaks that are blown along the wind.
//
// A function of the sea's time and of the maps of this moment, without a memory: the same picture for the same time. Each
// cell of a grid that is fixed in the world throws one plume a period from each of its slots, at a place and in a
// moment that their numbers say, and where the crest that it rides on is about to break: where the Jacobian at the place
// that the crest has come to, at the speed of the dominant waves, is low. Plumes are held up by their throw, fall, and are
// carried from the speed of the crest to that of the wind.
//
// From Beaufort 8 on, by whitecaps: in less wind, and where the quality has none, no pass is recorded. One at a time,
// as the Renderer that it serves.
#pragma once

#include <array>

#include "client/view/camera.h"
#include "client/view/sea/device_sea.h"
#include "client/view/sea/sea_frame.h"
#include "gpu/draw/graphics_pipeline.h"
#include "gpu/draw/offscreen.h"

namespace seaway::client {

/// Share of the sea that whitecaps cover at 17.2 m/s, Beaufort 8 (Callaghan 2008; docs/foam.md).
inline constexpr double spray_from_cover = 0.034;

/// What shaders/view/spray.comp is told.
struct SprayValues {
    std::int32_t base[2]; ///< of the first cell, in the world, modulo 2^16
    float origin_m[2];    ///< of its corner, local
    std::int32_t period;  ///< whole ones since the sea's time 0, modulo 2^16
    float moment;         ///< of this one, 0 .. 1
    std::int32_t slots;   ///< a cell; 0: no spray
    float wind_mps, crest_mps;
    float strength; ///< 0 .. 1
};
static_assert(sizeof(SprayValues) == 40);
SprayValues spray_values(const SeaFrame& frame, const Camera& camera, int slots);

class Spray {
  public:
    static constexpr int cells = 48; ///< a side of the grid
    static constexpr double cell_m = 6;
    static constexpr double period_s = 1.6;

    Spray() = default;
    /// Makes pipelines when there is spray for the first time. flight: 0 or 1, of the renderer's.
    Result<void> prepare(gpu::Device& device, const SprayValues& values, std::size_t flight,
                         const gpu::Buffer& view, const DeviceSea& sea,
                         const gpu::Offscreen& target, VkSampler sampler);
    /// After the light's pass; nothing without spray.
    void record(gpu::Commands& commands, gpu::Offscreen& target, std::size_t flight);
    /// Passes that were recorded.
    std::uint64_t passes() const { return passes_; }

  private:
    Result<void> create(gpu::Device& device, const gpu::Offscreen& target, int slots);

    SprayValues values_{};
    gpu::Kernel throw_;
    gpu::GraphicsPipeline draw_;
    gpu::Buffer plumes_;
    gpu::TexelView plume_texels_;
    std::array<gpu::Bindings, 2> thrown_, drawn_;
    std::uint64_t passes_ = 0;
};

} // namespace seaway::client
