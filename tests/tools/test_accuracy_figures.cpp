// SPDX-License-Identifier: Apache-2.0
// What the figures of the accuracy page mean, without a run of the program.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string_view>
#include <vector>

#include "tools/bench/accuracy/half.h"
#include "tools/bench/accuracy/metrics.h"

namespace seaway::bench {
namespace {

/// Every finite half above zero, by its definition (IEEE 754): 10 bits of mantissa, 5 of exponent.
std::vector<double> halves() {
    std::vector<double> all;
    for (int bits = 0; bits < 0x7C00; ++bits) {
        const int exponent = bits >> 10, mantissa = bits & 0x3FF;
        all.push_back(exponent == 0 ? std::ldexp(mantissa, -24)
                                    : std::ldexp(1024 + mantissa, exponent - 25));
    }
    return all;
}

TEST(AccuracyFigures, a_float_as_half_is_the_nearest_of_all_halves) {
    const std::vector<double> all = halves();
    for (std::size_t i = 0; i + 1 < all.size(); ++i)
        for (const double share : {0.0, 0.2, 0.49, 0.51, 0.8}) {
            const double between = all[i] + share * (all[i + 1] - all[i]);
            const auto value = static_cast<float>(between);
            const auto nearest = static_cast<float>(share < 0.5 ? all[i] : all[i + 1]);
            ASSERT_EQ(rounded_to_half(value), nearest) << between;
            ASSERT_EQ(rounded_to_half(-value), -nearest) << between;
        }
}

double figure(const std::vector<Figure>& all, std::string_view metric) {
    const auto found =
        std::find_if(all.begin(), all.end(), [&](const Figure& f) { return f.metric == metric; });
    return found == all.end() ? std::nan("") : found->value;
}

// A velocity or a slope that is off along one axis alone is off by that much, whichever it is.
TEST(AccuracyFigures, every_axis_of_an_answer_counts_alike) {
    const auto of = [](const sea::Answer& truth, const sea::Answer& answer) {
        const Sample sample{PointKind::anywhere, 0, truth, answer};
        return figures({&sample, 1}, 1.0);
    };
    for (int axis = 0; axis < 3; ++axis) {
        sea::Answer truth, answer;
        for (int other = 0; other < 3; ++other)
            truth.velocity_mps[other] = answer.velocity_mps[other] = 1.0 + other;
        EXPECT_EQ(figure(of(truth, answer), "velocity_rms_mps"), 0.0);
        answer.velocity_mps[axis] += 0.25;
        EXPECT_NEAR(figure(of(truth, answer), "velocity_rms_mps"), 0.25, 1e-12) << axis;
    }
    for (int axis = 0; axis < 2; ++axis) {
        sea::Answer truth, answer; // level, and a slope of 0.3
        answer.normal[2] = 1.0 / std::hypot(1.0, 0.3);
        answer.normal[axis] = -0.3 * answer.normal[2];
        const std::vector<Figure> all = of(truth, answer);
        EXPECT_NEAR(figure(all, "slope_rms"), 0.3, 1e-12) << axis;
        EXPECT_NEAR(figure(all, "normal_p99_deg"), std::atan(0.3) * 180.0 / 3.14159265358979, 1e-9);
    }
}

} // namespace
} // namespace seaway::bench
