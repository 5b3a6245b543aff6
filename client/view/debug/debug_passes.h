// SPDX-License-Identifier: Apache-2.0
// DebugPasses: the pipelines of the views of numbers, made when the first of them is looked at: who looks at the sea
// alone pays nothing. Not thread-safe.
#pragma once

#include "base/result.h"
#include "client/view/debug_views.h"
#include "gpu/draw/graphics_pipeline.h"

namespace seaway::client {

class DebugPasses {
  public:
    /// `one`: the geometry has one sample a pixel. `shown_format`: of what numbers are shown in.
    static Result<DebugPasses> create(gpu::Device& device, bool one, VkFormat shown_format);

    /// Resources in the order of shaders/view/bindings.glsl, then the displacements' texels.
    Result<gpu::Bindings> bind(gpu::Device& device,
                               std::span<const gpu::Resource> resources) const {
        return sea_.bind(device, resources);
    }
    /// Numbers of a view of the sea or of a map, between begin_picture() and end_picture().
    void record(gpu::Commands& commands, const gpu::Bindings& bound, DebugView view) const;
    /// Their colours, between begin_shown() and end_shown(); `bound` as of the film pass.
    void record_colours(gpu::Commands& commands, const gpu::Bindings& bound) const;

  private:
    gpu::GraphicsPipeline sea_, map_, colours_;
};

} // namespace seaway::client
