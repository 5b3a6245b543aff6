// SPDX-License-Identifier: Apache-2.0
// Below the synthesizer: the self-check, and what two packed fields do to each other.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "server/simulation/vulkan_batch.h"
#include "server/simulation/vulkan_check.h"
#include "server/simulation/vulkan_fields.h"
#include "tests/server/random_sea.h"

namespace seaway::server {
namespace {

using sea::Field;

class VulkanKernels : public testing::Test {
  protected:
    VulkanKernels() : device_(std::move(*gpu::Device::create({.validation = true}))) {}
    void TearDown() override {
        EXPECT_THAT(device_->validation().validation_messages(), testing::IsEmpty());
    }

    /// Planes of one job, by position: also those that no field was put in.
    std::vector<std::vector<float>> planes(const shaders::Transform& transform,
                                           const sea::CascadeModes& cascade, sea::FieldSet fields) {
        Result<SynthesisKernels> kernels = SynthesisKernels::create(*device_, transform);
        EXPECT_TRUE(kernels) << kernels.error().message;
        auto batch = std::move(*VulkanBatch::create(*device_, *kernels, 1));
        const sea::CascadeModes* const cascades[] = {&cascade};
        EXPECT_TRUE(batch->upload(cascades));
        const Packing packing = pack(fields);
        const VulkanBatch::Job job{0, 1'000'000};
        EXPECT_TRUE(batch->run({&job, 1}, packing, nullptr));
        std::vector<std::vector<float>> read(2 * static_cast<std::size_t>(packing.slots),
                                             std::vector<float>(cascade.h0.size()));
        for (std::size_t plane = 0; plane < read.size(); ++plane)
            batch->read_plane(0, static_cast<int>(plane), read[plane]);
        return read;
    }

    std::unique_ptr<gpu::Device> device_;
};

double rms(const std::vector<float>& plane) {
    double sum = 0;
    for (const float value : plane)
        sum += static_cast<double>(value) * static_cast<double>(value);
    return std::sqrt(sum / static_cast<double>(plane.size()));
}

TEST_F(VulkanKernels, a_device_that_computes_wrongly_is_refused_with_field_and_values) {
    // Kernels that leave out what lies beyond the band, passed off as ones for all modes.
    for (const shaders::Transform* honest : fitting_transforms(device_->info(), 64, true)) {
        shaders::Transform lying = *honest;
        lying.band_limited = false;
        Result<SynthesisKernels> kernels = SynthesisKernels::create(*device_, lying);
        ASSERT_TRUE(kernels) << kernels.error().message;
        const Result<void> checked = check_device(*device_, *kernels);
        ASSERT_FALSE(checked) << honest->design;
        EXPECT_EQ(checked.error().code, computes_wrongly);
        EXPECT_THAT(checked.error().message, testing::HasSubstr("size 64, height at"));
    }
}

// Hard cases C4 and C11: what has no field is the error of the fields beside it.
TEST_F(VulkanKernels, the_half_without_a_field_stays_empty) {
    const RandomSea random(128, 300.0, 1);
    const sea::FieldSet fields{Field::height, Field::displacement_x, Field::slope_y};
    for (const shaders::Transform* transform : fitting_transforms(device_->info(), 128, true)) {
        const auto read = planes(*transform, random.cascade(), fields);
        ASSERT_EQ(read.size(), 4u);
        EXPECT_GT(rms(read[2]), 0.01);
        EXPECT_LT(rms(read[3]), 1e-6 * rms(read[2])) << transform->design;
    }
}

// Hard case C4: rounding is relative to the larger partner; of a ratio of 1e4 a hundredth is left.
TEST_F(VulkanKernels, a_small_field_survives_beside_one_ten_thousand_times_larger) {
    const RandomSea random(64, 1e5, 2);
    const sea::FieldSet fields{Field::height, Field::slope_x};
    const FieldSum height(random.cascade(), Field::height, 1'000'000);
    const FieldSum slope(random.cascade(), Field::slope_x, 1'000'000);
    ASSERT_GT(height.rms(), 1e4 * slope.rms());
    for (const shaders::Transform* transform : fitting_transforms(device_->info(), 64, true)) {
        const auto read = planes(*transform, random.cascade(), fields);
        for (const auto& [x, y] : random_nodes(64, 100)) {
            const std::size_t at = static_cast<std::size_t>(y) * 64 + static_cast<std::size_t>(x);
            EXPECT_NEAR(read[1][at], slope.at(x, y), 1e-2 * slope.rms()) << transform->design;
        }
    }
}

TEST(Packing, a_list_of_fields_takes_half_as_many_transforms_and_keeps_the_tables_order) {
    for (std::uint32_t count = 0; count <= sea::linear_field_count; ++count) {
        const Packing packing = pack(sea::FieldSet::from_bits((1u << count) - 1));
        EXPECT_EQ(packing.slots, static_cast<int>((count + 1) / 2));
        EXPECT_EQ(packing.rows.size(),
                  static_cast<std::size_t>(packing.slots) * 4 * shaders::slot_row_texels);
        for (std::uint32_t i = 0; i < count; ++i)
            EXPECT_EQ(packing.plane[i], static_cast<int>(i));
    }
}

} // namespace
} // namespace seaway::server
