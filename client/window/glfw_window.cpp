// SPDX-License-Identifier: Apache-2.0
#include "client/window/glfw_window.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

// After gpu/vulkan.h, so that it knows Vulkan's types.
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <fmt/format.h>

#include "gpu/call.h"

namespace seaway::client {

namespace {

constexpr double tremble_points = 4;

std::string last_reason() {
    const char* words = nullptr;
    glfwGetError(&words);
    return words ? words : "";
}

GlfwWindow& self(GLFWwindow* window) {
    return *static_cast<GlfwWindow*>(glfwGetWindowUserPointer(window));
}

} // namespace

std::string no_display_message(const char* display, const char* wayland,
                               const std::string& reason) {
    const auto set = [](const char* value) { return value && *value; };
    std::string why = "DISPLAY is not set";
    if (set(display))
        why = fmt::format("DISPLAY={} cannot be opened", display);
    else if (set(wayland))
        why = fmt::format("WAYLAND_DISPLAY={} cannot be opened and DISPLAY is not set", wayland);
    return fmt::format("no window: {}{}; draw to files with --offscreen WxH --out FILE.png", why,
                       reason.empty() ? "" : " (" + reason + ")");
}

Result<std::unique_ptr<GlfwWindow>> GlfwWindow::open(const std::string& title, int width,
                                                     int height) {
    const auto none = [] {
        return Error{no_display_message(std::getenv("DISPLAY"), std::getenv("WAYLAND_DISPLAY"),
                                        last_reason())};
    };
#ifdef GLFW_PLATFORM_X11 // GLFW 3.4 looks for Wayland first, whose library complains by itself where there is none
    if (std::getenv("WAYLAND_DISPLAY") == nullptr)
        glfwInitHint(GLFW_PLATFORM, GLFW_PLATFORM_X11);
#endif
    if (!glfwInit())
        return none();
    std::unique_ptr<GlfwWindow> made(new GlfwWindow); // from here on ends GLFW
    if (!glfwVulkanSupported())
        return Error{"no window: no Vulkan loader that GLFW can use (install libvulkan1)"};
    std::uint32_t count = 0;
    const char** names = glfwGetRequiredInstanceExtensions(&count);
    if (names == nullptr)
        return Error{"no window: no Vulkan driver here can show one: " + last_reason()};
    made->extensions_.assign(names, names + count);
    glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API);
    glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
    made->window_ = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
    if (made->window_ == nullptr)
        return none();
    glfwSetWindowSizeLimits(made->window_, width_min, height_min, GLFW_DONT_CARE, GLFW_DONT_CARE);
    made->listen();
    return made;
}

GlfwWindow::~GlfwWindow() {
    if (window_ != nullptr)
        glfwDestroyWindow(window_);
    glfwTerminate();
}

void GlfwWindow::listen() {
    glfwSetWindowUserPointer(window_, this);
    glfwSetMouseButtonCallback(window_, [](GLFWwindow* window, int button, int action, int) {
        self(window).on_button(button, action);
    });
    glfwSetCursorPosCallback(
        window_, [](GLFWwindow* window, double x, double y) { self(window).on_cursor(x, y); });
    glfwSetScrollCallback(window_, [](GLFWwindow* window, double, double notches) {
        GlfwWindow& of = self(window);
        if (!of.taken_ || !of.taken_(of.cursor_.x, of.cursor_.y))
            of.wheel_ += notches;
    });
    glfwSetKeyCallback(window_, [](GLFWwindow* window, int key, int, int action, int modifiers) {
        constexpr std::pair<int, Command> keys[] = {{GLFW_KEY_1, Command::fly},
                                                    {GLFW_KEY_2, Command::orbit},
                                                    {GLFW_KEY_3, Command::follow},
                                                    {GLFW_KEY_M, Command::second_camera},
                                                    {GLFW_KEY_TAB, Command::panels}};
        if (action != GLFW_PRESS)
            return;
        for (const auto& [known, command] : keys)
            if (known == key)
                self(window).commands_.push_back(command);
        if (key == GLFW_KEY_Q && (modifiers & GLFW_MOD_CONTROL) != 0)
            self(window).close();
    });
}

void GlfwWindow::on_button(int button, int action) {
    if (button != GLFW_MOUSE_BUTTON_LEFT)
        return;
    glfwGetCursorPos(window_, &cursor_.x, &cursor_.y);
    if (action == GLFW_PRESS) {
        if (!taken_ || !taken_(cursor_.x, cursor_.y))
            pressed_ = cursor_;
        dragged_ = false;
        return;
    }
    if (pressed_ && !dragged_)
        click_ = *pressed_;
    pressed_.reset();
}

void GlfwWindow::on_cursor(double x, double y) {
    const glm::dvec2 at(x, y);
    if (pressed_ && glm::distance(at, *pressed_) > tremble_points)
        dragged_ = true;
    if (pressed_ && dragged_)
        turned_ += at - cursor_;
    cursor_ = at;
}

Result<VkSurfaceKHR> GlfwWindow::make_surface(VkInstance instance) const {
    VkSurfaceKHR surface = VK_NULL_HANDLE;
    SEAWAY_TRY(gpu::call("glfwCreateWindowSurface", glfwCreateWindowSurface, instance, window_,
                         nullptr, &surface));
    return surface;
}

void GlfwWindow::poll(double seconds) {
    if (seconds > 0)
        glfwWaitEventsTimeout(seconds);
    else
        glfwPollEvents();
}

bool GlfwWindow::should_close() const {
    return glfwWindowShouldClose(window_) != 0;
}

void GlfwWindow::close() {
    glfwSetWindowShouldClose(window_, GLFW_TRUE);
}

glm::ivec2 GlfwWindow::pixels() const {
    glm::ivec2 size(0);
    glfwGetFramebufferSize(window_, &size.x, &size.y);
    return glfwGetWindowAttrib(window_, GLFW_ICONIFIED) ? glm::ivec2(0) : size;
}

glm::ivec2 GlfwWindow::points() const {
    glm::ivec2 size(0);
    glfwGetWindowSize(window_, &size.x, &size.y);
    return size;
}

double GlfwWindow::scale() const {
    float x = 1, y = 1;
    glfwGetWindowContentScale(window_, &x, &y);
    return std::clamp(static_cast<double>(y), 1.0, 4.0);
}

bool GlfwWindow::held(int key) const {
    return glfwGetKey(window_, key) == GLFW_PRESS;
}

Steering GlfwWindow::take_steering(bool typing) {
    Steering steering;
    const double width = std::max(points().x, 1);
    const glm::dvec2 turned = std::exchange(turned_, glm::dvec2(0)) / width;
    steering.turn_x = turned.x;
    steering.turn_y = turned.y;
    steering.wheel = std::exchange(wheel_, 0.0);
    const auto axis = [&](int forth, int back) {
        return static_cast<double>(held(forth)) - static_cast<double>(held(back));
    };
    const bool control = held(GLFW_KEY_LEFT_CONTROL) || held(GLFW_KEY_RIGHT_CONTROL);
    if (typing || control)
        return steering;
    steering.ahead = axis(GLFW_KEY_W, GLFW_KEY_S);
    steering.right = axis(GLFW_KEY_D, GLFW_KEY_A);
    steering.up = axis(GLFW_KEY_E, GLFW_KEY_Q);
    steering.fast = held(GLFW_KEY_LEFT_SHIFT) || held(GLFW_KEY_RIGHT_SHIFT);
    return steering;
}

std::optional<glm::dvec2> GlfwWindow::take_click() {
    return std::exchange(click_, std::nullopt);
}

std::vector<GlfwWindow::Command> GlfwWindow::take_commands(bool typing) {
    std::vector<Command> taken = std::exchange(commands_, {});
    return typing ? std::vector<Command>{} : taken;
}

} // namespace seaway::client
