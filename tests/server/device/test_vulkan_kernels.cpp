// SPDX-License-Identifier: Apache-2.0
// Below the synthesizer: the self-check, the packing, and that no field disturbs another.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "server/device/vulkan_batch.h"
#include "server/device/vulkan_check.h"
#include "server/device/vulkan_fields.h"
#include "server/device/vulkan_foam.h"
#include "tests/gpu/held_drivers.h"
#include "tests/server/device/random_sea.h"

namespace seaway::server {
namespace {

using sea::Field;

class VulkanKernels : public testing::Test {
  protected:
    VulkanKernels() : device_(std::move(*gpu::Device::create({.validation = true}))) {}
    void TearDown() override {
        EXPECT_THAT(device_->validation().validation_messages(), testing::IsEmpty());
    }

    /// Maps of one job, in the order of the packing.
    std::vector<std::vector<float>> planes(const shaders::Transform& transform,
                                           const sea::CascadeModes& cascade, sea::FieldSet fields) {
        Result<SynthesisKernels> kernels = SynthesisKernels::create(*device_, transform);
        EXPECT_TRUE(kernels) << kernels.error().message;
        auto batch = std::move(*VulkanBatch::create(*device_, *kernels, 1));
        const sea::CascadeModes* const cascades[] = {&cascade};
        EXPECT_TRUE(batch->upload(cascades));
        const Packing packing = pack(fields);
        const VulkanBatch::Job job{0, 1'000'000};
        EXPECT_TRUE(batch->run({&job, 1}, packing, {}));
        std::vector<std::vector<float>> read(static_cast<std::size_t>(packing.fields),
                                             std::vector<float>(cascade.h0.size()));
        for (std::size_t plane = 0; plane < read.size(); ++plane)
            batch->read_map(VulkanBatch::own, 0, static_cast<int>(plane), read[plane]);
        return read;
    }

    std::unique_ptr<gpu::Device> device_;
};

TEST_F(VulkanKernels, the_device_has_the_subgroups_that_this_test_is_run_for) {
    const char* width = std::getenv("LP_NATIVE_VECTOR_WIDTH"); // bits
    if (width != nullptr && device_->info().is_cpu()) {
        EXPECT_EQ(device_->info().subgroup_size, static_cast<unsigned>(std::atoi(width)) / 32);
    }
}

TEST_F(VulkanKernels, a_device_that_computes_wrongly_is_refused_with_field_and_values) {
    // Kernels that leave out what lies beyond the band, passed off as ones for all modes.
    for (const shaders::Transform* honest : fitting_transforms(device_->info(), 128, true)) {
        shaders::Transform lying = *honest;
        lying.band_limited = false;
        Result<SynthesisKernels> kernels = SynthesisKernels::create(*device_, lying);
        ASSERT_TRUE(kernels) << kernels.error().message;
        const Result<void> checked = check_device(*device_, *kernels);
        ASSERT_FALSE(checked) << honest->design;
        EXPECT_TRUE(checked.error().is(DeviceError::cannot_do_this_sea));
        EXPECT_THAT(checked.error().message, testing::HasSubstr("size 128, height at"));
    }
}

/// The program that rounds, with another number in place of a constant.
std::vector<std::uint32_t> rounding_with(std::uint32_t constant, std::uint32_t instead) {
    constexpr std::size_t header_words = 5;
    constexpr std::uint32_t op_constant = 43; // type, result, value
    const auto honest = shaders::round().spirv;
    std::vector<std::uint32_t> words(honest.begin(), honest.end());
    int found = 0;
    for (std::size_t i = header_words; i < words.size(); i += words[i] >> 16)
        if ((words[i] & 0xffff) == op_constant && words[i + 3] == constant) {
            words[i + 3] = instead;
            ++found;
        }
    EXPECT_GT(found, 0);
    return words;
}

TEST_F(VulkanKernels, a_device_that_rounds_wrongly_is_refused_where_maps_may_be_rounded) {
    const auto staged = gpu::Device::create({.validation = true, .staged = true}).value();
    const shaders::Transform& design = *fitting_transforms(staged->info(), 128, true).front();
    const gpu::KernelExpectation expected{
        .bindings = {{"maps", VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER},
                     {"scales", VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER},
                     {"Rounded", VK_DESCRIPTOR_TYPE_STORAGE_BUFFER}},
        .push_constant_bytes = sizeof(shaders::RoundPush),
        .local_size = {shaders::synthesis_workgroup, 1, 1}};
    constexpr auto largest = static_cast<float>(shaders::rounded_steps_max);
    const std::pair<std::vector<std::uint32_t>, const char*> wrong[] = {
        {rounding_with(16, 0), "size 128, height rounded at"}, // both neighbours in the lower half
        {rounding_with(std::bit_cast<std::uint32_t>(largest), std::bit_cast<std::uint32_t>(1e30f)),
         "size 128, which rounded maps"}};
    for (const auto& [program, message] : wrong) {
        SynthesisKernels kernels = SynthesisKernels::create(*staged, design).value();
        ASSERT_TRUE(check_device(*staged, kernels));
        kernels.round = gpu::Kernel::create(*staged, "round", program, expected).value();
        const Result<void> checked = check_device(*staged, kernels);
        ASSERT_FALSE(checked) << message;
        EXPECT_TRUE(checked.error().is(DeviceError::cannot_do_this_sea));
        EXPECT_THAT(checked.error().message, testing::HasSubstr(message));
    }
    EXPECT_THAT(staged->validation().validation_messages(), testing::IsEmpty());
}

TEST_F(VulkanKernels, foam_maps_are_no_more_than_are_bound_at_once) {
    constexpr int size = 64, most = 5;
    VulkanFoam foam(*device_, size, most * size * size * sizeof(float) + 1);
    std::vector<FoamMapPtr> maps;
    for (int i = 0; i < most; ++i)
        maps.push_back(foam.open(nullptr).value());
    EXPECT_LE(foam.histories().size_bytes(), most * size * size * sizeof(float));
    const Result<FoamMapPtr> more = foam.open(maps[0].get());
    ASSERT_FALSE(more);
    EXPECT_TRUE(more.error().is(DeviceError::out_of_memory));
    maps.pop_back();
    EXPECT_TRUE(foam.open(maps[0].get())) << "there is a place again";
}

// 37 points of every field against the double sum of their modes: what a device is asked before it serves. The test list runs it with
// subgroups of 4, 8 and 16 lanes, a hardware GPU with 32.
TEST_F(VulkanKernels, every_design_that_fits_the_device_computes_rightly) {
    std::set<std::string> designs;
    for (const int size : {64, 128, 256, 512, 1024, 2048})
        for (const bool band_limited : {true, false})
            for (const shaders::Transform* transform :
                 fitting_transforms(device_->info(), size, band_limited, true)) {
                const Result<SynthesisKernels> kernels =
                    SynthesisKernels::create(*device_, *transform);
                ASSERT_TRUE(kernels) << kernels.error().message;
                const Result<void> checked = check_device(*device_, *kernels);
                EXPECT_TRUE(checked) << transform->design << ": " << checked.error().message;
                designs.emplace(transform->design);
            }
    const std::uint32_t lanes = device_->info().subgroup_size;
    EXPECT_EQ(designs.contains("T8"), lanes >= 8);
    EXPECT_EQ(designs.contains("T16"), lanes >= 16);
    EXPECT_EQ(designs.contains("T32"), lanes >= 32);
    EXPECT_TRUE(designs.contains("W") && designs.contains("G"));
}

// Hard case C4: of two fields that share a source, the second is kx times the first; the transform
// along x is its own, so its rounding is relative to itself, however large the first one is.
TEST_F(VulkanKernels, a_small_field_survives_beside_one_ten_thousand_times_larger) {
    const RandomSea random(128, 2e5, 2);
    const sea::FieldSet fields{Field::height, Field::slope_x};
    const std::vector<GridNode> nodes = random_nodes(128, 100);
    const FieldSums sums(random.cascade(), fields, 1'000'000, nodes);
    const double slope_rms = sums.rms(Field::slope_x);
    ASSERT_GT(sums.rms(Field::height), 1e4 * slope_rms);
    for (const shaders::Transform* transform : fitting_transforms(device_->info(), 128, true)) {
        const auto read = planes(*transform, random.cascade(), fields);
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            const auto x = static_cast<std::size_t>(nodes[i].first),
                       y = static_cast<std::size_t>(nodes[i].second);
            EXPECT_NEAR(read[1][y * 128 + x], sums.at(Field::slope_x, i), 1e-5 * slope_rms)
                << transform->design;
        }
    }
}

TEST(FittingTransforms, gpus_get_design_g_subgroups_that_hold_whole_lines_t_and_all_devices_w) {
    const auto designs = [](VkPhysicalDeviceType type, std::uint32_t subgroup_size, int size,
                            bool to_be_tried = false, bool shuffle = true) {
        gpu::DeviceInfo info;
        info.type = type;
        info.subgroup_size = info.subgroup_size_min = info.subgroup_size_max = subgroup_size;
        info.subgroup_shuffle = shuffle;
        std::string text;
        for (const shaders::Transform* fitting : fitting_transforms(info, size, true, to_be_tried))
            text += std::string(fitting->design) + " ";
        return text;
    };
    constexpr VkPhysicalDeviceType cpu = VK_PHYSICAL_DEVICE_TYPE_CPU,
                                   gpu = VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU;
    for (const std::uint32_t lanes : {8u, 16u, 32u, 64u})
        for (const int size : {128, 256, 512})
            EXPECT_EQ(designs(cpu, lanes, size).substr(0, 3), "T8 ") << lanes;
    EXPECT_EQ(designs(cpu, 4, 256), "W ");
    EXPECT_EQ(designs(cpu, 128, 256), "W ") << "more than a workgroup";
    EXPECT_EQ(designs(cpu, 32, 256, false, false), "W ");
    EXPECT_EQ(designs(cpu, 8, 1024), "W ");
    EXPECT_EQ(designs(cpu, 8, 2048), "W ");
    EXPECT_EQ(designs(cpu, 16, 1024), "T16 W ");
    EXPECT_EQ(designs(cpu, 8, 256, true), "T8 W G ") << "a processor may try";
    for (const std::uint32_t lanes : {32u, 64u}) {
        EXPECT_EQ(designs(gpu, lanes, 256), "G T8 W ");
        EXPECT_EQ(designs(gpu, lanes, 512), "G T16 W ");
        EXPECT_EQ(designs(gpu, lanes, 1024), "G W ")
            << "64 modes a lane are too many unless measured";
        EXPECT_EQ(designs(gpu, lanes, 512, true), "G T8 T16 W ");
        EXPECT_EQ(designs(gpu, lanes, 1024, true), "G T16 W ");
        EXPECT_EQ(designs(gpu, lanes, 2048, true), "T32 W ");
    }
}

TEST(Packing, every_field_has_a_map_and_fields_that_differ_by_kx_share_a_source) {
    const Packing all = pack(sea::linear_fields);
    EXPECT_EQ(all.fields, sea::linear_field_count);
    EXPECT_LT(all.sources, all.fields);
    std::vector<int> planes(sea::linear_field_count);
    std::iota(planes.begin(), planes.end(), 0);
    planes.resize(sea::field_count, -1); // derived fields have none
    EXPECT_THAT(all.plane, testing::UnorderedElementsAreArray(planes));
    const Packing two = pack({Field::height, Field::slope_x});
    EXPECT_EQ(two.sources, 1);
    EXPECT_EQ(two.fields, 2);
    EXPECT_EQ(two.plane_of(Field::slope_x), 1);
    EXPECT_EQ(two.plane_of(Field::slope_y), -1);
    EXPECT_EQ(pack({Field::height, Field::height_rate}).sources, 2);
    EXPECT_EQ(pack({}).fields, 0);
}

// Two rows of a real map are one complex line: N/2 of them lie between the passes, of which a pass may leave four numbers more
// a row.
TEST(Packing, what_lies_between_passes_is_half_a_complex_map_of_a_field) {
    for (const shaders::Transform& transform : shaders::synthesis_transforms()) {
        const auto n = static_cast<std::uint32_t>(transform.size);
        EXPECT_GE(transform.scratch_complexes, n * n / 2) << transform.design << " " << n;
        EXPECT_LE(transform.scratch_complexes, n * n / 2 + 4 * n) << transform.design << " " << n;
        for (const shaders::Pass& pass : transform.passes)
            if (pass.row_texels > 0) {
                EXPECT_LE(pass.row_texels * 2 * (n / 2), transform.scratch_complexes)
                    << pass.shader.name;
            }
    }
}

/// Sinh, Cosh and Tanh of GLSL.std.450, which a device may make of exponentials that overflow.
int hyperbolic_functions(const shaders::Shader& shader) {
    int found = 0;
    for (std::size_t at = 5; at < shader.spirv.size(); at += shader.spirv[at] >> 16) {
        const std::uint32_t extended = 12, sinh = 19, tanh = 21;
        if ((shader.spirv[at] & 0xffff) == extended)
            found += shader.spirv[at + 4] >= sinh && shader.spirv[at + 4] <= tanh;
    }
    return found;
}

TEST(Kernels, a8_have_no_hyperbolic_function) {
    int modules = 0;
    const auto look = [&](const shaders::Shader& shader) {
        EXPECT_EQ(hyperbolic_functions(shader), 0) << shader.name;
        ++modules;
    };
    for (const shaders::Transform& transform : shaders::synthesis_transforms())
        for (const shaders::Pass& pass : transform.passes)
            look(pass.shader);
    for (const shaders::Shader& shader :
         {shaders::jacobian(), shaders::foam(), shaders::round(), shaders::copy(), shaders::peak()})
        look(shader);
    EXPECT_GT(modules, 50);
    // OpExtInst of an instruction set 1: Tanh of 2.
    const std::uint32_t words[] = {0x07230203, 0x10600, 0, 9, 0, 6u << 16 | 12, 3, 4, 1, 21, 2};
    EXPECT_EQ(hyperbolic_functions({"some", words}), 1);
}

TEST(Packing, what_maps_are_made_of_stands_apart_where_it_is_told_to) {
    const sea::FieldSet strains{Field::strain_xx, Field::strain_yy, Field::strain_xy};
    const Packing next_to = pack(strains, {Field::jacobian}),
                  apart = pack(strains, {Field::jacobian}, 40);
    EXPECT_EQ(apart.map_of(Field::jacobian), 0);
    EXPECT_EQ(apart.maps, next_to.maps) << "as many as before";
    for (const Field strain : strains) {
        EXPECT_EQ(apart.map_of(strain), next_to.map_of(strain) + 40);
        const auto row =
            4 * (shaders::first_map_texel + static_cast<std::size_t>(apart.plane_of(strain)));
        EXPECT_EQ(apart.rows[row], static_cast<float>(apart.map_of(strain)))
            << "what the kernels read";
    }
}

} // namespace
} // namespace seaway::server
