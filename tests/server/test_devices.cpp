// SPDX-License-Identifier: Apache-2.0
// Which device a server takes where the choice is its own, and the one that it would take does not work.
#include <optional>
#include <string>

#include <gtest/gtest.h>

#include "gpu/call.h"
#include "sea/scene/scene.h"
#include "server/devices.h"
#include "server/simulation/running_sea.h"

namespace seaway::server {
namespace {

// Naive: a GPU that another process holds, or that has no memory left, ends a server that would do without. The first Vulkan device
// that is there stands for a GPU.
TEST(Devices, what_cannot_be_made_is_done_without_where_no_other_try_follows) {
    const auto scene = sea::read_scene(SEAWAY_SOURCE_DIR "/scenes/calm.toml");
    ASSERT_TRUE(scene);
    const auto sea = *make_running_sea(*scene, 1);
    bool had_gpu = false;
    const auto made = [&](Making making, std::optional<int> vulkan = 0) {
        return make_best({vulkan, "as it is"}, false, sea->realization, 1, making, had_gpu);
    };
    ASSERT_TRUE(made(Making::the_same, {})) << "there never was one";
    const auto gpu = made(Making::the_same);
    ASSERT_TRUE(gpu) << gpu.error().message;
    for (const VkResult fault : {VK_ERROR_INITIALIZATION_FAILED, VK_ERROR_OUT_OF_DEVICE_MEMORY})
        for (const std::uint64_t call : {1u, 40u}) { // no instance; amid buffers
            gpu::fault::arm(call, fault, true);
            EXPECT_FALSE(made(Making::the_same)) << "it may be there again";
            gpu::fault::disarm();
            ASSERT_TRUE(made(Making::the_same));
            EXPECT_TRUE(had_gpu);
            EXPECT_FALSE(made(Making::the_same, {})) << "it is not even listed: it may be again";
            gpu::fault::arm(call, fault, true);
            const auto other = made(Making::what_there_is);
            gpu::fault::disarm();
            ASSERT_TRUE(other) << other.error().message;
            EXPECT_NE((*other)->description(), (*gpu)->description());
            EXPECT_NE((*other)->description().find("native"), std::string::npos)
                << (*other)->description();
            EXPECT_FALSE(had_gpu);
        }
    const auto another = made(Making::another);
    ASSERT_TRUE(another);
    EXPECT_NE((*another)->description().find("native"), std::string::npos)
        << "it can be made, and fails at its work";
}

} // namespace
} // namespace seaway::server
