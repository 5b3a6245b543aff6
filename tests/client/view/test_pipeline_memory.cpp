// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "gpu/call.h"
#include "gpu/draw/graphics_pipeline.h"
#include "gpu/draw/offscreen.h"
#include "shaders/view/picture_vert.h"
#include "shaders/view/shown_frag.h"

namespace seaway::client {
namespace {

// Naive: the name of the pipeline takes the place of what kind of error it is, and a window ends that could draw less.
TEST(PipelineMemory, a_pipeline_that_there_is_no_memory_for_is_told_from_one_that_cannot_be) {
    const auto device = gpu::Device::create({.draws = true}).value();
    const gpu::ExpectedBinding bindings[] = {
        {"View", VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER},
        {"picture", VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER}};
    const auto made_but_for = [&](std::uint64_t call) {
        gpu::fault::arm(call, VK_ERROR_OUT_OF_DEVICE_MEMORY);
        Result<gpu::GraphicsPipeline> made =
            gpu::GraphicsPipeline::create(*device, "film", picture_vert, shown_frag, bindings,
                                          {.colour_format = gpu::Offscreen::shown_format});
        gpu::fault::disarm();
        return made;
    };
    constexpr std::uint64_t calls = 5; // two shaders, two layouts, the pipeline
    for (std::uint64_t call = 1; call <= calls; ++call) {
        const Result<gpu::GraphicsPipeline> made = made_but_for(call);
        ASSERT_FALSE(made) << call;
        EXPECT_TRUE(gpu::is_out_of_memory(made.error())) << made.error().message;
    }
    EXPECT_TRUE(made_but_for(calls + 1));
    const auto never =
        gpu::GraphicsPipeline::create(*device, "film", picture_vert, shown_frag, {}, {});
    ASSERT_FALSE(never);
    EXPECT_FALSE(gpu::is_out_of_memory(never.error())) << never.error().message;
}

} // namespace
} // namespace seaway::client
