// SPDX-License-Identifier: Apache-2.0
// Every fallible Vulkan call, failed once each: the synthesizer says so and leaves nothing behind.
#include <memory>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "gpu/call.h"
#include "gpu/instance.h"
#include "server/device/vulkan_synthesizer.h"
#include "tests/gpu/held_drivers.h"
#include "tests/server/device/random_sea.h"

namespace seaway::server {
namespace {

using testing::HasSubstr;

/// Foam on a keyframe: more maps than there is room for at first, one of them a copy.
Result<void> foam(Synthesizer& device) {
    std::vector<FoamMapPtr> maps;
    for (int i = 0; i < 5; ++i) {
        SEAWAY_TRY_LET(FoamMapPtr map, device.open_foam(64, i == 0 ? nullptr : maps[0].get()));
        maps.push_back(std::move(map));
    }
    const FoamTurn turn{maps.back().get(), some_tick, {}};
    const KeyframeRequest request{0, 0, {sea::Field::height, sea::Field::foam}, 1, &turn};
    SEAWAY_TRY(device.synthesize({&request, 1}));
    return {};
}

/// From nothing to a keyframe; the first error on the way.
Result<void> sail(const VulkanOptions& options, const RandomSea& random) {
    Result<std::unique_ptr<VulkanSynthesizer>> made = make_vulkan_synthesizer(options);
    if (!made)
        return made.error();
    SEAWAY_TRY((*made)->set_sea(random.realization(), 1));
    // Runs of which each is under way when the next is started; where memory is not read in place some are rounded.
    const float fine = 1e-6f, coarse = 1e-3f; // the first needs more than 16 bits
    const KeyframeRequest requests[] = {{0, 0, {sea::Field::height, sea::Field::jacobian}},
                                        {0, 0, {sea::Field::slope_x}, 1, nullptr, {&coarse, 1}},
                                        {0, 0, {sea::Field::height}, 1, nullptr, {&fine, 1}}};
    const Result<std::vector<NewKeyframePtr>> keyframes = (*made)->synthesize(requests);
    if (!keyframes)
        return keyframes.error();
    return foam(**made);
}

struct Fault {
    VkResult result;
    const char* name;
    bool persistent; ///< a lost device stays lost
    bool staged;
};

class VulkanFaults : public testing::TestWithParam<Fault> {
  protected:
    void TearDown() override { gpu::fault::disarm(); }
};
INSTANTIATE_TEST_SUITE_P(
    Results, VulkanFaults,
    testing::Values(
        Fault{VK_ERROR_DEVICE_LOST, "VK_ERROR_DEVICE_LOST", true, false},
        Fault{VK_ERROR_DEVICE_LOST, "VK_ERROR_DEVICE_LOST", true, true},
        Fault{VK_ERROR_OUT_OF_DEVICE_MEMORY, "VK_ERROR_OUT_OF_DEVICE_MEMORY", false, false},
        Fault{VK_ERROR_OUT_OF_DEVICE_MEMORY, "VK_ERROR_OUT_OF_DEVICE_MEMORY", false, true}),
    [](const auto& fault) {
        return std::string(fault.param.name) + (fault.param.staged ? "_staged" : "");
    });

TEST_P(VulkanFaults, any_call_that_fails_is_an_error_that_names_it_and_leaks_nothing) {
    const RandomSea random(64, 200.0, 1);
    const VulkanOptions options{.validation = true, .staged = GetParam().staged};
    constexpr std::uint64_t never = ~std::uint64_t{0};
    gpu::fault::arm(never, GetParam().result);
    ASSERT_TRUE(sail(options, random)) << "the calm case";
    const std::uint64_t calls = gpu::fault::calls();
    ASSERT_GT(calls, 50u);
    const std::size_t messages = gpu::Instance::all_validation_messages();
    std::uint64_t done_without =
        0; // memory for runs that others follow, which go one by one, to round maps, or for all maps that may be held
    for (std::uint64_t n = 1; n <= calls; ++n) {
        gpu::fault::arm(n, GetParam().result, GetParam().persistent);
        const Result<void> sailed = sail(options, random);
        if (sailed && !GetParam().persistent) {
            ++done_without;
            continue;
        }
        ASSERT_FALSE(sailed) << "call " << n << " of " << calls;
        EXPECT_THAT(sailed.error().message, HasSubstr(GetParam().name)) << "call " << n;
    }
    EXPECT_EQ(gpu::Instance::all_validation_messages(), messages)
        << "objects left behind or used when gone";
    EXPECT_LT(done_without, calls / 4);
    EXPECT_EQ(done_without > 0, !GetParam().persistent);
}

// Naive: what a run that others follow has for itself is not to be had, so that nothing is made; or it is taken for the end of the
// device, three rebuilds long, after which it is not to be had either.
TEST(VulkanFaultsOnce,
     where_memory_is_lacking_runs_go_one_by_one_or_are_refused_and_the_device_goes_on) {
    const RandomSea random(64, 200.0, 3);
    const float coarse = 1e-3f;
    const KeyframeRequest requests[] = {
        {0, 0, {sea::Field::height}},
        {0, 1'000'000, {sea::Field::slope_x}},
        {0, 2'000'000, {sea::Field::height}, 1, nullptr, {&coarse, 1}}};
    const auto made = [&] {
        auto synthesizer = *make_vulkan_synthesizer({.staged = true});
        EXPECT_TRUE(synthesizer->set_sea(random.realization(), 1));
        return synthesizer;
    };
    const auto right = *made()->synthesize(requests);
    const KeyframeRequest exact{0, 2'000'000, {sea::Field::height}}; // where it cannot be rounded
    const auto not_rounded = *made()->synthesize({&exact, 1});
    int refused = 0, gone_on = 0;
    for (std::uint64_t n = 1;; ++n) {
        const auto synthesizer = made();
        gpu::fault::arm(n, VK_ERROR_OUT_OF_DEVICE_MEMORY);
        const auto first = synthesizer->synthesize(requests);
        const bool all_made = gpu::fault::calls() < n;
        gpu::fault::disarm();
        if (all_made)
            break;
        if (first) {
            ++gone_on;
        } else {
            ++refused;
            EXPECT_TRUE(first.error().is(DeviceError::out_of_memory)) << n << first.error().message;
        }
        const auto again = first ? first : synthesizer->synthesize(requests);
        ASSERT_TRUE(again) << n << again.error().message;
        for (std::size_t i = 0; i < right.size(); ++i) {
            const bool as_it_is = i == 2 && (*again)[i]->rounded.empty();
            EXPECT_EQ((*again)[i]->values, (as_it_is ? not_rounded[0] : right[i])->values) << n;
        }
    }
    EXPECT_GT(gone_on, 5) << "what the ring is made of";
    EXPECT_GT(refused, 5);
}

TEST(VulkanFaultsOnce, where_memory_is_lacking_for_foam_that_is_refused) {
    const RandomSea random(64, 200.0, 4);
    const auto synthesizer = *make_vulkan_synthesizer({.staged = true});
    ASSERT_TRUE(synthesizer->set_sea(random.realization(), 1));
    const FoamMapPtr map = *synthesizer->open_foam(64, nullptr);
    const FoamTurn turn{map.get(), some_tick, {}};
    const KeyframeRequest request{0, 0, {sea::Field::height, sea::Field::foam}, 1, &turn};
    ASSERT_TRUE(synthesizer->synthesize({&request, 1}));
    gpu::fault::arm(3, VK_ERROR_OUT_OF_DEVICE_MEMORY);
    const auto lost = synthesizer->synthesize({&request, 1});
    gpu::fault::disarm();
    ASSERT_FALSE(lost);
    EXPECT_TRUE(lost.error().is(DeviceError::out_of_memory));
    gpu::fault::arm(1, VK_ERROR_OUT_OF_DEVICE_MEMORY);
    const auto closed = synthesizer->open_foam(64, nullptr);
    gpu::fault::disarm();
    ASSERT_FALSE(closed);
    EXPECT_TRUE(closed.error().is(DeviceError::out_of_memory)) << "another history is refused";
}

TEST(VulkanFaultsOnce, a_synthesizer_whose_submission_failed_goes_on_when_the_device_does) {
    const RandomSea random(64, 200.0, 2);
    auto synthesizer = make_vulkan_synthesizer({.validation = true});
    ASSERT_TRUE(synthesizer) << synthesizer.error().message;
    ASSERT_TRUE((*synthesizer)->set_sea(random.realization(), 1));
    const KeyframeRequest request{0, 5'000'000, {sea::Field::height}};
    const auto before = (*synthesizer)->synthesize({&request, 1});
    ASSERT_TRUE(before);
    for (std::uint64_t n = 1; n <= 4; ++n) { // begin, end, submit, wait
        gpu::fault::arm(n, VK_ERROR_OUT_OF_HOST_MEMORY);
        EXPECT_FALSE((*synthesizer)->synthesize({&request, 1})) << n;
        gpu::fault::disarm();
        const auto after = (*synthesizer)->synthesize({&request, 1});
        ASSERT_TRUE(after) << after.error().message;
        EXPECT_EQ(after->front()->values, before->front()->values);
    }
    EXPECT_THAT((*synthesizer)->validation_messages(), testing::IsEmpty());
}

} // namespace
} // namespace seaway::server
