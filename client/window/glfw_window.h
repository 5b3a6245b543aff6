// SPDX-License-Identifier: Apache-2.0
// GlfwWindow: a window of the desktop, what the user does in it, and its surface for Vulkan. One at a time; for the
// thread that made it.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "base/result.h"
#include "client/window/pilot.h"
#include "gpu/vulkan.h"

struct GLFWwindow;

namespace seaway::client {

/// Why no window opens, in one line that says what to do instead. `display`, `wayland`: the values of DISPLAY and
/// WAYLAND_DISPLAY, null if they are not set; `reason`: what GLFW says.
std::string no_display_message(const char* display, const char* wayland, const std::string& reason);

class GlfwWindow {
  public:
    /// Keys that are pressed once.
    enum class Command { fly, orbit, follow, second_camera, panels };
    static constexpr int width_min = 320, height_min = 200;

    /// The error is no_display_message(), or names the extension that Vulkan lacks.
    static Result<std::unique_ptr<GlfwWindow>> open(const std::string& title, int width,
                                                    int height);
    ~GlfwWindow();
    GlfwWindow(const GlfwWindow&) = delete;
    GlfwWindow& operator=(const GlfwWindow&) = delete;

    /// Of the instance, for a surface.
    const std::vector<std::string>& instance_extensions() const { return extensions_; }
    Result<VkSurfaceKHR> make_surface(VkInstance instance) const;

    /// Takes what has happened; waits for something, `seconds` at most.
    void poll(double seconds);
    bool should_close() const;
    void close();
    /// Pixels; 0 where it is minimised.
    glm::ivec2 pixels() const;
    /// Points of the window, in which the mouse is: not pixels on every system.
    glm::ivec2 points() const;
    /// Pixels of a point of text, for the monitor that it is on.
    double scale() const;

    /// Which points of the window are not the sea's, but a panel's.
    void set_taken(std::function<bool(double x, double y)> taken) { taken_ = std::move(taken); }
    /// What was done since the last call. `typing`: keys are text for somebody else.
    Steering take_steering(bool typing);
    /// Where the sea was clicked, points.
    std::optional<glm::dvec2> take_click();
    std::vector<Command> take_commands(bool typing);

    GLFWwindow* get() const { return window_; }

  private:
    GlfwWindow() = default;
    void listen();
    void on_button(int button, int action);
    void on_cursor(double x, double y);
    bool held(int key) const;

    GLFWwindow* window_ = nullptr;
    std::vector<std::string> extensions_;
    std::function<bool(double, double)> taken_;
    std::optional<glm::dvec2> pressed_; ///< where the button went down on the sea
    bool dragged_ = false;              ///< further than a hand trembles
    glm::dvec2 cursor_{0.0}, turned_{0.0};
    double wheel_ = 0;
    std::optional<glm::dvec2> click_;
    std::vector<Command> commands_;
};

} // namespace seaway::client
