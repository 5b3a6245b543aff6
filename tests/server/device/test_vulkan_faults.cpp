// SPDX-License-Identifier: Apache-2.0
// Every fallible Vulkan call, failed once each: the synthesizer says so and leaves nothing behind.
#include <memory>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "gpu/call.h"
#include "gpu/instance.h"
#include "server/device/vulkan_synthesizer.h"
#include "tests/server/device/random_sea.h"

namespace seaway::server {
namespace {

using testing::HasSubstr;

/// A tick in which strains break.
constexpr sea::FoamTick some_tick{0.9f, 0.0f, 1.0f, 1.0f, 1.0f,  0.01f, 0.0f, 0.0f,
                                  0.0f, 0.0f, 0.0f, 0.0f, 1e-4f, 0.5f,  1.0f, 0.0f};

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
    /// Drivers are loaded as long as anybody has an instance: to load them anew for each of 700 devices took a third of the time.
    static void SetUpTestSuite() { holds_drivers_ = *gpu::Instance::create(true, {}); }
    static void TearDownTestSuite() { holds_drivers_.reset(); }
    void TearDown() override { gpu::fault::disarm(); }

  private:
    static inline std::unique_ptr<gpu::Instance> holds_drivers_;
};
INSTANTIATE_TEST_SUITE_P(
    Results, VulkanFaults,
    testing::Values(Fault{VK_ERROR_DEVICE_LOST, "VK_ERROR_DEVICE_LOST", true, false},
                    Fault{VK_ERROR_DEVICE_LOST, "VK_ERROR_DEVICE_LOST", true, true},
                    Fault{VK_ERROR_OUT_OF_DEVICE_MEMORY, "VK_ERROR_OUT_OF_DEVICE_MEMORY", false,
                          true}),
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
    for (std::uint64_t n = 1; n <= calls; ++n) {
        gpu::fault::arm(n, GetParam().result, GetParam().persistent);
        const Result<void> sailed = sail(options, random);
        ASSERT_FALSE(sailed) << "call " << n << " of " << calls;
        EXPECT_THAT(sailed.error().message, HasSubstr(GetParam().name)) << "call " << n;
    }
    EXPECT_EQ(gpu::Instance::all_validation_messages(), messages)
        << "objects left behind or used when gone";
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
