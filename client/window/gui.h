// SPDX-License-Identifier: Apache-2.0
// Gui: Dear ImGui in a GlfwWindow, drawn with a pipeline of our own: its backend for Vulkan is built against another
// loader and render passes. The picture of the sea is its background.
//
//     gui->begin(window);
//     gui->background(share_of_light);  ImGui::Begin(...) ...
//     gui->record(commands, swapchain);  // between Swapchain::begin() and end()
//
// Not thread-safe. One at a time.
#pragma once

#include <array>
#include <memory>

#include "base/result.h"
#include "client/window/glfw_window.h"
#include "gpu/draw/graphics_pipeline.h"
#include "gpu/draw/swapchain.h"
#include "gpu/image.h"

struct ImDrawData;

namespace seaway::client {

class Gui {
  public:
    static Result<std::unique_ptr<Gui>> create(gpu::Device& device, const GlfwWindow& window,
                                               const gpu::Swapchain& shows);
    ~Gui();
    Gui(const Gui&) = delete;
    Gui& operator=(const Gui&) = delete;

    /// What is behind the panels, ready to be sampled; null: nothing. The device must be idle.
    void set_picture(const gpu::Image* picture);

    void begin();
    /// Keys are text for a field of a panel.
    bool wants_keys() const;
    /// The picture over the whole window, that many times as bright, 0 .. 1.
    void background(double brightness);
    /// Ends the frame that begin() began; nothing is drawn.
    void drop();
    /// The same, and draws it.
    Result<void> record(gpu::Commands& commands, const gpu::Swapchain& to);

  private:
    /// Of std140 in shaders/view/gui.vert.
    struct Pane {
        float scale_x, scale_y, offset_x, offset_y;
        std::int32_t encodes;
        std::int32_t spare[3];
    };
    struct Flight {
        gpu::Buffer vertices, indices, pane;
        gpu::Bindings font, picture;
        bool bound = false;
    };

    explicit Gui(gpu::Device& device) : device_(&device) {}
    Result<void> create_font();
    Result<void> fill(Flight& flight, const ImDrawData& data);
    Result<void> bind(Flight& flight);

    gpu::Device* device_;
    bool encodes_ = false, has_context_ = false, has_window_ = false;
    gpu::GraphicsPipeline pipeline_;
    gpu::OwnedSampler sampler_;
    gpu::Image font_;
    const gpu::Image* picture_ = nullptr;
    std::array<Flight, gpu::Swapchain::flights> flights_;
};

} // namespace seaway::client
