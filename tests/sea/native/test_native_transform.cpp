// SPDX-License-Identifier: Apache-2.0
#include "sea/native/native_runner.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <gtest/gtest.h>

#include "base/worse.h"
#include "tests/sea/native/double_sum.h"
#include "tests/sea/native/every_transform.h"
#include "tests/sea/native/random_modes.h"

namespace seaway::sea {
namespace {

constexpr FieldSet all_made = linear_fields | FieldSet{Field::jacobian};

std::vector<float> synthesize(const CascadeModes& modes, FieldSet fields, TimeUs t_us,
                              Instructions instructions = best_instructions(), int threads = 2,
                              Choppiness choppiness = {}) {
    const auto cascade = NativeTransform::create(modes, choppiness, instructions);
    const auto n = static_cast<std::size_t>(modes.spec.size);
    std::vector<float> planes(static_cast<std::size_t>(fields.size()) * n * n, NAN);
    const NativeTask task{&*cascade, t_us, fields, planes};
    NativeRunner(threads).run({&task, 1});
    return planes;
}

double rms(std::span<const double> values) {
    double sum = 0;
    for (double v : values)
        sum += v * v;
    return std::sqrt(sum / static_cast<double>(values.size()));
}

/// Largest error of a map over four times its rms: for the height that is the error over Hs.
double worst_error(std::span<const float> map, std::span<const double> truth, std::size_t n,
                   std::size_t stride) {
    double worst = 0;
    for (std::size_t i = 0; i < truth.size(); ++i)
        worst = worse(worst, std::abs(map[i / n * stride * n + i % n] - truth[i]));
    return worst / (4 * rms(truth));
}

// A transform of N^2 points in single precision has a relative rms error of about 2^-24 times the
// root of 2 log2 N, 2.7e-7 at N = 1024; stored amplitudes and the sine add 1e-7. The largest of N^2
// such errors is five times their rms: 1.5e-6 rms, 4e-7 of 4 rms. The bound leaves a factor of two.
constexpr double tolerance = 1e-6;

class EverySize : public testing::TestWithParam<TransformCase> {
  protected:
    static constexpr TimeUs sampled_us = 12'340'000;
    static CascadeModes modes_of(int size) { return random_modes(size, size, 1); }
    /// All points of the small maps, 8 rows of the large ones: the sum costs N^2 per row.
    static std::size_t stride_of(int size) {
        return size <= 64 ? 1 : static_cast<std::size_t>(size) / 8;
    }
    /// Summed once for all instruction sets.
    static const std::vector<double>& truth_of(int size, Field field) {
        static std::map<std::pair<int, Field>, std::vector<double>> sums;
        std::vector<double>& sum = sums[{size, field}];
        if (sum.empty())
            sum = double_sum(modes_of(size), field, sampled_us, stride_of(size));
        return sum;
    }
};

TEST_P(EverySize, fields_equal_the_double_sum) {
    const auto [instructions, size] = GetParam();
    constexpr FieldSet fields = linear_fields;
    const std::vector<float> planes = synthesize(modes_of(size), fields, sampled_us, instructions);
    const auto n = static_cast<std::size_t>(size);
    const std::size_t stride = stride_of(size);
    for (Field field : fields) {
        const std::vector<double>& truth = truth_of(size, field);
        const auto map = std::span(planes).subspan(
            static_cast<std::size_t>(fields.index_of(field)) * n * n, n * n);
        EXPECT_LT(worst_error(map, truth, n, stride), tolerance) << info(field).name;
    }
}

INSTANTIATE_TEST_SUITE_P(Native, EverySize, testing::ValuesIn(every_transform()), name_of);

TEST(NativeTransform, phases_are_as_good_after_thirty_years_as_at_the_start) {
    const CascadeModes modes = random_modes(64, 64, 2);
    for (TimeUs t_us :
         {TimeUs{0}, TimeUs{12'340'000}, TimeUs{86'400'000'000}, TimeUs{1'000'000'000'000},
          TimeUs{1'000'000'000'000'000}, TimeUs{-1'000'000'000'000'007}}) {
        const auto map = synthesize(modes, {Field::height}, t_us);
        EXPECT_LT(worst_error(map, double_sum(modes, Field::height, t_us, 1), 64, 1), tolerance)
            << t_us;
    }
}

TEST(NativeTransform, a_narrow_band_leaves_nothing_behind_from_a_wide_one) {
    // One runner, so that scratch of the full band is what the narrow one starts from.
    for (double reach : {3.0, 7.0, 15.0, 16.0, 17.0, 40.0}) {
        const CascadeModes wide = random_modes(128, 128, 3), narrow = random_modes(128, reach, 4);
        const FieldSet fields{Field::height, Field::displacement_x, Field::strain_xy};
        const auto wide_cascade = NativeTransform::create(wide, {});
        const auto narrow_cascade = NativeTransform::create(narrow, {});
        std::vector<float> planes(3 * 128 * 128);
        NativeRunner runner(2);
        for (const auto* cascade : {&*wide_cascade, &*wide_cascade, &*narrow_cascade}) {
            const NativeTask task{cascade, 5'000'000, fields, planes};
            runner.run({&task, 1});
        }
        for (Field field : fields) {
            const auto map = std::span(planes).subspan(
                static_cast<std::size_t>(fields.index_of(field)) * 128 * 128, 128 * 128);
            EXPECT_LT(worst_error(map, double_sum(narrow, field, 5'000'000, 1), 128, 1), tolerance)
                << info(field).name << " reach " << reach;
        }
    }
}

TEST(NativeTransform, a_band_with_a_hole_in_the_middle_is_a_sum_of_its_modes) {
    CascadeModes modes = random_modes(128, 0, 5);
    modes.h0[5 * 128 + 60] = {0.3, 0.2};
    modes.rate[5 * 128 + 60] = modes.rate[123 * 128 + 68] = rate_from_omega(1.7);
    const auto map = synthesize(modes, {Field::height}, 3'000'000);
    EXPECT_LT(worst_error(map, double_sum(modes, Field::height, 3'000'000, 1), 128, 1), tolerance);
}

TEST(NativeTransform, a_flat_sea_is_flat) {
    const auto map = synthesize(random_modes(64, 0, 6), {Field::height, Field::slope_x}, 1'000'000);
    EXPECT_TRUE(std::all_of(map.begin(), map.end(), [](float v) { return v == 0; }));
}

/// Lists of fields, each synthesised and held against the same fields of the list of all, bit for bit.
void expect_lists_alike(int size, Instructions instructions, std::uint32_t every) {
    const CascadeModes modes = random_modes(size, size / 2.1, 7);
    constexpr FieldSet all = all_made;
    const auto together = synthesize(modes, all, 9'000'000, instructions);
    const auto cascade = NativeTransform::create(modes, {}, instructions);
    const auto points = static_cast<std::ptrdiff_t>(size) * size;
    NativeRunner runner(2);
    std::vector<float> planes;
    for (std::uint32_t bits = 1; bits <= all.bits(); bits += every) {
        const auto fields = FieldSet::from_bits(bits) & all;
        if (fields.empty())
            continue;
        planes.assign(static_cast<std::size_t>(fields.size() * points), NAN);
        const NativeTask task{&*cascade, 9'000'000, fields, planes};
        runner.run({&task, 1});
        for (Field field : fields) {
            const auto part = planes.begin() + fields.index_of(field) * points;
            ASSERT_TRUE(
                std::equal(part, part + points, together.begin() + all.index_of(field) * points))
                << info(field).name << " in list " << bits << ", " << name(instructions) << " "
                << size;
        }
    }
}

// Fields share work in different ways in different lists, never the numbers.
TEST(NativeTransform, every_list_of_fields_gives_each_field_alike) {
    expect_lists_alike(64, best_instructions(), 1);
}

TEST(NativeTransform, lists_give_fields_alike_at_every_size_with_every_instruction_set) {
    for (Instructions instructions : supported_instructions()) {
        for (int size : {16, 32, 128})
            expect_lists_alike(size, instructions, 61); // a prime: all fields come and go
        for (int size : {256, 512, 1024})               // of which some are stored past the caches
            expect_lists_alike(size, instructions, 1021);
    }
}

// What is fused stands in the source, so the same sums come out of lanes of any number.
TEST(NativeTransform, instruction_sets_that_fuse_give_the_same_bits) {
    std::vector<Instructions> fused;
    for (Instructions instructions : supported_instructions())
        if (instructions != Instructions::portable)
            fused.push_back(instructions);
    constexpr FieldSet all = all_made;
    for (int size = NativeTransform::smallest_size; size <= NativeTransform::largest_size;
         size *= 2)
        for (std::size_t i = 1; i < fused.size(); ++i) {
            const CascadeModes modes = random_modes(size, size / 2.5, 11);
            EXPECT_EQ(synthesize(modes, all, 5'000'000, fused[i]),
                      synthesize(modes, all, 5'000'000, fused[0]))
                << name(fused[i]) << " " << size;
        }
}

TEST(NativeTransform, jacobian_is_the_determinant_of_the_displacement_gradient) {
    const CascadeModes modes = random_modes(64, 20, 8);
    const Choppiness choppiness{1.3, 0.7};
    const auto map =
        synthesize(modes, {Field::jacobian}, 4'000'000, best_instructions(), 2, choppiness);
    const auto xx = double_sum(modes, Field::strain_xx, 4'000'000, 1);
    const auto yy = double_sum(modes, Field::strain_yy, 4'000'000, 1);
    const auto xy = double_sum(modes, Field::strain_xy, 4'000'000, 1);
    const double scale = 4 * std::max(rms(xx), rms(yy));
    for (std::size_t i = 0; i < map.size(); ++i) {
        const double truth = (1 + choppiness.x * xx[i]) * (1 + choppiness.y * yy[i]) -
                             choppiness.x * choppiness.y * xy[i] * xy[i];
        // Strains are right to 1e-6 of `scale`; a product carries each error times the other
        // factor.
        const double factor = 1 + std::abs(xx[i]) + std::abs(yy[i]) + 2 * std::abs(xy[i]);
        ASSERT_NEAR(map[i], truth, (1 + scale) * factor * 2 * tolerance);
    }
}

TEST(NativeTransform, threads_do_not_change_a_bit) {
    const CascadeModes modes = random_modes(256, 100, 9);
    const auto one = synthesize(modes, all_made, 77'000'000, best_instructions(), 1);
    for (int threads : {2, 3, 7})
        EXPECT_EQ(synthesize(modes, all_made, 77'000'000, best_instructions(), threads), one);
}

TEST(NativeTransform, tasks_of_different_sizes_run_together_as_alone) {
    const int sizes[] = {256, 16, 512, 64, 64, 128};
    std::vector<NativeTransform> cascades;
    std::vector<CascadeModes> modes;
    std::vector<std::vector<float>> planes;
    for (int size : sizes) {
        modes.push_back(random_modes(size, size / 3.0, static_cast<std::uint64_t>(size)));
        cascades.push_back(std::move(*NativeTransform::create(modes.back(), {})));
        planes.emplace_back(surface_fields.size() * size * size);
    }
    std::vector<NativeTask> tasks;
    for (std::size_t i = 0; i < cascades.size(); ++i)
        tasks.push_back({&cascades[i], 1'000'000, surface_fields, planes[i]});
    NativeRunner runner(2);
    runner.run(tasks);
    for (std::size_t i = 0; i < cascades.size(); ++i)
        EXPECT_EQ(planes[i], synthesize(modes[i], surface_fields, 1'000'000)) << sizes[i];
}

TEST(NativeTransform, modes_out_of_range_are_refused_by_name) {
    CascadeModes modes = random_modes(64, 10, 10);
    modes.spec.size = 48;
    EXPECT_NE(NativeTransform::create(modes, {}).error().message.find("48"), std::string::npos);
    modes.spec.size = 2048;
    EXPECT_NE(NativeTransform::create(modes, {}).error().message.find("2048"), std::string::npos);
    modes.spec.size = 32;
    EXPECT_NE(NativeTransform::create(modes, {}).error().message.find("4096"), std::string::npos);
}

} // namespace
} // namespace seaway::sea
