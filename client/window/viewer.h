// SPDX-License-Identifier: Apache-2.0
// Viewer: the window of seaway-view. Draws the sea of now, of a server or as it is made here, and panels over it.
//
//     Result<std::unique_ptr<Viewer>> viewer = Viewer::open(options, connect_options);
//     for (;;) {
//         Result<bool> open = (*viewer)->step();   // one frame
//         if (!open || !*open) break;
//     }
//
// Where no keyframes cover the time the last frame stays, dimmed, with its age. One at a time; for the thread that
// made it.
#pragma once

#include <array>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/view/debug/debug_pictures.h"
#include "client/view/renderer.h"
#include "client/view/view_options.h"
#include "client/view/view_sky.h"
#include "client/window/glfw_window.h"
#include "client/window/gui.h"
#include "client/window/model.h"
#include "client/window/panels.h"
#include "client/window/pilot.h"
#include "client/window/probe.h"
#include "client/window/seen_sea.h"
#include "gpu/draw/swapchain.h"

namespace seaway::client {

class Viewer {
  public:
    /// An error is one line: no display, no device that can show pictures in a window, or not enough memory. That
    /// there is no server is none: it is tried again. `validation`: for tests.
    static Result<std::unique_ptr<Viewer>> open(const ViewOptions& options, const OpenSea& open_sea,
                                                bool validation = false);
    /// A server's sea.
    static OpenSea streamed(const ConnectOptions& connect, const TileLimits& limits);
    ~Viewer();
    Viewer(const Viewer&) = delete;
    Viewer& operator=(const Viewer&) = delete;

    /// One frame. False: the window was closed. An error: the device is lost. A quality or a size that it has not the
    /// memory for is none: the sea is drawn as before, and the notice says so.
    Result<bool> step();

    const WindowModel& model() const { return model_; }
    const ViewChoice& choice() const { return choice_; }
    const Panels& panels() const { return panels_; }
    const Camera& camera() const { return pilot_.camera(); }
    /// What the sea is drawn by.
    const std::optional<Renderer>& renderer() const { return renderer_; }
    const std::optional<Probe>& probe() const { return probe_; }
    const gpu::Device& device() const { return *device_; }
    glm::ivec2 pixels() const { return window_->pixels(); }
    /// The size that the sea is drawn for; the window's, but for a moment after that has changed.
    glm::ivec2 drawn_pixels() const { return drawn_pixels_; }
    /// Of the sea that is shown; 0 before there is one.
    sea::TimeUs sea_time_us() const { return frame_ ? frame_->time_us : 0; }
    /// Frames of the sea that were drawn.
    std::uint64_t sea_frames() const { return sea_frames_; }
    const SkyFeed& skies() const { return skies_; }

  private:
    using Clock = std::chrono::steady_clock;
    /// What a picture is of.
    using Inputs = std::pair<std::vector<double>, std::string>;
    /// What a renderer is made for.
    struct Fit {
        glm::ivec2 pixels{0};
        std::size_t quality = 0;
    };

    explicit Viewer(const ViewOptions& options);
    Result<void> create(const OpenSea& open_sea, bool validation);
    Result<void> fit_renderer(const glm::ivec2& pixels);
    Result<void> create_renderer(const glm::ivec2& pixels, std::size_t quality);
    /// From what the device cannot draw to what it drew before; why is said.
    Result<void> go_back(const glm::ivec2& pixels, std::size_t quality, const Error& why);
    Result<void> take_sea();
    void take_input(double seconds);
    void move_with_the_sea(double seconds);
    void take_click();
    /// The camera, of the size that is drawn.
    Camera seen_by() const;
    Result<void> draw_sea();
    Result<bool> draw_view(const SeaFrame& frame, const Sky& sky);
    void measure();
    void fill_model();
    Result<void> show(const glm::ivec2& pixels);
    Inputs inputs() const;
    double age_s() const;

    ViewOptions options_;
    std::unique_ptr<GlfwWindow> window_;
    std::shared_ptr<gpu::Device> device_;
    std::optional<gpu::Swapchain> swapchain_;
    std::array<gpu::Commands, gpu::Swapchain::flights> commands_;
    std::optional<Renderer> renderer_;
    glm::ivec2 drawn_pixels_{0}, wanted_pixels_{0};
    glm::ivec2 refused_pixels_{0}; ///< of a window that the device cannot draw for; 0: none
    std::string fit_problem_;      ///< why the quality or the size that was asked for is not drawn
    std::size_t drawn_quality_ = 0;
    /// The last renderer's, until this one has drawn: its first frame takes most of its memory.
    std::optional<Fit> before_;
    Clock::time_point wanted_since_;
    bool picture_is_set_ = false;
    std::unique_ptr<Gui> gui_;
    std::unique_ptr<SeenSea> sea_;

    Pilot pilot_;
    Camera mesh_camera_;
    ViewChoice choice_;
    Panels panels_;
    WindowModel model_;
    std::optional<Probe> probe_;
    SkyFeed skies_;
    DebugPictures debug_;
    std::string debug_problem_; ///< why the view that was chosen cannot be shown; empty: it is

    std::optional<SeaFrame> frame_; ///< the last that was held
    PointsPtr points_;              ///< of that time
    SeaStatePtr state_;
    Clock::time_point live_at_; ///< when it was of now
    Inputs drawn_inputs_;
    std::uint64_t sea_frames_ = 0;

    Clock::time_point stepped_, measured_;
    SeenSea::Counts measured_counts_;
    std::uint64_t measured_frames_ = 0;
    double keyframes_hz_ = 0, bytes_hz_ = 0, frames_hz_ = 0;
};

} // namespace seaway::client
