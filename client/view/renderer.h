// SPDX-License-Identifier: Apache-2.0
// Renderer: a moment of the sea, a camera and a sky become a picture, on any Vulkan device that can
// draw.
//
//     Result<Renderer> renderer = Renderer::create(*device, camera.width, camera.height);
//     Result<Picture> picture = renderer->render(frame, camera, sky);
//
// The same inputs give the same bytes on one device. Not thread-safe. A picture of 960 x 540 takes
// about a second and a half on two cores without a GPU.
#pragma once

#include "base/result.h"
#include "client/view/camera.h"
#include "client/view/debug_views.h"
#include "client/view/mesh.h"
#include "client/view/picture.h"
#include "client/view/sea_maps.h"
#include "client/view/sky.h"
#include "gpu/draw/graphics_pipeline.h"
#include "gpu/draw/offscreen.h"
#include "shaders/shared/view.h"

namespace seaway::client {

struct RenderOptions {
    double cell_pixels = 2.5;   ///< size of the mesh's cells
    double visibility_m = 40e3; ///< distance at which 2 % of contrast is left (Koschmieder)
    bool detail = true;         ///< continue the waves beyond the finest cascade
};

class Renderer {
  public:
    static Result<Renderer> create(gpu::Device& device, int width, int height,
                                   const RenderOptions& options = {});

    /// An error means that the device failed or lacks something. frame: 1 ..
    /// shaders::view_cascades_max cascades; camera of the renderer's width and height.
    Result<Picture> render(const SeaFrame& frame, const Camera& camera, const Sky& sky,
                           const DebugChoice& debug = {});

    /// The sea in the last frame that was rendered.
    const SeaStatistics& statistics() const { return statistics_; }

  private:
    struct Upload {
        gpu::Buffer staging;
        gpu::Image image;
    };
    Renderer(gpu::Device& device, const RenderOptions& options)
        : device_(&device), options_(options) {}

    Result<void> create_pipelines();
    Result<void> create_mesh_buffers();
    Result<void> create_images(int nodes, int cascades);
    Result<Upload> create_upload(std::string_view name, const gpu::ImageSpec& spec);
    Result<void> bind();
    void fill_mesh(const Mesh& mesh);
    Result<void> record(const Mesh& mesh, DebugView view);

    gpu::Device* device_;
    RenderOptions options_;
    gpu::Offscreen target_;
    gpu::GraphicsPipeline sea_, final_, debug_;
    gpu::OwnedSampler sea_sampler_, sky_sampler_;
    gpu::Buffer values_, rows_, indices_;
    Upload displacement_, gradient_, moment_, sky_map_;
    gpu::Bindings bindings_;
    gpu::Commands commands_;
    int columns_ = 0; ///< that the indices are of
    SeaStatistics statistics_;
};

/// What the shaders are told of a frame; separate so that it can be read and tested by itself.
shaders::ViewValues view_values(const SeaFrame& frame, const SeaMaps& maps, const Camera& camera,
                                const Sky& sky, const Mesh& mesh, const RenderOptions& options,
                                const DebugChoice& debug);

} // namespace seaway::client
