// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "sea/surface/budget/error_budget.h"
#include "sea/surface/maps/spline_map.h"
#include "tests/support/explicit_sea.h"

namespace seaway::sea {
namespace {

std::vector<CascadeWaves> some_waves(int cascades, double steepness = 0.01) {
    std::vector<CascadeWaves> waves;
    const double lengths_m[] = {900, 170, 31, 7};
    for (int c = 0; c < cascades; ++c)
        waves.emplace_back(tests::random_cascade(lengths_m[c], 64, 12, 200, steepness,
                                                 static_cast<std::uint64_t>(c)));
    return waves;
}

double lost_m2(std::span<const CascadeWaves> waves, std::span<const TimeUs> intervals_us,
               double weight) {
    double sum = 0;
    for (std::size_t c = 0; c < waves.size(); ++c)
        sum += waves[c].time_costs_m2(intervals_us[c], weight);
    return sum;
}

// Shortened one at a time the intervals may miss a better exchange of two of them.
TEST(Spending, is_within_ten_percent_of_the_cheapest_of_all_combinations) {
    const std::vector<CascadeWaves> waves = some_waves(3);
    const double weight = 0.2;
    for (const double error_m : {0.0005, 0.002, 0.007}) {
        const double variance = error_m * error_m;
        double cheapest = std::numeric_limits<double>::infinity();
        for (const TimeUs a : keyframe_intervals_us)
            for (const TimeUs b : keyframe_intervals_us)
                for (const TimeUs c : keyframe_intervals_us) {
                    const std::array intervals{a, b, c};
                    const double left = variance - lost_m2(waves, intervals, weight);
                    if (left > 0)
                        cheapest =
                            std::min(cheapest, spend_at(waves, intervals, left, weight).bits_per_s);
                }
        const Spending spent = spend(waves, variance, weight);
        EXPECT_LE(spent.bits_per_s, 1.1 * cheapest) << error_m;
        EXPECT_GE(spent.bits_per_s, cheapest * (1 - 1e-12)) << error_m;
    }
}

TEST(Spending, time_and_codec_together_lose_what_they_may_and_not_more) {
    const std::vector<CascadeWaves> waves = some_waves(4);
    for (const double error_m : {0.0003, 0.001, 0.003}) {
        const Spending spent = spend(waves, error_m * error_m, 0.3);
        EXPECT_NEAR((lost_m2(waves, spent.intervals_us, 0.3) + spent.codec_m2) /
                        (error_m * error_m),
                    1.0, 1e-9);
        double shares = 0;
        for (const double share : spent.codec_shares)
            shares += share;
        EXPECT_NEAR(shares, 1.0, 1e-12);
    }
}

TEST(Spending, a_looser_budget_never_costs_more_nor_gets_a_shorter_interval) {
    for (const int cascades : {1, 2, 4}) {
        const std::vector<CascadeWaves> waves = some_waves(cascades);
        Spending before = spend(waves, 1e-12, 0.2);
        for (double error_m = 1.1e-6; error_m < 3; error_m *= 1.1) {
            const Spending spent = spend(waves, error_m * error_m, 0.2);
            EXPECT_LE(spent.bits_per_s, before.bits_per_s * (1 + 1e-12)) << error_m;
            for (std::size_t c = 0; c < waves.size(); ++c)
                EXPECT_GE(spent.intervals_us[c], before.intervals_us[c]) << error_m;
            before = spent;
        }
    }
}

// What heights allow would cost slopes and folds: 15 % of strain, at six deviations, is the end.
TEST(Spending, however_loose_a_budget_strains_are_kept) {
    const std::vector<CascadeWaves> waves = some_waves(3, 0.03);
    for (const double variance_m2 : {1e-4, 1e-3, 1e-2, 1e-1, 100.0}) {
        const Spending spent = spend(waves, variance_m2, 0.2);
        double missed2 = 0, coded2 = 0;
        for (std::size_t c = 0; c < 3; ++c) {
            missed2 += std::pow(waves[c].time_strain_rms(spent.intervals_us[c]), 2);
            coded2 +=
                spent.codec_m2 * spent.codec_shares[c] * 3.4217 / std::pow(waves[c].spacing_m(), 2);
        }
        EXPECT_LE(6 * std::sqrt(missed2), 0.15);
        EXPECT_LE(6 * std::sqrt(coded2), 0.15 + 1e-6) << variance_m2;
        if (variance_m2 > 1e-3) { // and all of it is spent
            EXPECT_NEAR(6 * std::sqrt(coded2), 0.15, 1e-6) << variance_m2;
        }
    }
}

TEST(Spending, flat_water_gets_no_share_of_the_codec) {
    std::vector<CascadeWaves> waves = some_waves(2);
    waves.emplace_back(tests::calm_cascade(10.0, 64));
    const Spending spent = spend(waves, 1e-6, 0.2);
    EXPECT_EQ(spent.codec_shares[2], 0);
    EXPECT_EQ(spent.intervals_us[2], keyframe_intervals_us[0]);
    const std::vector<CascadeWaves> calm{CascadeWaves(tests::calm_cascade(10.0, 64))};
    EXPECT_TRUE(std::isfinite(spend(calm, 1e-6, 0.0).bits_per_s));
}

// The two values and the two rates of a Hermite pair, errors of a value having variance 1.
TEST(Spending, rounded_pairs_never_vary_more_than_the_peak_says) {
    for (const double rate : {0.0, 3.0, 24.0, 32.0, 100.0}) {
        double largest = 0;
        for (int i = 0; i <= 1000; ++i) {
            const HermiteWeights w = hermite_weights(0, 1'000'000, 1000 * i);
            largest =
                std::max(largest, w.value[0] * w.value[0] + w.value[2] * w.value[2] +
                                      rate * (w.value[1] * w.value[1] + w.value[3] * w.value[3]));
        }
        // Tried at every 32nd of the interval.
        EXPECT_NEAR(codec_peak(rate) / largest, 1.0, 2e-3) << rate;
    }
}

// Rounding errors are even and independent from point to point. Through a spline they vary no more than
// at the points, and its slope 3.42 in squares of the spacing.
TEST(Spending, a_spline_through_rounding_errors_varies_as_the_laws_say) {
    constexpr int size = 256;
    Keyframe keyframe;
    keyframe.size = size;
    keyframe.length_m = size; // 1 m apart
    keyframe.fields = surface_fields;
    keyframe.values.resize(keyframe.plane_size() * 6);
    std::mt19937 random(4);
    std::uniform_real_distribution<float> error(-0.01f, 0.01f);
    for (float& value : keyframe.values)
        value = error(random);
    const SplineMap map(keyframe);
    std::uniform_int_distribution<int> cell(0, size - 1);
    const auto variances = [&](double share) {
        double value = 0, slope = 0;
        for (int i = 0; i < 20'000; ++i) {
            const SplineSample s = map.sample(cell(random) + share, cell(random) + 0.0);
            value += std::pow(static_cast<double>(s.value[1]), 2) / 20'000;
            slope += std::pow(static_cast<double>(s.d_dx[1]), 2) / 20'000;
        }
        const double variance = rounded_rms(0.01) * rounded_rms(0.01);
        return std::array{value / variance, slope / variance};
    };
    // 20 000 of 65 536 errors: standard errors of 1 %.
    EXPECT_NEAR(variances(0.0)[0], 1.0, 0.04);
    EXPECT_NEAR(variances(0.5)[1] / spline_slope_variance_gain, 1.0, 0.04);
    for (const double share : {0.2, 0.5, 0.7}) {
        // By axis; along the other one these places are grid points.
        EXPECT_LT(variances(share)[0], (1 - 0.2 * between_samples(share)) * 1.03);
        EXPECT_LT(variances(share)[1], 1.04 * spline_slope_variance_gain);
    }
}

} // namespace
} // namespace seaway::sea
