// SPDX-License-Identifier: Apache-2.0
// A chain of pictures for a window, and what a window does to it. Here, because a surface takes a window system: the
// drivers of Debian 12 have none without.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/window/glfw_window.h"
#include "gpu/call.h"
#include "gpu/draw/swapchain.h"
#include "tests/client/window/display.h"

namespace seaway::gpu {
namespace {

class SwapchainTest : public testing::Test {
  protected:
    static void SetUpTestSuite() { display_ = std::make_unique<tests::Display>(); }
    static void TearDownTestSuite() { display_.reset(); }

    void SetUp() override {
        auto window = client::GlfwWindow::open("Seaway", 400, 300);
        ASSERT_TRUE(window) << window.error().message;
        window_ = std::move(*window);
        Result<std::unique_ptr<Device>> made =
            Device::create({.validation = true,
                            .instance_extensions = window_->instance_extensions(),
                            .device_extensions = {"VK_KHR_swapchain"}});
        ASSERT_TRUE(made) << made.error().message;
        device_ = std::move(*made);
        Result<Swapchain> chain =
            Swapchain::create(*device_, [this](VkInstance instance) { return surface(instance); });
        ASSERT_TRUE(chain) << chain.error().message;
        chain_.emplace(std::move(*chain));
        for (Commands& commands : commands_)
            commands = std::move(*Commands::create(*device_));
    }
    void TearDown() override {
        fault::disarm();
        if (!device_)
            return;
        chain_.reset();
        EXPECT_EQ(device_->validation().validation_message_count(), 0u);
        for (const std::string& message : device_->validation().validation_messages())
            ADD_FAILURE() << message;
    }
    Result<VkSurfaceKHR> surface(VkInstance instance) {
        ++surfaces_;
        return window_->make_surface(instance);
    }
    Result<Swapchain::Next> next() {
        window_->poll(0);
        return chain_->acquire(width_, height_);
    }
    Result<void> present() {
        Commands& commands = commands_[chain_->flight()];
        SEAWAY_TRY(commands.begin());
        chain_->begin(commands);
        chain_->end(commands);
        SEAWAY_TRY(commands.end());
        return chain_->present(commands);
    }
    void frames(int count) {
        for (int i = 0; i < count; ++i) {
            const Result<Swapchain::Next> got = next();
            ASSERT_TRUE(got) << got.error().message;
            ASSERT_EQ(*got, Swapchain::Next::draw);
            const Result<void> shown = present();
            ASSERT_TRUE(shown) << shown.error().message;
        }
    }

    static inline std::unique_ptr<tests::Display> display_;
    std::unique_ptr<client::GlfwWindow> window_;
    std::unique_ptr<Device> device_;
    std::optional<Swapchain> chain_;
    std::array<Commands, Swapchain::flights> commands_;
    std::uint32_t width_ = 400, height_ = 300;
    int surfaces_ = 0;
};

// Of calls in acquire() the wait for a flight is the first, the image the second; of those in present() here the
// commands are two, their submission the third. The errors below name the calls, so that these numbers are right.
constexpr std::uint64_t of_the_image = 2, of_showing = 4;

TEST_F(SwapchainTest, shows_pictures_of_the_windows_size_as_bytes_that_stay_as_they_are) {
    frames(7);
    EXPECT_EQ(chain_->extent().width, 400u);
    EXPECT_EQ(chain_->extent().height, 300u);
    EXPECT_FALSE(chain_->encodes());
    EXPECT_EQ(chain_->generation(), 1u);
}

TEST_F(SwapchainTest, is_made_anew_for_another_size_and_waits_while_there_is_none) {
    frames(3);
    width_ = 0;
    EXPECT_EQ(*next(), Swapchain::Next::wait);
    EXPECT_EQ(*next(), Swapchain::Next::wait);
    display_->tool("windowsize $(DISPLAY=" + display_->name() +
                   " xdotool search --name Seaway) 500 350");
    for (int i = 0; i < 1000 && window_->pixels().x != 500; ++i)
        window_->poll(0.01);
    width_ = 500;
    height_ = 350;
    frames(3);
    EXPECT_EQ(chain_->extent().width, 500u);
    EXPECT_EQ(chain_->extent().height, 350u);
    EXPECT_GT(chain_->generation(), 1u);
}

TEST_F(SwapchainTest, that_is_out_of_date_is_made_anew_whenever_that_shows) {
    frames(3);
    fault::arm(of_the_image, VK_ERROR_OUT_OF_DATE_KHR);
    const Result<Swapchain::Next> got = next();
    fault::disarm();
    ASSERT_TRUE(got) << got.error().message;
    EXPECT_EQ(*got, Swapchain::Next::wait);
    frames(3);
    EXPECT_EQ(chain_->generation(), 2u);
    ASSERT_EQ(*next(), Swapchain::Next::draw);
    fault::arm(of_showing, VK_ERROR_OUT_OF_DATE_KHR);
    const Result<void> shown = present();
    fault::disarm();
    EXPECT_TRUE(shown) << shown.error().message;
    frames(3);
    EXPECT_EQ(chain_->generation(), 3u);
    EXPECT_EQ(surfaces_, 1);
}

TEST_F(SwapchainTest, a_surface_that_is_lost_is_made_anew) {
    frames(3);
    fault::arm(of_the_image, VK_ERROR_SURFACE_LOST_KHR);
    const Result<Swapchain::Next> got = next();
    fault::disarm();
    ASSERT_TRUE(got) << got.error().message;
    EXPECT_EQ(*got, Swapchain::Next::wait);
    frames(3);
    EXPECT_EQ(surfaces_, 2);
    ASSERT_EQ(*next(), Swapchain::Next::draw);
    fault::arm(of_showing, VK_ERROR_SURFACE_LOST_KHR);
    const Result<void> shown = present();
    fault::disarm();
    EXPECT_TRUE(shown) << shown.error().message;
    frames(3);
    EXPECT_EQ(surfaces_, 3);
}

TEST_F(SwapchainTest, a_lost_device_is_an_error_that_names_the_call) {
    frames(3);
    fault::arm(of_the_image, VK_ERROR_DEVICE_LOST);
    const Result<Swapchain::Next> got = next();
    fault::disarm();
    ASSERT_FALSE(got);
    EXPECT_THAT(got.error().message,
                testing::HasSubstr("vkAcquireNextImageKHR: device lost (VK_ERROR_DEVICE_LOST)"));
    frames(1);
    ASSERT_EQ(*next(), Swapchain::Next::draw);
    fault::arm(of_showing, VK_ERROR_DEVICE_LOST);
    const Result<void> shown = present();
    fault::disarm();
    ASSERT_FALSE(shown);
    EXPECT_THAT(shown.error().message, testing::HasSubstr("vkQueuePresentKHR: device lost"));
}

// What a window system cannot do with a device is said by name, not by a crash later.
TEST_F(SwapchainTest, a_window_system_without_a_surface_is_an_error) {
    const Result<Swapchain> none = Swapchain::create(
        *device_, [](VkInstance) { return Result<VkSurfaceKHR>(Error{"no window there"}); });
    ASSERT_FALSE(none);
    EXPECT_EQ(none.error().message, "no window there");
}

} // namespace
} // namespace seaway::gpu
