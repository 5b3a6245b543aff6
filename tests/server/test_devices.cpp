// SPDX-License-Identifier: Apache-2.0
// Which device a server takes where the choice is its own, and the one that it would take does not work.
#include <optional>
#include <string>
#include <vector>

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

/// What stands at its place is another device.
gpu::DeviceInfo taken_by_another(gpu::DeviceInfo place) {
    place.name = "Another " + place.name;
    place.uuid[0] ^= 1;
    return place;
}

// Naive: `--device 0` is a place in a list. A GPU falls off its bus, and the driver for processors stands there now.
TEST(Devices, of_a_device_that_was_named_there_is_no_other_whatever_has_its_place_by_then) {
    const auto scene = sea::read_scene(SEAWAY_SOURCE_DIR "/scenes/calm.toml");
    ASSERT_TRUE(scene);
    const auto sea = *make_running_sea(*scene, 1);
    const gpu::DeviceInfo named = gpu::list_devices().value().at(0);
    for (const std::string& wish : {std::string("0"), named.name}) {
        std::vector<gpu::DeviceInfo> there{named};
        Options options;
        options.device = wish;
        const SynthesizerFactory factory = device_factory(
            options, [&there] { return Result<std::vector<gpu::DeviceInfo>>(there); });
        const auto first = factory(sea->realization, 1, Making::what_there_is);
        ASSERT_TRUE(first) << first.error().message;
        there = {taken_by_another(named)};
        for (const Making making : {Making::the_same, Making::what_there_is, Making::another}) {
            const auto other = factory(sea->realization, 1, making);
            ASSERT_FALSE(other) << (*other)->description();
            EXPECT_NE(
                other.error().message.find(named.name + " is not there; there are: 0 = Another"),
                std::string::npos)
                << other.error().message;
        }
        there.push_back(named); // it is back, behind the other one
        there.back().index = 1;
        const auto again = factory(sea->realization, 1, Making::the_same);
        ASSERT_TRUE(again) << again.error().message;
        EXPECT_EQ((*again)->description(), (*first)->description());
    }
}

// Naive: between a look at the list and the making of a device the list is another.
TEST(Devices, what_was_chosen_is_made_and_not_what_has_its_place_by_then) {
    const auto scene = sea::read_scene(SEAWAY_SOURCE_DIR "/scenes/calm.toml");
    ASSERT_TRUE(scene);
    const auto sea = *make_running_sea(*scene, 1);
    const gpu::DeviceInfo real = gpu::list_devices().value().at(0);
    const DeviceChoice chosen{0, "the best GPU", taken_by_another(real).identity()};
    bool had_gpu = true;
    EXPECT_FALSE(make_best(chosen, false, sea->realization, 1, Making::the_same, had_gpu));
    const auto other =
        make_best(chosen, false, sea->realization, 1, Making::what_there_is, had_gpu);
    ASSERT_TRUE(other) << other.error().message;
    EXPECT_NE((*other)->description().find("native"), std::string::npos) << (*other)->description();
    EXPECT_FALSE(had_gpu);
}

} // namespace
} // namespace seaway::server
