// SPDX-License-Identifier: Apache-2.0
// Tiles of samples that are whole steps already: the bytes are those of the floats, and the bound holds.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "protocol/tile_codec.h"

namespace seaway::protocol {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr TileShape whole_shape{96, 64};

float parameter(const Bytes& bytes) {
    float value;
    std::memcpy(&value, &bytes[8], sizeof value);
    return value;
}

/// A few waves and noise, of so many steps at most.
std::vector<std::int16_t> wavy(TileShape shape, double steps_max, unsigned seed) {
    std::mt19937 numbers(seed);
    std::uniform_real_distribution<double> noise(-0.02, 0.02);
    std::vector<std::int16_t> steps;
    for (int y = 0; y < shape.height; ++y)
        for (int x = 0; x < shape.width; ++x)
            steps.push_back(static_cast<std::int16_t>(
                std::lround(steps_max * (0.6 * std::sin(0.21 * x + 0.13 * y) +
                                         0.38 * std::cos(0.4 * y - 0.1 * x) + noise(numbers)))));
    return steps;
}

std::vector<float> samples_of(std::span<const std::int16_t> steps, float step) {
    std::vector<float> samples;
    for (const std::int16_t n : steps)
        samples.push_back(static_cast<float>(n) * step);
    return samples;
}

Bytes coded(std::span<const std::int16_t> steps, TileShape shape, float step, float error) {
    auto bytes =
        encode_tile_steps(steps, shape, static_cast<std::size_t>(shape.width), step, error);
    EXPECT_TRUE(bytes) << bytes.error().message;
    return bytes ? *bytes : Bytes{};
}

/// What the floats are coded to when their step comes out as that of `like`: twice the bound, less what the largest is
/// rounded by. The bound is looked for around there.
Bytes of_floats(std::span<const float> samples, TileShape shape, const Bytes& like) {
    const float wanted = parameter(like);
    float largest = 0.5f * wanted;
    for (const float sample : samples)
        largest = std::max(largest, std::abs(sample) + 0.5f * wanted);
    const float ulp = std::nextafter(largest, std::numeric_limits<float>::infinity()) - largest;
    float error = 0.5f * wanted + 0.5f * ulp;
    for (int i = 0; i < 16; ++i)
        error = std::nextafter(error, 0.0f);
    for (int i = 0; i < 32; ++i) {
        auto bytes = encode_tile(samples, shape, static_cast<std::size_t>(shape.width), error);
        if (bytes && parameter(*bytes) == wanted)
            return *bytes;
        error = std::nextafter(error, std::numeric_limits<float>::infinity());
    }
    return {};
}

double worst_of(const Bytes& bytes, TileShape shape, std::span<const float> samples) {
    std::vector<float> back(samples.size());
    EXPECT_TRUE(decode_tile(bytes, shape, static_cast<std::size_t>(shape.width), back));
    double worst = 0;
    for (std::size_t i = 0; i < back.size(); ++i)
        worst = std::max(worst,
                         std::abs(static_cast<double>(back[i]) - static_cast<double>(samples[i])));
    return worst;
}

/// With products below 4096 that are exact.
float step_near(double value) {
    return std::bit_cast<float>(std::bit_cast<std::uint32_t>(static_cast<float>(value)) & ~0xfffu);
}

TEST(TileSteps, are_the_bytes_that_the_floats_are_when_they_come_to_the_same_step) {
    for (const double steps_max : {90.0, 3000.0, 32000.0})
        for (const double step : {2.37e-4, 0.11})
            for (const double steps_of_error : {0.6, 1.2, 3.5, 7.9, 60.0, 2047.5}) {
                const std::vector<std::int16_t> steps = wavy(whole_shape, steps_max, 1);
                const float own = step_near(step);
                const auto error = static_cast<float>(steps_of_error * static_cast<double>(own));
                const Bytes bytes = coded(steps, whole_shape, own, error);
                const std::vector<float> samples = samples_of(steps, own);
                if (bytes.size() > 16) {
                    EXPECT_EQ(of_floats(samples, whole_shape, bytes), bytes)
                        << steps_max << ' ' << step << ' ' << steps_of_error;
                }
                EXPECT_LE(worst_of(bytes, whole_shape, samples), static_cast<double>(error));
            }
}

TEST(TileSteps, are_coded_as_coarsely_as_the_bound_allows) {
    const std::vector<std::int16_t> steps = wavy(whole_shape, 20000, 2);
    const float step = 0x1p-10f;
    for (const int halves : {0, 1, 2, 7, 100}) {
        const float just = (static_cast<float>(halves) + 0.01f) * step;
        EXPECT_EQ(parameter(coded(steps, whole_shape, step, just)),
                  static_cast<float>(2 * halves + 1) * step);
        const float less = (static_cast<float>(halves) + 0.99f) * step;
        EXPECT_EQ(parameter(coded(steps, whole_shape, step, less)),
                  static_cast<float>(2 * halves + 1) * step);
    }
    EXPECT_EQ(worst_of(coded(steps, whole_shape, step, 0), whole_shape, samples_of(steps, step)), 0)
        << "a bound of none is kept";
}

TEST(TileSteps, every_integer_goes_to_the_nearest_multiple) {
    std::vector<std::int16_t> steps(256 * 256);
    for (std::size_t i = 0; i < steps.size(); ++i)
        steps[i] = static_cast<std::int16_t>(std::max<int>(static_cast<int>(i) - 32768, -32767));
    const TileShape shape{256, 256};
    for (const int factor : {1, 3, 5, 7, 127, 1001, 4095}) {
        const float error = (static_cast<float>(factor / 2) + 0.5f); // of steps of 1
        const Bytes bytes = coded(steps, shape, 1.0f, error);
        ASSERT_EQ(parameter(bytes), static_cast<float>(factor));
        std::vector<float> back(steps.size());
        ASSERT_TRUE(decode_tile(bytes, shape, 256, back));
        for (std::size_t i = 0; i < steps.size(); ++i) {
            const int n = steps[i];
            const int nearest = (n + factor / 2 + 32768 * factor) / factor - 32768;
            ASSERT_EQ(back[i], static_cast<float>(nearest * factor)) << n << " of " << factor;
        }
    }
}

TEST(TileSteps, of_one_value_are_a_header) {
    for (const int value : {0, -32767, 1234}) {
        const std::vector<std::int16_t> steps(64 * 64, static_cast<std::int16_t>(value));
        const Bytes bytes = coded(steps, {64, 64}, 0.001f, 0.01f);
        EXPECT_EQ(bytes.size(), 16u);
        EXPECT_EQ(worst_of(bytes, {64, 64}, samples_of(steps, 0.001f)), 0);
    }
    std::vector<std::int16_t> flat(64 * 64, 700);
    flat[77] = 702;
    const Bytes bytes = coded(flat, {64, 64}, 0x1p-10f, 0x1p-7f);
    EXPECT_EQ(bytes.size(), 16u) << "flatter than the bound";
    EXPECT_LE(worst_of(bytes, {64, 64}, samples_of(flat, 0x1p-10f)), 0x1p-7);
}

TEST(TileSteps, parts_of_a_map_are_read_by_rows) {
    const std::vector<std::int16_t> steps = wavy({64, 64}, 5000, 3);
    const TileShape part{17, 9};
    std::vector<std::int16_t> own;
    for (int y = 0; y < part.height; ++y)
        for (int x = 0; x < part.width; ++x)
            own.push_back(steps[static_cast<std::size_t>((y + 5) * 64 + x + 11)]);
    const auto in_place =
        encode_tile_steps(std::span(steps).subspan(5 * 64 + 11), part, 64, 0x1p-9f, 0.01f);
    ASSERT_TRUE(in_place);
    EXPECT_EQ(*in_place, coded(own, part, 0x1p-9f, 0.01f));
}

TEST(TileSteps, bad_calls_are_errors) {
    const std::vector<std::int16_t> steps(64 * 64);
    const auto call = [&](TileShape shape, float step, float error) {
        return encode_tile_steps(steps, shape, 64, step, error).has_value();
    };
    EXPECT_TRUE(call({64, 64}, 1.0f, 1.0f));
    EXPECT_FALSE(call({64, 65}, 1.0f, 1.0f)) << "fewer samples than that";
    EXPECT_FALSE(call({0, 64}, 1.0f, 1.0f));
    for (const float error :
         {-1.0f, std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()})
        EXPECT_FALSE(call({64, 64}, 1.0f, error)) << error;
    for (const float step : {0.0f, -1.0f, 1e-40f, 0x1p95f, std::numeric_limits<float>::infinity(),
                             std::numeric_limits<float>::quiet_NaN()})
        EXPECT_FALSE(call({64, 64}, step, 1.0f)) << step;
}

} // namespace
} // namespace seaway::protocol
