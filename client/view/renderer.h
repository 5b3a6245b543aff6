// SPDX-License-Identifier: Apache-2.0
// Renderer: a moment of the sea, a camera and a sky become a picture, on any Vulkan device that can
// draw.
//
//     Result<Renderer> renderer = Renderer::create(*device, camera.width, camera.height);
//     Result<Picture> picture = renderer->render(frame, camera, sky);   // linear numbers
//     Result<ShownPicture> shown = renderer->show(frame, camera, sky, debug, display);  // bytes
//
// Passes: keyframes to maps (client/view/sea/device_sea.h), mesh, geometry, light, and for bytes bloom and the film curve.
// Two frames may be under way: draw() returns while the device works. The same inputs give the same bytes on one
// device. Not thread-safe. Cost by quality: docs/performance/drawing.md.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "client/view/bloom.h"
#include "client/view/camera.h"
#include "client/view/debug/debug_passes.h"
#include "client/view/debug_views.h"
#include "client/view/lighting.h"
#include "client/view/picture.h"
#include "client/view/quality.h"
#include "client/view/sea/device_sea.h"
#include "client/view/sea/eye_side.h"
#include "client/view/sea/mesh.h"
#include "client/view/sea/spray.h"
#include "client/view/sky/sky.h"
#include "gpu/draw/graphics_pipeline.h"
#include "gpu/draw/offscreen.h"
#include "gpu/timer.h"
#include "shaders/shared/view.h"

namespace seaway::client {

struct RenderOptions {
    Quality quality = quality_table[quality_high];
    bool air = true;    ///< between the eye and the sea
    bool detail = true; ///< continue the waves beyond the finest cascade

    bool operator==(const RenderOptions&) const = default;
};

/// What of a frame the CPU wants to see.
enum class Wanted { nothing, numbers, bytes };

class Renderer {
  public:
    static constexpr std::size_t passes = 7;
    static constexpr std::array<std::string_view, passes> pass_names{
        "maps", "mesh", "geometry", "light", "spray", "bloom", "film"};

    static Result<Renderer> create(gpu::Device& device, int width, int height,
                                   const RenderOptions& options = {});

    /// Starts a frame; waits for the one before the last. An error means that the device failed or lacks something; where that is memory,
    /// of which the first frame takes the most, its kind says so (gpu::is_out_of_memory).
    /// frame: 1 .. shaders::view_cascades_max cascades; camera of the renderer's width and height. `mesh_of`: the
    /// camera that the mesh is built for, if it is looked at by another.
    Result<void> draw(const SeaFrame& frame, const Camera& camera, const Sky& sky,
                      const DebugChoice& debug, const Display& display, Wanted wanted,
                      const Camera* mesh_of = nullptr);
    /// Until everything that was started is done.
    Result<void> finish();

    Result<Picture> render(const SeaFrame& frame, const Camera& camera, const Sky& sky,
                           const DebugChoice& debug = {});
    Result<ShownPicture> show(const SeaFrame& frame, const Camera& camera, const Sky& sky,
                              const DebugChoice& debug, const Display& display);
    /// Numbers to bytes, without drawing: a picture of the size that is drawn, as render() gives it.
    Result<ShownPicture> develop(const Picture& picture, const Display& display);
    /// The same; the bytes stay on the device, see shown().
    Result<void> develop_there(const Picture& picture, const Display& display);
    /// Pixels that are drawn.
    int drawn_width() const { return static_cast<int>(target_.size().width); }
    int drawn_height() const { return static_cast<int>(target_.size().height); }
    const RenderOptions& options() const { return options_; }

    /// The last frame that was drawn for bytes, or for nothing: sRGB, on the device, ready to be sampled.
    const gpu::Image& shown() const { return target_.shown(); }
    /// Seconds of the passes of the last frame that was waited for, [pass]; empty before, 0 on a device without time
    /// stamps.
    const std::vector<double>& pass_times() const { return pass_times_; }
    /// See DeviceSea::copies().
    std::uint64_t copies() const { return sea_.copies(); }
    /// Passes of spray so far: none below Beaufort 8.
    std::uint64_t spray_passes() const { return spray_.passes(); }

  private:
    struct Upload {
        gpu::Buffer staging;
        gpu::Image image;
    };
    /// What one frame under way needs for itself.
    struct Flight {
        gpu::Buffer values, rows;
        gpu::Bindings mesh, draw, shown, bloomed, debug;
        gpu::Commands commands;
        gpu::Timer timer;
        std::uint64_t generation = 0;       ///< of the sea's buffers that the bindings are of
        std::uint64_t debug_generation = 0; ///< likewise
        std::uint64_t ticket = 0;           ///< 0: none
    };
    Renderer(gpu::Device& device, const RenderOptions& options)
        : device_(&device), options_(options) {}

    Result<void> create_pipelines();
    Result<void> create_sky();
    Result<void> create_flight(Flight& flight);
    Result<void> take_sky(const Sky& sky);
    Result<void> take_mesh(Flight& flight, const Mesh& mesh);
    Result<void> develop_as(const Picture& picture, const Display& display, Wanted wanted);
    Result<void> bind(Flight& flight);
    Result<void> bind_film(Flight& flight);
    bool blooms(const Display& display) const;
    Result<void> prepare_debug(DebugView view);
    Result<void> bind_debug(Flight& flight);
    void record_film(Flight& flight, DebugView view, bool blooms);
    ShownPicture shown_picture() const;
    Result<void> wait(Flight& flight);
    void record_geometry(Flight& flight, const Mesh& mesh);
    Result<void> record(Flight& flight, const Mesh& mesh, DebugView view,
                        const Lighting::Needs& needs, Wanted wanted, bool blooms);

    gpu::Device* device_;
    RenderOptions options_;
    DeviceSea sea_;
    gpu::Offscreen target_;
    gpu::Kernel mesh_;
    gpu::GraphicsPipeline geometry_, shown_, bloomed_;
    Lighting lighting_;
    Bloom bloom_;
    Spray spray_;
    std::optional<DebugPasses> debug_; ///< made when a view of numbers is asked for
    gpu::OwnedSampler sampler_;
    gpu::Buffer vertices_, indices_, undeveloped_;
    gpu::TexelView vertex_texels_;
    Upload sky_map_;
    bool sky_is_new_ = false;
    std::shared_ptr<const std::vector<float>> sky_texels_; ///< that it is made of
    int columns_ = 0;                                      ///< that the indices are of
    std::uint64_t generation_ = 1;
    std::array<Flight, 2> flights_;
    std::size_t next_ = 0;
    std::vector<double> pass_times_;
};

/// The part of what shaders are told that is of how numbers become bytes.
void set_display(shaders::ViewValues& values, const Display& display, double scale);

/// The same of views of numbers.
void set_debug_colours(shaders::ViewDebug& out, const Display& display);
/// What views of numbers are told of a frame, and of the picture that is drawn.
void set_debug(shaders::ViewDebug& out, const SeaFrame& frame, const Camera& camera,
               const DebugChoice& choice);
/// Display::largest of a view whose numbers are drawn.
double largest_number(const SeaFrame& frame, const DebugChoice& choice);

/// What the shaders are told of a frame, but for where its maps lie in memory; separate so that it can be read and
/// tested by itself.
shaders::ViewValues view_values(const SeaFrame& frame, const Camera& camera, const Sky& sky,
                                const Mesh& mesh, const RenderOptions& options,
                                const DebugChoice& debug, const Display& display);

} // namespace seaway::client
