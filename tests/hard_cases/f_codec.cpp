// SPDX-License-Identifier: Apache-2.0
// Hard cases of codecs with a promised bound.
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "protocol/tile_codec.h"
#include "sea/surface/budget/error_budget.h"
#include "sea/surface/maps/spline_map.h"
#include "tests/hard_cases/maps.h"
#include "tests/hard_cases/record.h"
#include "tests/naive/storage.h"
#include "tests/naive/surface.h"
#include "tests/sea/sea_fixture.h"

namespace seaway::hard_cases {
namespace {

std::vector<float> through_codec(std::span<const float> samples, int size, float error) {
    const protocol::TileShape shape{size, size};
    const auto stride = static_cast<std::size_t>(size);
    const auto bytes = protocol::encode_tile(samples, shape, stride, error);
    EXPECT_TRUE(bytes.has_value());
    std::vector<float> out(samples.size());
    EXPECT_TRUE(protocol::decode_tile(*bytes, shape, stride, out).has_value());
    return out;
}

double worst_difference(std::span<const float> a, std::span<const float> b) {
    double worst = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        worst = std::max(worst, std::abs(static_cast<double>(a[i]) - b[i]));
    return worst;
}

TEST(HardCase, F1_F2_a_tile_of_zeros_and_a_constant_one_come_back_exactly) {
    double ours = 0, none = 0, values = 0;
    for (const float constant : {0.0f, 1e-38f, 3e4f}) {
        const std::vector<float> tile(32 * 32, constant);
        ours = std::max(ours, worst_difference(tile, through_codec(tile, 32, 1e-3f)));
        for (const float value : naive::coded_by_range(tile))
            none += !std::isfinite(value);
        values += 32 * 32;
    }
    EXPECT_EQ(ours, 0);
    EXPECT_GT(none, 0);
    record("tiles of 0, 1e-38 and 30 000", "share of values that are none", none / values, ours);
}

// The case asks for 1e9 values, which take a minute: 1e7 here, of which one tile is of ties, odd halves of the bound.
TEST(HardCase, F6_the_bound_holds_for_the_floats_that_come_out) {
    std::mt19937 random(6);
    std::uniform_real_distribution<float> far(900, 1000);
    std::vector<float> samples(256 * 256);
    const float bound = 1e-4f; // three steps of a float there
    const double limit = static_cast<double>(bound);
    double ours = 0, beyond = 0;
    constexpr int tiles = 153;
    for (int tile = 0; tile < tiles; ++tile) {
        for (std::size_t i = 0; i < samples.size(); ++i)
            samples[i] =
                tile > 0 ? far(random) : static_cast<float>(limit * (static_cast<double>(i) + 0.5));
        const std::vector<float> coded = through_codec(samples, 256, bound);
        for (std::size_t i = 0; i < samples.size(); ++i) {
            const double sample = samples[i];
            ours += std::abs(coded[i] - sample) > limit;
            beyond += std::abs(naive::quantised(sample, limit) - sample) > limit;
        }
    }
    EXPECT_EQ(ours, 0);
    EXPECT_GT(beyond, 0);
    record("1e7 values of 900 to 1000, bound 1e-4", "values beyond it", beyond, ours);
}

TEST(HardCase, F5_a_spike_takes_nothing_from_the_bound_of_its_neighbours) {
    std::mt19937 random(5);
    std::normal_distribution<float> normal(0, 1e-3f);
    std::vector<float> samples(64 * 64);
    for (float& sample : samples)
        sample = normal(random);
    samples[2000] = 1e4f;
    const float bound = 1e-3f;
    const double ours = worst_difference(samples, through_codec(samples, 64, bound));
    const double by_range = worst_difference(samples, naive::coded_by_range(samples));
    EXPECT_LE(ours, bound);
    EXPECT_GT(by_range, bound);
    record("a spike of 1e4 among values of 1e-3, bound 1e-3", "largest error", by_range, ours);
}

// Ours as the stream has them: differences to what was decoded of the frame before, and whole frames of the same bits,
// so that any can be read first. Both expect the frame before, as the naive one does.
TEST(HardCase, F7_the_ten_thousandth_frame_is_within_the_bound) {
    constexpr int size = 16, frames = 10'000;
    const protocol::TileShape shape{size, size};
    const float bound = 0.01f;
    naive::OpenLoopDeltas deltas(bound);
    std::vector<float> frame(size * size), expected(size * size), decoded(size * size),
        followed(size * size), joined(size * size);
    double ours = 0, open_loop = 0;
    int differences = 0;
    for (int n = 0; n < frames; ++n) {
        for (int i = 0; i < size * size; ++i)
            frame[static_cast<std::size_t>(i)] =
                static_cast<float>(2 * std::sin(0.9 * n / 30.0 + 0.3 * (i % size)) +
                                   std::sin(2.3 * n / 30.0 + 0.2 * i));
        const auto forms =
            protocol::encode_tile_forms(frame, shape, size, bound, expected, decoded);
        ASSERT_TRUE(forms);
        ASSERT_TRUE(protocol::decode_tile(forms->whole, shape, size, joined));
        if (forms->difference.empty()) {
            followed = joined;
        } else {
            ++differences;
            ASSERT_TRUE(protocol::decode_tile_difference(forms->difference, shape, size, followed,
                                                         followed));
        }
        ASSERT_EQ(followed, joined) << n;
        expected = decoded;
        ours = std::max(ours, worst_difference(frame, followed));
        open_loop = std::max(open_loop, worst_difference(frame, deltas.next(frame)));
    }
    EXPECT_GT(differences, frames * 9 / 10);
    EXPECT_LE(ours, bound);
    EXPECT_GT(open_loop, bound);
    record("10000 frames of waves, bound 0.01 m", "largest error, m", open_loop, ours);
}

// Slopes that someone asks for are maps of their own with a bound of their own, 0.002. Naive: the
// difference of heights that were coded to 5 cm, a quarter of a metre apart.
TEST(HardCase, F10_slopes_have_a_bound_of_their_own) {
    constexpr int size = 256;
    constexpr std::size_t n = size;
    const auto sea = testing::realized(testing::windy_sea(), {{64.0, size}});
    const sea::ErrorBudget budget = sea::plan_budget(*sea, 0.05);
    const float slope_bound = sea::codec_bounds(budget, {sea::Field::slope_x}, 0, 0.0225)[0];
    EXPECT_FLOAT_EQ(slope_bound, 0.002f);
    const auto planes = maps(sea->cascades[0], {sea::Field::height, sea::Field::slope_x}, 0);
    const auto heights = std::span(planes).first(n * n), slopes = std::span(planes).subspan(n * n);
    const double ours = worst_difference(slopes, through_codec(slopes, size, slope_bound));
    const auto coded = through_codec(heights, size, 0.05f);
    double differences = 0;
    for (std::size_t i = 0; i < n * n; ++i) {
        const std::size_t row = i / n * n, west = row + (i + n - 1) % n, east = row + (i + 1) % n;
        differences = std::max(
            differences, std::abs(naive::difference_slope(coded[west], coded[east], 0.25) -
                                  naive::difference_slope(heights[west], heights[east], 0.25)));
    }
    EXPECT_LE(ours, slope_bound);
    EXPECT_GT(differences, 0.1);
    record("wind sea of 10 m/s, 0.25 m apart, 5 cm", "largest error of a coded slope", differences,
           ours);
}

// Normals of answers come from the spline of coded heights. Errors of the codec are even between plus
// and minus its bound e, so of deviation e/sqrt(3), and independent from point to point (the predictor is
// integer exact). The derivative of the interpolating spline of such noise has the rms
// sqrt(3/dx^2 * g) e/sqrt(3): its gain over frequencies, averaged over places, is at most pi/dx, the
// slope of the finest wave there is.
TEST(HardCase, F10_slopes_of_coded_heights_stay_within_their_budget) {
    constexpr int size = 256;
    const auto sea = testing::realized(testing::windy_sea(), {{256.0, size}});
    const sea::CascadeModes& modes = sea->cascades[0];
    const sea::ErrorBudget budget = sea::plan_budget(*sea, 0.01);
    const sea::FieldSet fields{sea::Field::height, sea::Field::height_rate};
    const double codec_error_m = budget.codec_error_m;
    const float bound = sea::codec_bounds(budget, fields, 0, codec_error_m)[0];
    sea::Keyframe exact;
    exact.size = size;
    exact.length_m = modes.spec.length_m;
    exact.fields = fields;
    exact.values = maps(modes, fields, 0);
    sea::Keyframe coded = exact;
    const auto decoded = through_codec(exact.plane(sea::Field::height), size, bound);
    std::copy(decoded.begin(), decoded.end(), coded.plane(sea::Field::height).begin());
    const sea::SplineMap before(exact), after(coded);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> place(0, modes.spec.length_m);
    double sum = 0, slope = 0;
    for (int i = 0; i < 20'000; ++i) {
        const double x = place(random), y = place(random);
        const double truth = before.sample(x, y).d_dx[0];
        sum += std::pow(after.sample(x, y).d_dx[0] - truth, 2);
        slope += truth * truth;
    }
    const double error = std::sqrt(sum / 20'000);
    EXPECT_LT(error, sea::pi / modes.spec.spacing_m() * bound / std::sqrt(3.0));
    EXPECT_LT(error, 0.05 * std::sqrt(slope / 20'000)); // seen by nobody
    record("wind sea of 10 m/s, 1 m apart, 1 cm", "rms error of slopes from coded heights", error);
}

} // namespace
} // namespace seaway::hard_cases
