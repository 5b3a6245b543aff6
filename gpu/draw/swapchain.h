// SPDX-License-Identifier: Apache-2.0
// Swapchain: pictures that a window shows, one after the other, at the screen's pace (FIFO).
//
//     Result<Swapchain> chain = Swapchain::create(device, make_surface);
//     Result<Swapchain::Next> next = chain->acquire(width, height);
//     if (*next == Swapchain::Next::draw) {
//         chain->begin(commands);  ... draw ...  chain->end(commands);
//         chain->present(commands);
//     }
//
// What a window does is no error: where its size changes or its surface is lost the chain is made anew at the next
// acquire(). Two pictures may be under way. Knows no window system: who makes the surface does.
//
// Not thread-safe. Goes before its device.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "base/result.h"
#include "gpu/commands.h"
#include "gpu/device.h"

namespace seaway::gpu {

class Swapchain {
  public:
    /// Pictures under way at once: [flight()] of whoever needs something for each.
    static constexpr std::size_t flights = 2;
    using MakeSurface = std::function<Result<VkSurfaceKHR>(VkInstance)>;

    enum class Next {
        draw, ///< begin() .. present() come now
        wait, ///< the window has no size, as one that is minimised, or is changing: ask again later
    };

    /// The device needs the instance extensions of the window system and VK_KHR_swapchain. An error says why this
    /// device cannot show anything in such a window.
    static Result<Swapchain> create(Device& device, MakeSurface make_surface);
    Swapchain(Swapchain&&) noexcept;
    Swapchain& operator=(Swapchain&&) = delete;
    ~Swapchain();

    /// The next image to draw to; waits for one, and until the commands of flight() have ended. `width` and `height`:
    /// of the window, pixels, for window systems that leave that to the program. An error: the device is lost.
    Result<Next> acquire(std::uint32_t width, std::uint32_t height);
    /// Whose turn it is, 0 .. flights - 1: its resources are free between acquire() and present().
    std::size_t flight() const { return flight_; }

    /// Draws to the image, which is black.
    void begin(Commands& commands);
    void end(Commands& commands);
    /// Submits what was recorded and shows it when it is done.
    Result<void> present(const Commands& commands);

    VkFormat format() const { return format_.format; }
    /// Of numbers that are written: true where the image encodes linear light as sRGB by itself.
    bool encodes() const;
    VkExtent2D extent() const { return extent_; }
    /// How often it was made.
    std::uint64_t generation() const { return generation_; }

  private:
    struct Picture {
        VkImage image = VK_NULL_HANDLE;
        OwnedImageView view;
        OwnedSemaphore drawn;
    };
    struct Flight {
        OwnedSemaphore acquired;
        std::uint64_t ticket = 0; ///< 0: none
    };

    Swapchain(Device& device, MakeSurface make_surface);
    Result<void> create_surface();
    Result<void> pick_format();
    /// False: the window has no size.
    Result<bool> create_chain(std::uint32_t width, std::uint32_t height);
    Result<void> create_pictures();
    void destroy_surface();
    /// What became of a call: an error that a new chain mends is none.
    Result<bool> mended(const Result<void>& done);

    Device* device_;
    MakeSurface make_surface_;
    VkSurfaceKHR surface_ = VK_NULL_HANDLE;
    VkSurfaceFormatKHR format_{};
    VkExtent2D extent_{};
    VkExtent2D asked_{}; ///< the window's size at the last acquire()
    OwnedSwapchain chain_;
    std::vector<Picture> pictures_;
    std::array<Flight, flights> flights_;
    std::size_t flight_ = 0;
    std::uint32_t current_ = 0; ///< of pictures_
    bool fits_ = false;         ///< the chain is as the window is
    std::uint64_t generation_ = 0;
};

} // namespace seaway::gpu
