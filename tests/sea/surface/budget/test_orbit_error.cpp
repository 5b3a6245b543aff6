// SPDX-License-Identifier: Apache-2.0
// What keyframes miss of displacements while the depth glides.
#include <algorithm>
#include <cmath>
#include <random>
#include <tuple>

#include <gtest/gtest.h>

#include "sea/basics/dispersion.h"
#include "sea/basics/glide.h"
#include "sea/surface/budget/orbit_error.h"

namespace seaway::sea {
namespace {

double aspect(double k, const DepthGlide& glide, double s) {
    const double share = glide_share(us_from_seconds(s), 0, glide.us);
    return orbit_aspect(k, glided_depth_m(glide.from_m, glide.to_m, share));
}

/// By Hermite's cubic of values and of slopes that differences tell.
double missed(double k, const DepthGlide& glide, double begin_s, double interval_s, double x) {
    constexpr double step_s = 2e-4;
    const auto slope = [&](double s) {
        return (aspect(k, glide, s + step_s) - aspect(k, glide, s - step_s)) / (2 * step_s);
    };
    const double end_s = begin_s + interval_s, r = 1 - x;
    return r * r * (1 + 2 * x) * aspect(k, glide, begin_s) +
           x * x * (1 + 2 * r) * aspect(k, glide, end_s) +
           interval_s * x * r * (r * slope(begin_s) - x * slope(end_s)) -
           aspect(k, glide, begin_s + x * interval_s);
}

// Naive: amplitudes alone glide. Where k d passes 0.05, below which nothing grows, the rate has a jump, which two keyframes miss by
// an eighth of it times their interval: a tide under a wave of a kilometre, 20 to 13 m a metre of height within a second.
TEST(OrbitError, is_what_keyframes_miss_at_most_wherever_they_lie) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> share(0, 1);
    for (const auto& [length_m, from_m, to_m] : {std::tuple(1000.0, 2.0, 200.0),
                                                 {1000.0, 200.0, 2.0},
                                                 {300.0, 5.0, 50.0},
                                                 {300.0, 40.0, INFINITY},
                                                 {100.0, 0.3, 3.0}})
        for (const double glide_s : {10.0, 30.0, 120.0})
            for (const double interval_s : {0.1, 0.5, 2.0}) {
                const double k = 2 * M_PI / length_m;
                const DepthGlide glide{us_from_seconds(glide_s), from_m, to_m};
                // A kink is met by few intervals of a long glide.
                double kink_s = 0;
                while (kink_s < glide_s && (aspect(k, glide, kink_s) == aspect(k, glide, 0)))
                    kink_s += 0.01;
                if (aspect(k, glide, 0) < aspect(k, glide, glide_s))
                    for (kink_s = glide_s; aspect(k, glide, kink_s) == aspect(k, glide, glide_s);)
                        kink_s -= 0.01;
                double worst = 0;
                for (int i = 0; i < 8000; ++i) {
                    const double begin_s =
                        i % 2 ? kink_s - share(random) * interval_s
                              : -interval_s + share(random) * (glide_s + interval_s);
                    worst = std::max(
                        worst, std::abs(missed(k, glide, begin_s, interval_s, share(random))));
                }
                const double stated = orbit_error(k, glide, us_from_seconds(interval_s));
                EXPECT_LE(worst, 1.1 * stated + 2e-5) << length_m << ' ' << from_m << ' ' << to_m
                                                      << ' ' << glide_s << ' ' << interval_s;
                EXPECT_GE(worst, 0.4 * stated - 2e-5) << "and not far from it";
            }
}

TEST(OrbitError, is_nothing_where_the_depth_stays_or_water_is_deep) {
    EXPECT_EQ(orbit_error(0.01, {}, 1'000'000), 0);
    EXPECT_EQ(orbit_error(0.01, {60'000'000, 20, 20}, 1'000'000), 0);
    EXPECT_NEAR(orbit_error(1.0, {60'000'000, 30, 300}, 1'000'000), 0, 1e-14);
    EXPECT_GT(orbit_error(0.01, {60'000'000, 2, 200}, 1'000'000), 0.1);
}

} // namespace
} // namespace seaway::sea
