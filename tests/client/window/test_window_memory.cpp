// SPDX-License-Identifier: Apache-2.0
// A quality or a size that there is memory to make a renderer for, and none to draw its first frame: maps of the sea and the mesh are
// made then.
#include <gmock/gmock.h>

#include "gpu/call.h"
#include "tests/client/window/window_fixture.h"

namespace seaway::client {
namespace {

class WindowMemory : public WindowTest {
  protected:
    void TearDown() override {
        gpu::fault::disarm();
        WindowTest::TearDown();
    }
    /// The call that fails of a frame for which a renderer is made: behind those that make it, and the few that wait for the one before;
    /// the first frame has many more.
    std::uint64_t of_the_first_frame(std::size_t quality) const {
        const auto device = gpu::Device::create({.draws = true}).value();
        const std::uint64_t before = gpu::fault::calls();
        const auto made = Renderer::create(*device, width, height,
                                           {.quality = options().as_dense(quality_table[quality])});
        EXPECT_TRUE(made);
        return gpu::fault::calls() - before + 10;
    }
};

// Naive: what the device has no memory for ends the program, one frame later.
TEST_F(WindowMemory, a_quality_whose_first_frame_cannot_be_drawn_is_said_and_the_sea_goes_on) {
    open(options());
    const std::uint64_t call = of_the_first_frame(quality_default);
    choose_quality("default");
    const std::uint64_t drawn = viewer_->sea_frames();
    gpu::fault::arm(call, VK_ERROR_OUT_OF_DEVICE_MEMORY);
    step(1);
    gpu::fault::disarm();
    EXPECT_EQ(viewer_->sea_frames(), drawn + 1) << "by the quality before, in the same frame";
    EXPECT_TRUE(says("default, 720 x 400: "));
    EXPECT_THAT(viewer_->model().notice, testing::HasSubstr("VK_ERROR_OUT_OF_DEVICE_MEMORY"));
    EXPECT_EQ(viewer_->choice().quality, quality_low);
    EXPECT_EQ(viewer_->renderer()->options().quality, quality_table[quality_low]);
    ASSERT_TRUE(step_until([&] { return viewer_->sea_frames() > drawn + 3; }));
    choose_quality("default"); // there is memory by now
    step();
    EXPECT_EQ(viewer_->renderer()->options().quality, quality_table[quality_default]);
    EXPECT_TRUE(says(""));
}

TEST_F(WindowMemory, a_size_whose_first_frame_cannot_be_drawn_is_said_and_not_tried_again) {
    open(options());
    const std::uint64_t call = of_the_first_frame(quality_low);
    const glm::ivec2 before = viewer_->drawn_pixels();
    display_->tool(fmt::format("windowsize {} {} {}", window_id(), 1000, 700));
    ASSERT_TRUE(step_until([&] {
        gpu::fault::arm(call, VK_ERROR_OUT_OF_DEVICE_MEMORY); // a frame alone has fewer calls
        return viewer_->model().notice.starts_with("low, 1000 x 700: ");
    }));
    gpu::fault::disarm();
    step(30);
    EXPECT_EQ(viewer_->drawn_pixels(), before);
    EXPECT_TRUE(says("low, 1000 x 700: "));
}

} // namespace
} // namespace seaway::client
