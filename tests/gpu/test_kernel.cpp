// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "gpu/buffer.h"
#include "gpu/commands.h"
#include "gpu/kernel.h"
#include "gpu/spirv.h"
#include "scale_comp.h"
#include "tests/gpu/device_for_tests.h"

namespace seaway::gpu {
namespace {

using testing::HasSubstr;

struct Push {
    float offset[4];
    float factor;
    std::uint32_t count;
};

/// 256 bytes: the coarsest alignment that Vulkan allows a device to ask for.
constexpr std::size_t device_offset_texels = 16;

KernelExpectation scale_expectation() {
    return {.bindings = {{"source", VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER},
                         {"Result", VK_DESCRIPTOR_TYPE_STORAGE_BUFFER}},
            .push_constant_bytes = sizeof(Push),
            .local_size = {64, 1, 1}};
}

TEST(FlatGroups, no_row_is_longer_than_every_device_takes_and_all_invocations_have_one) {
    for (const std::size_t invocations :
         {std::size_t{0}, std::size_t{1}, std::size_t{64}, std::size_t{65},
          64 * FlatGroups::row_max, 64 * FlatGroups::row_max + 1, std::size_t{8192} * 4320,
          std::size_t{4096} * 8192}) {
        const FlatGroups groups = flat_groups(invocations, 64);
        const std::size_t made = std::size_t{64} * groups.a_row * groups.rows;
        EXPECT_LE(groups.a_row, FlatGroups::row_max) << invocations;
        EXPECT_GE(made, std::max<std::size_t>(invocations, 1)) << invocations;
        EXPECT_LT(made - std::max<std::size_t>(invocations, 1), 64u * (groups.rows + 1u))
            << invocations;
    }
    EXPECT_EQ(flat_groups(64 * FlatGroups::row_max, 64).rows, 1u);
    EXPECT_EQ(flat_groups(64 * FlatGroups::row_max + 1, 64).rows, 2u);
}

TEST(Spirv, bindings_push_constants_and_workgroup_are_read_from_the_module) {
    const Result<ShaderInterface> shader = reflect(scale_comp);
    ASSERT_TRUE(shader) << shader.error().message;
    EXPECT_EQ(shader->entry_point, "main");
    EXPECT_EQ(shader->stage, VK_SHADER_STAGE_COMPUTE_BIT);
    ASSERT_EQ(shader->bindings.size(), 2u);
    EXPECT_EQ(shader->bindings[0].name, "source");
    EXPECT_EQ(shader->bindings[0].type, VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER);
    EXPECT_EQ(shader->bindings[1].name, "Result");
    EXPECT_EQ(shader->bindings[1].type, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER);
    EXPECT_EQ(shader->push_constant_bytes, sizeof(Push));
    EXPECT_EQ(shader->local_size, (std::array<std::uint32_t, 3>{64, 1, 1}));
}

TEST(Spirv, a_module_cut_off_anywhere_is_an_error_or_a_smaller_module) {
    const std::vector<std::uint32_t> words(std::begin(scale_comp), std::end(scale_comp));
    for (std::size_t length = 0; length < words.size(); ++length) {
        const std::vector<std::uint32_t> cut(words.begin(),
                                             words.begin() + static_cast<std::ptrdiff_t>(length));
        const Result<ShaderInterface> shader = reflect(cut);
        EXPECT_TRUE(length >= 5 || !shader) << "no header is shorter than 5 words";
    }
}

TEST_F(DeviceTest, a_kernel_computes_from_texels_into_storage) {
    constexpr std::uint32_t count = 1000;
    constexpr std::size_t before = 16 * device_offset_texels; // of something else
    Result<Buffer> source =
        Buffer::create(*device_, "source", before + count * 16, BufferKind::device);
    Result<Buffer> result = Buffer::create(*device_, "result", count * 16, BufferKind::device);
    ASSERT_TRUE(source && result);
    std::vector<float> all(before / 4 + count * 4, -1.0f);
    const std::span<float> values = std::span(all).subspan(before / 4);
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = static_cast<float>(i);
    ASSERT_TRUE(upload(*device_, *source, std::as_bytes(std::span(all))));
    Result<TexelView> view =
        TexelView::create(*device_, *source, VK_FORMAT_R32G32B32A32_SFLOAT, 16, before, count * 16);
    ASSERT_TRUE(view) << view.error().message;
    Result<Kernel> kernel = Kernel::create(*device_, "scale", scale_comp, scale_expectation());
    ASSERT_TRUE(kernel) << kernel.error().message;
    Result<Bindings> bindings = kernel->bind(*device_, {texels(*view), whole(*result)});
    ASSERT_TRUE(bindings) << bindings.error().message;

    const Push push{{1, 2, 3, 4}, 2, count};
    ASSERT_TRUE(run_once(*device_, [&](Commands& commands) {
        commands.dispatch(*kernel, *bindings, std::as_bytes(std::span(&push, 1)),
                          (count + 63) / 64);
        commands.barrier(Stage::compute, Stage::copy);
        commands.barrier(Stage::compute, Stage::host);
    }));
    std::vector<float> back(values.size());
    ASSERT_TRUE(download(*device_, *result, std::as_writable_bytes(std::span(back))));
    for (std::size_t i = 0; i < back.size(); ++i) // exact: small integers
        ASSERT_EQ(back[i], 2 * values[i] + push.offset[i % 4]) << i;
}

// 128 MiB and 64 KiB are all that Vulkan 1.3 promises.
TEST(Bindings, of_a_buffer_that_is_longer_than_a_shader_may_see_are_refused_by_name) {
    VkPhysicalDeviceLimits limits{};
    limits.maxStorageBufferRange = 1u << 27;
    limits.maxUniformBufferRange = 1u << 16;
    const ShaderBinding bindings[] = {
        {.type = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, .name = "View"},
        {.binding = 1, .type = VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER, .name = "maps"},
        {.binding = 2, .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, .name = "GradientMaps"}};
    const auto checked = [&](VkDeviceSize uniform_bytes, VkDeviceSize storage_bytes) {
        const Resource resources[] = {{.buffer = {VK_NULL_HANDLE, 0, uniform_bytes}},
                                      {},
                                      {.buffer = {VK_NULL_HANDLE, 0, storage_bytes}}};
        const Result<void> fit = check_ranges(bindings, resources, limits);
        return fit ? std::string("fine") : fit.error().message;
    };
    EXPECT_EQ(checked(1u << 16, 1u << 27), "fine");
    EXPECT_EQ(checked(1u << 16, (1u << 27) + 16),
              "\"GradientMaps\" of 134217744 bytes: a shader may see 134217728");
    EXPECT_EQ(checked((1u << 16) + 4, 16), "\"View\" of 65540 bytes: a shader may see 65536");
}

TEST_F(DeviceTest, more_groups_a_side_than_the_device_takes_are_a_mistake_of_ours) {
    GTEST_FLAG_SET(death_test_style, "threadsafe"); // the driver has threads
    const auto source = Buffer::create(*device_, "source", 16, BufferKind::device).value();
    const auto result = Buffer::create(*device_, "result", 16, BufferKind::device).value();
    const auto view =
        TexelView::create(*device_, source, VK_FORMAT_R32G32B32A32_SFLOAT, 16, 0, 16).value();
    const auto kernel = Kernel::create(*device_, "scale", scale_comp, scale_expectation()).value();
    const auto bindings = kernel.bind(*device_, {texels(view), whole(result)}).value();
    const Push push{{}, 0, 0}; // nothing is computed
    Commands commands = Commands::create(*device_).value();
    ASSERT_TRUE(commands.begin());
    const auto& most = device_->limits().maxComputeWorkGroupCount;
    for (int side = 0; side < 3; ++side) {
        if (most[side] == ~std::uint32_t{0})
            continue;
        std::uint32_t groups[] = {1, 1, 1};
        groups[side] = most[side] + 1;
        EXPECT_DEATH(commands.dispatch(kernel, bindings, std::as_bytes(std::span(&push, 1)),
                                       groups[0], groups[1], groups[2]),
                     "more groups than the device takes");
    }
    EXPECT_TRUE(commands.end());
}

TEST_F(DeviceTest, a_kernel_that_differs_from_its_program_is_refused_with_both_names) {
    KernelExpectation expected = scale_expectation();
    expected.bindings[1].name = "maps";
    Result<Kernel> kernel = Kernel::create(*device_, "scale", scale_comp, expected);
    ASSERT_FALSE(kernel);
    EXPECT_THAT(kernel.error().message, HasSubstr("\"scale\""));
    EXPECT_THAT(kernel.error().message, HasSubstr("\"Result\""));
    EXPECT_THAT(kernel.error().message, HasSubstr("\"maps\""));

    expected = scale_expectation();
    expected.push_constant_bytes = 16;
    EXPECT_THAT(Kernel::create(*device_, "scale", scale_comp, expected).error().message,
                HasSubstr("24 bytes in the shader and 16"));
    expected = scale_expectation();
    expected.local_size = {32, 1, 1};
    EXPECT_THAT(Kernel::create(*device_, "scale", scale_comp, expected).error().message,
                HasSubstr("64x1x1 in the shader and 32x1x1"));
    // In another set of descriptors, under the same numbers and names.
    std::vector<std::uint32_t> moved(std::begin(scale_comp), std::end(scale_comp));
    constexpr std::uint32_t decorate = 4u << 16 | 71, descriptor_set = 34;
    int sets = 0;
    for (std::size_t i = 5; i + 3 < moved.size(); i += moved[i] >> 16)
        if (moved[i] == decorate && moved[i + 2] == descriptor_set && ++sets > 0)
            moved[i + 3] = 1;
    ASSERT_EQ(sets, 2);
    EXPECT_FALSE(Kernel::create(*device_, "scale", moved, scale_expectation()));
    expected = scale_expectation();
    expected.bindings.pop_back();
    EXPECT_FALSE(Kernel::create(*device_, "scale", scale_comp, expected));
}

} // namespace
} // namespace seaway::gpu
