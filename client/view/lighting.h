// SPDX-License-Identifier: Apache-2.0
// Lighting: the pipelines that light a picture of sea and sky, each made when it is first needed.
//
// With one sample a pixel is sea or sky, and each has a pipeline of its own: a device without a GPU takes both sides of a
// branch. With four the sea's pipeline draws the sky between crests, too. Clouds, discs and stars are in those alone
// that are called for where a picture shows them.
//
// One at a time, as the Renderer that it serves.
#pragma once

#include <array>
#include <span>

#include "client/view/camera.h"
#include "gpu/draw/graphics_pipeline.h"
#include "gpu/draw/offscreen.h"
#include "shaders/shared/view.h"

namespace seaway::client {

/// What of a sky a picture may show.
enum class SkySeen {
    plain,  ///< the light of the air alone
    discs,  ///< sun, moon or stars, too
    clouds, ///< all
};
SkySeen sky_seen(const shaders::SkyValues& sky, const Camera& camera);

class Lighting {
  public:
    Lighting() = default;
    /// bindings: of every pipeline; must outlive it.
    Lighting(gpu::Device& device, VkSampleCountFlagBits samples,
             std::span<const gpu::ExpectedBinding> bindings)
        : device_(&device), samples_(samples), bindings_(bindings) {}

    struct Needs {
        bool sea = true;
        SkySeen sky = SkySeen::clouds;
        bool under =
            false; ///< the eye is under water: geometry is drawn, be there sea in it or not
    };
    /// Makes what record() needs. An error names the pipeline.
    Result<void> prepare(const Needs& needs);
    /// The picture pass. Without sea the geometry need not be drawn.
    void record(gpu::Commands& commands, gpu::Offscreen& target, const gpu::Bindings& bindings,
                const Needs& needs) const;

  private:
    bool one_sample() const { return samples_ == VK_SAMPLE_COUNT_1_BIT; }
    Result<void> make(gpu::GraphicsPipeline& target, const char* name,
                      std::span<const std::uint32_t> fragment, bool depth, gpu::DepthTest test);

    gpu::Device* device_ = nullptr;
    VkSampleCountFlagBits samples_ = VK_SAMPLE_COUNT_1_BIT;
    std::span<const gpu::ExpectedBinding> bindings_;
    using Kinds = std::array<gpu::GraphicsPipeline, 3>; ///< by SkySeen
    gpu::GraphicsPipeline under_;
    Kinds sky_, sky_around_, sea_; ///< the sea's: as for plain, or with clouds
};

} // namespace seaway::client
