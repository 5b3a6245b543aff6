// SPDX-License-Identifier: Apache-2.0
// Hard cases A2, A7, A13, A15, A23 beside the formulas as they are printed. Their criteria are held in
// tests/sea/spectrum and tests/sea/basics as well, at more places.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "sea/basics/constants.h"
#include "sea/basics/dispersion.h"
#include "sea/basics/gaussian.h"
#include "sea/spectrum/spectra.h"
#include "sea/spectrum/spreading.h"
#include "tests/hard_cases/record.h"
#include "tests/naive/spectrum.h"

namespace seaway::hard_cases {
namespace {

TEST(HardCase, A2_towards_zero_frequency_the_density_falls_to_zero) {
    const auto spectrum = sea::FrequencySpectrum::jonswap_by_height(2.0, 8.0, 1.0);
    int bad = 0, bad_naive = 0, frequencies = 0;
    double before = 0;
    for (double w = 1e-12; w < 0.5 * spectrum.peak_omega_radps(); w *= 1.1, ++frequencies) {
        const double s = spectrum.density(w);
        bad += !std::isfinite(s) || s < before;
        before = s;
        bad_naive += !std::isfinite(naive::density(
            static_cast<float>(w), static_cast<float>(spectrum.peak_omega_radps()), 0.1f));
    }
    EXPECT_EQ(bad, 0);
    EXPECT_GT(bad_naive, 0);
    record("w from 1e-12 rad/s to half the peak", "share of values that are none",
           static_cast<double>(bad_naive) / frequencies, static_cast<double>(bad) / frequencies);
}

// Against w^2 = g k tanh(kd) in long double; 1e-6 is the case's bound for floats.
TEST(HardCase, A7_frequencies_are_right_for_kd_from_1e_8_to_1e8) {
    double worst = 0;
    int bad = 0, naive_bad = 0, values = 0;
    for (double kd = 1e-8; kd <= 1e8; kd *= 3, ++values) {
        const double depth_m = 10, k = kd / depth_m;
        const sea::Dispersion dispersion{9.81, 0, depth_m};
        const long double truth = std::sqrt(9.81L * k * std::tanh(static_cast<long double>(kd)));
        worst = std::max(worst, static_cast<double>(std::abs(dispersion.omega(k) / truth - 1)));
        bad += !std::isfinite(dispersion.omega(k));
        naive_bad += !std::isfinite(naive::omega(static_cast<float>(k), 10.0f));
    }
    EXPECT_LT(worst, 1e-12);
    EXPECT_EQ(bad, 0);
    EXPECT_GT(naive_bad, 0);
    record("kd from 1e-8 to 1e8", "share of values that are none",
           static_cast<double>(naive_bad) / values, static_cast<double>(bad) / values);
}

// The ceiling is 1.26 times Pierson-Moskowitz's height (I27), within the case's 1.3.
TEST(HardCase, A13_a_thousand_kilometres_of_fetch_raise_no_more_than_a_grown_sea) {
    const auto hs = [](double fetch_m) {
        const auto s = sea::FrequencySpectrum::jonswap_by_wind(10.0, fetch_m, 3.3, 9.81);
        double m0 = 0;
        for (double w = 0.1; w < 30; w *= 1.001)
            m0 += s.density(w) * w * 0.001;
        return 4 * std::sqrt(m0);
    };
    const double grown = 0.20925 * std::pow(1.0602 * 10.0, 2) / 9.81;
    EXPECT_EQ(hs(1e7), hs(1e8));
    EXPECT_LE(hs(1e7), 1.3 * grown);
    EXPECT_LT(hs(1e4), hs(1e5));
    EXPECT_GT(naive::jonswap_hs_m(10.0, 1e6), 1.3 * grown);
    record("10 m/s over 1000 km", "Hs, m", naive::jonswap_hs_m(10.0, 1e6), hs(1e6));
}

TEST(HardCase, A15_the_narrowest_beam_has_a_norm) {
    const sea::Spreading beam = sea::Spreading::power(25.9);
    double integral = 0;
    for (int i = 0; i < 20'000; ++i)
        integral += beam(sea::two_pi * i / 20'000) * sea::two_pi / 20'000;
    EXPECT_NEAR(integral, 1.0, 1e-6);
    EXPECT_TRUE(std::isfinite(naive::cos2s_norm(10.0f)));
    EXPECT_FALSE(std::isfinite(naive::cos2s_norm(25.9f)) && naive::cos2s_norm(25.9f) > 0);
    record("s = 25.9, a full swell at its peak", "the norm times its integral",
           naive::cos2s_norm(25.9f), integral);
}

TEST(HardCase, A23_the_word_zero_gives_a_finite_number) {
    const sea::GaussianPair least = sea::gaussian_from_words(0, 0);
    const sea::GaussianPair most = sea::gaussian_from_words(0xFFFFFFFF, 0);
    const double ours = std::hypot(least.real, least.imaginary);
    EXPECT_LT(ours, 6.78); // sqrt(2 ln 2^33); the case's 6.7 is that of 2^32
    EXPECT_TRUE(std::isfinite(most.real) && std::isfinite(most.imaginary));
    EXPECT_FALSE(std::isfinite(naive::box_muller_radius(0)));
    record("the random word 0", "radius of Box-Muller", naive::box_muller_radius(0), ours);
}

} // namespace
} // namespace seaway::hard_cases
