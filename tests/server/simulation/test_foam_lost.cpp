// SPDX-License-Identifier: Apache-2.0
// Foam whose device is lost, or that finds no memory to start in.
#include "gpu/call.h"
#include "server/device/vulkan_synthesizer.h"
#include "server/simulation/foam_maps.h"
#include "server/simulation/streamed_foam.h"
#include "tests/server/simulation/simulation_bench.h"
#include "tests/support/eventually.h"

namespace seaway::server {
namespace {

const std::string lasting = "[foam]\nthreshold = 0.8\ndecay_s = 3\n";

/// Of which no call fails.
Result<std::unique_ptr<Synthesizer>> sound_vulkan(const sea::RealizationPtr& waves,
                                                  std::uint32_t epoch, server::Making) {
    gpu::fault::disarm();
    SEAWAY_TRY_LET(std::unique_ptr<VulkanSynthesizer> made,
                   make_vulkan_synthesizer({.validation = true}));
    SEAWAY_TRY(made->set_sea(waves, epoch));
    return std::unique_ptr<Synthesizer>(std::move(made));
}

TEST(FoamLost, with_its_device_is_walked_for_anew_on_the_next_one) {
    const RunningSeaPtr sea = running_sea(lasting);
    const auto device = RebuiltSynthesizer::start(sound_vulkan, sea->realization, 1, {}).value();
    FoamMaps foam(std::make_shared<SeaCourse>(sea));
    const std::vector<KeyframeRequest> request{{0, 40'000'000, {Field::foam}}};
    const auto before = foam.synthesize(*device, request).value();
    ASSERT_EQ(foam.ticks_to(0, 40'000'000), 0);
    FoamMaps copy = foam;
    gpu::fault::arm(1, VK_ERROR_DEVICE_LOST, true);
    const auto lost = foam.synthesize(*device, {{0, 41'000'000, {Field::foam}}});
    ASSERT_FALSE(lost);
    EXPECT_TRUE(lost.error().is(DeviceError::foam_lost)) << lost.error().message;
    EXPECT_EQ(device->rebuilds(), 1u);
    EXPECT_GT(copy.ticks_to(0, 40'000'000), 10) << "its map is gone, too";
    EXPECT_FALSE(copy.is_near(0, 40'000'000));
    const auto after = foam.synthesize(*device, request).value();
    EXPECT_TRUE(std::ranges::equal(std::as_const(*after[0]).plane(Field::foam),
                                   std::as_const(*before[0]).plane(Field::foam)));
}

// Histories without decay are not walked: their maps are opened one after the other for the same keyframes, and the device may be
// lost at any call between.
TEST(FoamLost, while_maps_of_two_cascades_are_opened_is_an_error_by_name_wherever_that_is) {
    const RunningSeaPtr sea = running_sea("[foam]\nthreshold = 0.8\ndecay_s = 0\n");
    ASSERT_GE(sea->realization->cascades.size(), 2u);
    const std::vector<KeyframeRequest> both{{0, 40'000'000, {Field::foam}},
                                            {1, 40'000'000, {Field::foam}}};
    int lost = 0;
    for (int call = 1; call <= 12; ++call) {
        const auto device = RebuiltSynthesizer::start(sound_vulkan, sea->realization, 1, {});
        ASSERT_TRUE(device);
        FoamMaps foam(std::make_shared<SeaCourse>(sea));
        gpu::fault::arm(call, VK_ERROR_DEVICE_LOST, true);
        const auto first = foam.synthesize(**device, both);
        gpu::fault::disarm();
        lost += first ? 0 : 1;
        if (!first) {
            EXPECT_TRUE(first.error().is(DeviceError::foam_lost)) << first.error().message;
        }
        EXPECT_TRUE(foam.synthesize(**device, both)) << call;
    }
    EXPECT_GT(lost, 0);
}

// Who asked waits for a start, and gets what a server gives that was never disturbed.
TEST(FoamLost, in_a_server_is_walked_for_anew_for_who_asked) {
    const Demand foam{1u, {Field::foam}};
    Bench bench(lasting), calm(lasting);
    ASSERT_TRUE(bench.fetch({10 * second_us}, foam));
    *bench.failures = 1;
    const auto after = bench.fetch({12 * second_us}, foam);
    ASSERT_TRUE(after) << after.error().message;
    EXPECT_EQ(bench.simulation->counters().device_rebuilds, 1u);
    const auto never = calm.fetch({12 * second_us}, foam);
    ASSERT_TRUE(never);
    ASSERT_EQ(after->size(), never->size());
    for (std::size_t i = 0; i < after->size(); ++i)
        EXPECT_TRUE(
            std::ranges::equal((*after)[i]->plane(Field::foam), (*never)[i]->plane(Field::foam)));
}

// Naive: a core that tries again and again, and says nothing.
TEST(FoamStarts, without_memory_wait_and_say_so_and_then_start) {
    Bench bench(lasting);
    bench.now_us = 10 * second_us;
    constexpr int plenty = 1'000'000;
    bench.no_memory = plenty;
    bench.subscriptions.set(1, {1u, {Field::foam}});
    EXPECT_TRUE(tests::eventually([&] { return bench.warnings > 0; }));
    std::this_thread::sleep_for(2 * StreamedFoam::pause);
    EXPECT_LT(plenty - bench.no_memory, 40) << "a start a pause, and what is due of the stream";
    bench.no_memory = 0;
    const auto there = bench.fetch_current({1u, {Field::foam}});
    ASSERT_FALSE(there.empty());
    EXPECT_TRUE(there[0]->fields.contains(Field::foam));
}

} // namespace
} // namespace seaway::server
