// SPDX-License-Identifier: Apache-2.0
// Stylised waves as statistics see them.
#include <gtest/gtest.h>

#include "sea/basics/constants.h"
#include "sea/waves/sine_waves.h"

namespace seaway::sea {
namespace {

// Naive: all of a sharp wave turns and bends as its fundamental: of sharpness 10 its slopes have six times the variance.
TEST(Sines, a_sharp_waves_slopes_and_rates_are_those_of_all_its_harmonics) {
    for (const double sharpness : {0.1, 1.0, 3.0, 10.0}) {
        SineField field;
        field.length_m = 100;
        field.sharpness = sharpness;
        field.waves.push_back({two_pi / 50, two_pi / 25, 1.3, 0.4, 0, 0.7, 0});
        double square = 0, slope = 0, rate = 0;
        constexpr int n = 4096; // along x alone the whole phase is gone through
        for (int i = 0; i < n; ++i) {
            const LagrangianPoint at = sines_at(field, 50.0 * i / n, 0, 0);
            square += at.height * at.height / n;
            slope += (at.slope_x * at.slope_x + at.slope_y * at.slope_y) / n;
            rate += at.height_rate * at.height_rate / n;
        }
        double variance = 0, of_slope = 0, of_rate = 0;
        for (const SineLine& line : sine_lines(field)) {
            variance += line.variance_m2;
            of_slope +=
                line.variance_m2 * (line.kx_radpm * line.kx_radpm + line.ky_radpm * line.ky_radpm);
            of_rate += line.variance_m2 * line.omega_radps * line.omega_radps;
        }
        // A sum over equal steps of a periodic function is its integral; what is left is rounding.
        EXPECT_NEAR(variance, square, 1e-9 * square) << sharpness;
        EXPECT_NEAR(variance, 1.3 * 1.3 * exponential_sine(sharpness).variance, 1e-9 * variance);
        EXPECT_NEAR(of_slope, slope, 1e-9 * slope) << sharpness;
        EXPECT_NEAR(of_rate, rate, 1e-9 * rate) << sharpness;
    }
}

} // namespace
} // namespace seaway::sea
