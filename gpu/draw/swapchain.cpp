// SPDX-License-Identifier: Apache-2.0
#include "gpu/draw/swapchain.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "gpu/call.h"
#include "gpu/image.h"

namespace seaway::gpu {

namespace {

// In this order: bytes that are sRGB already want an image that leaves them as they are.
constexpr VkFormat formats[] = {VK_FORMAT_B8G8R8A8_UNORM, VK_FORMAT_R8G8B8A8_UNORM,
                                VK_FORMAT_B8G8R8A8_SRGB, VK_FORMAT_R8G8B8A8_SRGB};

/// One is shown, one waits to be, one is drawn.
constexpr std::uint32_t images_wished = 3;

Result<OwnedSemaphore> create_semaphore(Device& device) {
    const VkSemaphoreCreateInfo info{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
    VkSemaphore semaphore = VK_NULL_HANDLE;
    SEAWAY_TRY(
        call("vkCreateSemaphore", vkCreateSemaphore, device.get(), &info, nullptr, &semaphore));
    return OwnedSemaphore(device.get(), semaphore);
}

/// Of a picture that is drawn into once.
constexpr VkImageSubresourceRange whole_picture{VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};

/// The window system says a size, or leaves it to the program within limits.
std::uint32_t side(std::uint32_t current, std::uint32_t wanted, std::uint32_t least,
                   std::uint32_t most) {
    return current != std::numeric_limits<std::uint32_t>::max() ? current
                                                                : std::clamp(wanted, least, most);
}

} // namespace

Swapchain::Swapchain(Device& device, MakeSurface make_surface)
    : device_(&device), make_surface_(std::move(make_surface)) {}

Swapchain::Swapchain(Swapchain&& other) noexcept
    : device_(other.device_), make_surface_(std::move(other.make_surface_)),
      surface_(std::exchange(other.surface_, VK_NULL_HANDLE)), format_(other.format_),
      extent_(other.extent_), asked_(other.asked_), chain_(std::move(other.chain_)),
      pictures_(std::move(other.pictures_)), flights_(std::move(other.flights_)),
      flight_(other.flight_), current_(other.current_), fits_(other.fits_),
      generation_(other.generation_) {}

Swapchain::~Swapchain() {
    if (surface_ == VK_NULL_HANDLE || is_given_up(device_->get()))
        return;
    (void)device_->wait_idle();
    destroy_surface();
}

Result<Swapchain> Swapchain::create(Device& device, MakeSurface make_surface) {
    Swapchain made(device, std::move(make_surface));
    SEAWAY_TRY(made.create_surface());
    for (Flight& flight : made.flights_) {
        SEAWAY_TRY_LET(flight.acquired, create_semaphore(device));
    }
    return made;
}

void Swapchain::destroy_surface() {
    pictures_.clear();
    chain_.reset();
    vkDestroySurfaceKHR(device_->instance(), std::exchange(surface_, VK_NULL_HANDLE), nullptr);
}

Result<void> Swapchain::create_surface() {
    SEAWAY_TRY_LET(surface_, make_surface_(device_->instance()));
    VkBool32 shows = VK_FALSE;
    SEAWAY_TRY(call("vkGetPhysicalDeviceSurfaceSupportKHR", vkGetPhysicalDeviceSurfaceSupportKHR,
                    device_->physical(), device_->queue_family(), surface_, &shows));
    if (!shows)
        return Error{device_->info().name + " cannot show pictures in this window"};
    return pick_format();
}

Result<void> Swapchain::pick_format() {
    std::uint32_t count = 0;
    SEAWAY_TRY(call("vkGetPhysicalDeviceSurfaceFormatsKHR", vkGetPhysicalDeviceSurfaceFormatsKHR,
                    device_->physical(), surface_, &count, nullptr));
    std::vector<VkSurfaceFormatKHR> offered(count);
    SEAWAY_TRY(call("vkGetPhysicalDeviceSurfaceFormatsKHR", vkGetPhysicalDeviceSurfaceFormatsKHR,
                    device_->physical(), surface_, &count, offered.data()));
    for (const VkFormat wanted : formats)
        for (const VkSurfaceFormatKHR& format : offered)
            if (format.format == wanted && format.colorSpace == VK_COLOR_SPACE_SRGB_NONLINEAR_KHR) {
                format_ = format;
                return {};
            }
    return Error{device_->info().name + " offers no format of 8-bit sRGB for this window"};
}

bool Swapchain::encodes() const {
    return format_.format == VK_FORMAT_B8G8R8A8_SRGB || format_.format == VK_FORMAT_R8G8B8A8_SRGB;
}

Result<bool> Swapchain::create_chain(std::uint32_t width, std::uint32_t height) {
    VkSurfaceCapabilitiesKHR can;
    SEAWAY_TRY(call("vkGetPhysicalDeviceSurfaceCapabilitiesKHR",
                    vkGetPhysicalDeviceSurfaceCapabilitiesKHR, device_->physical(), surface_,
                    &can));
    const VkExtent2D extent{
        side(can.currentExtent.width, width, can.minImageExtent.width, can.maxImageExtent.width),
        side(can.currentExtent.height, height, can.minImageExtent.height,
             can.maxImageExtent.height)};
    if (extent.width == 0 || extent.height == 0 || width == 0 || height == 0)
        return false;
    // Pictures of the old one may still be under way.
    SEAWAY_TRY(device_->wait_idle());
    pictures_.clear();
    const std::uint32_t most =
        can.maxImageCount > 0 ? can.maxImageCount : std::numeric_limits<std::uint32_t>::max();
    const bool opaque = (can.supportedCompositeAlpha & VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR) != 0;
    const VkSwapchainCreateInfoKHR info{
        .sType = VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR,
        .surface = surface_,
        .minImageCount = std::min(std::max(can.minImageCount, images_wished), most),
        .imageFormat = format_.format,
        .imageColorSpace = format_.colorSpace,
        .imageExtent = extent,
        .imageArrayLayers = 1,
        .imageUsage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT,
        .imageSharingMode = VK_SHARING_MODE_EXCLUSIVE,
        .preTransform = can.currentTransform,
        .compositeAlpha =
            opaque ? VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR : VK_COMPOSITE_ALPHA_INHERIT_BIT_KHR,
        .presentMode = VK_PRESENT_MODE_FIFO_KHR, // the one that every device has
        .clipped = VK_TRUE,
        .oldSwapchain = chain_.get()};
    VkSwapchainKHR chain = VK_NULL_HANDLE;
    SEAWAY_TRY(
        call("vkCreateSwapchainKHR", vkCreateSwapchainKHR, device_->get(), &info, nullptr, &chain));
    chain_ = OwnedSwapchain(device_->get(), chain);
    extent_ = extent;
    SEAWAY_TRY(create_pictures());
    ++generation_;
    fits_ = true;
    return true;
}

Result<void> Swapchain::create_pictures() {
    std::uint32_t count = 0;
    SEAWAY_TRY(call("vkGetSwapchainImagesKHR", vkGetSwapchainImagesKHR, device_->get(),
                    chain_.get(), &count, nullptr));
    std::vector<VkImage> images(count);
    SEAWAY_TRY(call("vkGetSwapchainImagesKHR", vkGetSwapchainImagesKHR, device_->get(),
                    chain_.get(), &count, images.data()));
    for (VkImage image : images) {
        const VkImageViewCreateInfo info{
            .sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
            .image = image,
            .viewType = VK_IMAGE_VIEW_TYPE_2D,
            .format = format_.format,
            .subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1}};
        VkImageView view = VK_NULL_HANDLE;
        SEAWAY_TRY(
            call("vkCreateImageView", vkCreateImageView, device_->get(), &info, nullptr, &view));
        Picture picture{.image = image, .view = OwnedImageView(device_->get(), view)};
        SEAWAY_TRY_LET(picture.drawn, create_semaphore(*device_));
        pictures_.push_back(std::move(picture));
    }
    return {};
}

Result<bool> Swapchain::mended(const Result<void>& done) {
    if (done)
        return true;
    const Error& error = done.error();
    if (error.is(VK_ERROR_SURFACE_LOST_KHR)) {
        SEAWAY_TRY(device_->wait_idle());
        destroy_surface();
    } else if (!error.is(VK_ERROR_OUT_OF_DATE_KHR)) {
        return error;
    }
    fits_ = false;
    return false;
}

Result<Swapchain::Next> Swapchain::acquire(std::uint32_t width, std::uint32_t height) {
    if (surface_ == VK_NULL_HANDLE)
        SEAWAY_TRY(create_surface());
    Flight& flight = flights_[flight_];
    if (flight.ticket != 0)
        SEAWAY_TRY(device_->wait(std::exchange(flight.ticket, 0)));
    // Some window systems say so only when the next picture is shown, or never.
    if (width != asked_.width || height != asked_.height)
        fits_ = false;
    asked_ = {width, height};
    if (!fits_) {
        const Result<bool> made = create_chain(width, height);
        SEAWAY_TRY_LET(const bool fine, mended(made ? Result<void>() : made.error()));
        if (!fine || !*made)
            return Next::wait;
    }
    constexpr std::uint64_t patience_ns = 1'000'000'000; // of a window that nobody can see
    VkResult outcome = VK_SUCCESS;
    const auto next = [&] {
        outcome = vkAcquireNextImageKHR(device_->get(), chain_.get(), patience_ns,
                                        flight.acquired.get(), VK_NULL_HANDLE, &current_);
        return outcome == VK_TIMEOUT ? VK_NOT_READY : outcome;
    };
    SEAWAY_TRY_LET(const bool fine, mended(call("vkAcquireNextImageKHR", next)));
    if (!fine || outcome == VK_TIMEOUT || outcome == VK_NOT_READY)
        return Next::wait;
    if (outcome == VK_SUBOPTIMAL_KHR) // this one is still shown
        fits_ = false;
    return Next::draw;
}

void Swapchain::begin(Commands& commands) {
    const Picture& picture = pictures_[current_];
    record_transition(commands, picture.image, whole_picture, VK_IMAGE_LAYOUT_UNDEFINED,
                      VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    const VkRenderingAttachmentInfo colour{.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                           .imageView = picture.view.get(),
                                           .imageLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                                           .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
                                           .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                                           .clearValue = {.color = {.float32 = {0, 0, 0, 1}}}};
    const VkRect2D area{{0, 0}, extent_};
    const VkRenderingInfo info{.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                               .renderArea = area,
                               .layerCount = 1,
                               .colorAttachmentCount = 1,
                               .pColorAttachments = &colour};
    vkCmdBeginRendering(commands.get(), &info);
    const VkViewport viewport{
        0, 0, static_cast<float>(extent_.width), static_cast<float>(extent_.height), 0, 1};
    vkCmdSetViewport(commands.get(), 0, 1, &viewport);
    vkCmdSetScissor(commands.get(), 0, 1, &area);
}

void Swapchain::end(Commands& commands) {
    vkCmdEndRendering(commands.get());
    record_transition(commands, pictures_[current_].image, whole_picture,
                      VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_PRESENT_SRC_KHR);
}

Result<void> Swapchain::present(const Commands& commands) {
    Flight& flight = flights_[flight_];
    const VkSemaphore drawn = pictures_[current_].drawn.get();
    SEAWAY_TRY_LET(flight.ticket, device_->submit(commands, flight.acquired.get(), drawn));
    flight_ = (flight_ + 1) % flights;
    const VkSwapchainKHR chain = chain_.get();
    const VkPresentInfoKHR info{.sType = VK_STRUCTURE_TYPE_PRESENT_INFO_KHR,
                                .waitSemaphoreCount = 1,
                                .pWaitSemaphores = &drawn,
                                .swapchainCount = 1,
                                .pSwapchains = &chain,
                                .pImageIndices = &current_};
    const Result<bool> shown = mended(device_->present(info));
    return shown ? Result<void>() : shown.error();
}

} // namespace seaway::gpu
