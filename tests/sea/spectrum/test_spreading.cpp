// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sea/basics/constants.h"
#include "sea/spectrum/spreading.h"
#include "tests/sea/csv.h"

namespace seaway::sea {
namespace {

using testing::Table;

constexpr SpreadingKind all_kinds[] = {SpreadingKind::cos2,           SpreadingKind::cos2s,
                                       SpreadingKind::mitsuyasu,      SpreadingKind::hasselmann,
                                       SpreadingKind::donelan_banner, SpreadingKind::cos2_cos2s,
                                       SpreadingKind::cos2_hasselmann};

/// Integral over the circle: midpoint rule, dense where the beam is and towards the cusp at pi.
double circle_integral(const Spreading& d, double weight_cos = 0.0) {
    const double beam = std::min(0.5 * pi, 40.0 / std::sqrt(d.exponent() + 1.0));
    const auto f = [&](double t) { return d(t) * (weight_cos == 0.0 ? 1.0 : std::cos(t)); };
    constexpr int n = 6000;
    double sum = 0.0;
    for (int i = 0; i < n; ++i) {
        const double v = (i + 0.5) / n;
        sum += f(beam * v) * beam + f(pi - (pi - beam) * v * v * v) * (pi - beam) * 3.0 * v * v;
    }
    return 2.0 * sum / n;
}

double eval_formula(const std::string& text) {
    const std::size_t slash = text.find('/');
    return pi / std::strtod(text.c_str() + slash + 1, nullptr);
}

TEST(Spreading, P02_xdyn_cos2s_values_match) {
    const Table table("P02_xdyn_cos2s");
    for (std::size_t r = 0; r < table.size(); ++r) {
        const double theta =
            eval_formula(table.text(r, "theta_rad")) - eval_formula(table.text(r, "theta0_rad"));
        EXPECT_NEAR(Spreading::power(table.number(r, "s"))(theta), table.number(r, "D"), 1e-12);
    }
}

TEST(Spreading, P04_wafo_cos2s_around_the_circle_matches) {
    const Table table("P04_wafo_cos2s_s15");
    for (std::size_t r = 0; r < table.size(); ++r)
        EXPECT_NEAR(Spreading::power(15.0)(table.number(r, "theta_rad_linspace_0_2pi_50")),
                    table.number(r, "D_s15"), 1e-5);
}

TEST(Spreading, D07_parameters_of_the_models_match) {
    const Table table("D07_spreading_parameters");
    for (std::size_t r = 0; r < table.size(); ++r) {
        const double x = table.number(r, "omega_over_omega_p");
        // Printed with 10 digits.
        EXPECT_NEAR(donelan_banner_beta(x) / table.number(r, "donelan_banner_beta"), 1.0, 1e-8);
        const Spreading donelan({SpreadingKind::donelan_banner}, {x, 1.0});
        EXPECT_NEAR(donelan(0.0) / table.number(r, "D_peak=beta/(2 tanh(beta pi))"), 1.0, 1e-8);
        for (const char* age : {"0.83", "1.17", "2", "5"}) {
            const SpreadingPlace place{x, std::strtod(age, nullptr)};
            EXPECT_NEAR(hasselmann_exponent(place) /
                            table.number(r, std::string("hasselmann_s_U/cp=") + age),
                        1.0, 1e-8);
            EXPECT_NEAR(mitsuyasu_exponent(place) /
                            table.number(r, std::string("mitsuyasu_s_U/cp=") + age),
                        1.0, 1e-8);
        }
    }
}

// Traps T12, T13, T14, T15: published codes integrate to 2, 1.92, 0.74 and 0.
TEST(Spreading, every_model_integrates_to_one_over_the_full_circle) {
    for (const SpreadingKind kind : all_kinds)
        for (const double swell : {0.0, 0.05, 0.5, 1.0})
            for (const double isotropic : {0.0, 0.3, 1.0})
                for (const double x : {0.01, 0.5, 0.949, 1.0, 1.049, 1.051, 1.6, 4.0, 100.0})
                    for (const double age : {0.83, 5.0}) {
                        const Spreading d({kind, 10.0, swell, isotropic}, {x, age});
                        // Quadrature of the test and of the model.
                        ASSERT_NEAR(circle_integral(d), 1.0, 1e-6)
                            << static_cast<int>(kind) << " swell " << swell << " x " << x;
                    }
}

// Naive: Gamma(2s+1) overflows at s = 85 in double, 17 in float.
TEST(Spreading, A15_any_exponent_integrates_to_one) {
    for (const double s : {0.0, 1e-3, 0.3, 1.0, 15.9, 16.1, 25.9, 85.0, 171.0, 1e3, 1e4, 1e6})
        EXPECT_NEAR(circle_integral(Spreading::power(s)), 1.0, 1e-6) << s;
}

TEST(Spreading, cos2s_norm_matches_log_gamma) {
    for (const double s : {0.0, 0.1, 0.5, 1.0, 3.0, 15.0, 15.7, 16.0, 40.0, 300.0})
        EXPECT_NEAR(log_cos2s_norm(s),
                    std::lgamma(s + 1) - std::lgamma(s + 0.5) - std::log(2.0 * std::sqrt(pi)),
                    1e-13 * (1.0 + s)); // lgamma's own rounding grows with its value
}

TEST(Spreading, is_even_continuous_at_the_seam_and_never_negative) {
    for (const SpreadingKind kind : all_kinds)
        for (const double swell : {0.0, 0.4})
            for (const double x : {0.3, 1.0, 2.0}) {
                const Spreading d({kind, 4.0, swell, 0.0}, {x, 1.0});
                for (double theta = 0.0; theta <= pi; theta += 0.01) {
                    ASSERT_GE(d(theta), 0.0);
                    ASSERT_DOUBLE_EQ(d(theta), d(-theta));
                    ASSERT_NEAR(d(theta), d(theta + two_pi), 1e-12); // rounding of the wrap
                }
                EXPECT_NEAR(d(pi), d(-pi), 1e-15);
            }
}

TEST(Spreading, first_moment_is_the_integral_of_cosine) {
    for (const SpreadingKind kind : all_kinds)
        for (const double swell : {0.0, 0.4})
            for (const double x : {0.5, 1.0, 3.0}) {
                const Spreading d({kind, 7.0, swell, 0.25}, {x, 1.0});
                EXPECT_NEAR(d.first_moment(), circle_integral(d, 1.0), 1e-6);
            }
    EXPECT_NEAR(Spreading::power(9.0).first_moment(), 0.9, 1e-15); // r1 = s/(s+1)
}

// Naive (Encino): negative swell blends to -1/(2 pi) and kills the sea. Here swell starts at 0 and
// acts the other way than a tanh(w/wp) exponent would: long waves become the narrow ones (trap
// T10).
TEST(Spreading, A17_T10_swell_narrows_long_waves_and_acts_continuously) {
    // 16 tanh(wp / w) xi^2 (Horvath 2015), by exponentials.
    for (const double x : {0.5, 0.8, 1.0, 1.25, 2.0, 4.0})
        for (const double xi : {0.25, 0.5, 1.0}) {
            const double squeezed = std::exp(2 / x);
            const double expected = 16 * xi * xi * (squeezed - 1) / (squeezed + 1);
            EXPECT_NEAR(swell_exponent(x, xi), expected, 1e-13 * expected) << x << ' ' << xi;
        }
    // An exponent of at most 16 more: a density grows by 32 d(xi) times 0.3 at most, and is none below 0.
    constexpr double step = 1e-6;
    for (const SpreadingKind kind : all_kinds)
        for (const double x : {0.6, 1.0, 1.7})
            for (double xi = 0; xi < 1; xi += 0.05) {
                const Spreading here({kind, 10.0, xi, 0.0}, {x, 1.0});
                const Spreading there({kind, 10.0, xi + step, 0.0}, {x, 1.0});
                for (double theta = -3.1; theta < 3.2; theta += 0.2) {
                    EXPECT_GE(here(theta), 0);
                    EXPECT_NEAR(here(theta), there(theta), 10 * step) << theta << ' ' << xi;
                }
            }
}

// The sum of both exponents, not the larger one; where there is no exponent to add to, the swell's is a factor.
TEST(Spreading, swell_is_added_to_the_exponent_of_every_model) {
    for (const double x : {0.6, 1.0, 1.7})
        for (const double swell : {0.2, 0.5, 1.0}) {
            const SpreadingPlace place{x, 1.1};
            const double more = swell_exponent(x, swell);
            for (const auto& [kind, own] :
                 {std::pair(SpreadingKind::cos2s, 10.0),
                  {SpreadingKind::mitsuyasu, mitsuyasu_exponent(place)},
                  {SpreadingKind::hasselmann, hasselmann_exponent(place)}}) {
                const Spreading swollen({kind, 10.0, swell, 0.0}, place);
                const Spreading sum = Spreading::power(own + more);
                EXPECT_DOUBLE_EQ(swollen.exponent(), own + more);
                for (double theta = -3.1; theta < 3.2; theta += 0.1)
                    EXPECT_DOUBLE_EQ(swollen(theta), sum(theta));
            }
            for (const SpreadingKind kind : {SpreadingKind::cos2, SpreadingKind::donelan_banner}) {
                const Spreading swollen({kind, 10.0, swell, 0.0}, place), plain({kind}, place);
                const double ahead = swollen(0.0) / plain(0.0);
                for (double theta = -1.5; theta < 1.6; theta += 0.1)
                    EXPECT_NEAR(swollen(theta),
                                ahead * plain(theta) * std::pow(std::cos(theta / 2), 2 * more),
                                1e-12);
            }
        }
}

// Naive: s_p = 11.5 * 0^-2.5 = inf, and 0 * inf is NaN at omega = 0.
TEST(Spreading, A18_mitsuyasu_survives_an_old_sea) {
    for (const double age : {0.0, 1e-300, 1e-6, 0.1})
        for (const double x : {0.0, 1e-3, 1.0, 50.0}) {
            const Spreading d({SpreadingKind::mitsuyasu}, {x, age});
            EXPECT_TRUE(std::isfinite(d(0.1))) << age << " " << x;
            EXPECT_NEAR(circle_integral(d), 1.0, 1e-6) << age << " " << x;
        }
}

// Naive: pow of a negative base, 0^0; mu = -73 underflows to s = 0, an even spread.
TEST(Spreading, A19_hasselmann_survives_a_very_young_sea) {
    for (const double x : {0.0, 0.5, 1.05, 3.0, 100.0}) {
        const Spreading d({SpreadingKind::hasselmann}, {x, 50.0});
        EXPECT_TRUE(std::isfinite(d(1.0)));
        EXPECT_NEAR(circle_integral(d), 1.0, 1e-6);
    }
    EXPECT_NEAR(Spreading({SpreadingKind::hasselmann}, {100.0, 50.0})(2.0), 1.0 / two_pi, 1e-9);
}

// T9: cos^2 keeps nothing upwind.
TEST(Spreading, T9_cos2_sends_nothing_upwind) {
    const Spreading d({SpreadingKind::cos2}, {1.0, 1.0});
    EXPECT_EQ(d(pi), 0.0);
    EXPECT_EQ(d(0.5 * pi + 1e-9), 0.0);
    EXPECT_NEAR(d(0.0), 2.0 / pi, 1e-15);
}

// T11: Hasselmann's constants with Mitsuyasu's exponents are neither; the break is at 1.05.
TEST(Spreading, T11_hasselmann_breaks_at_1_05_with_its_own_exponents) {
    EXPECT_NEAR(hasselmann_exponent({1.049, 1.17}), 6.97 * std::pow(1.049, 4.06), 1e-12);
    EXPECT_NEAR(hasselmann_exponent({1.05, 1.17}), 9.77 * std::pow(1.05, -2.33), 1e-12);
}

// D = b narrow + (1 - b) cos2: at every angle, and in its first moment.
TEST(Spreading, a_blend_is_the_weighted_sum_of_broad_and_narrow) {
    const SpreadingPlace place{1.4, 1.1};
    for (const auto& [kind, narrow_kind] :
         {std::pair{SpreadingKind::cos2_cos2s, SpreadingKind::cos2s},
          {SpreadingKind::cos2_hasselmann, SpreadingKind::hasselmann}})
        for (const double share : {0.0, 0.3, 1.0})
            for (const double swell : {0.0, 0.5}) {
                SpreadingModel model;
                model.kind = kind;
                model.exponent = 40.0;
                model.swell = swell;
                model.narrow_share = share;
                SpreadingModel narrow = model;
                narrow.kind = narrow_kind;
                SpreadingModel broad;
                broad.kind = SpreadingKind::cos2;
                const Spreading blend(model, place), a(narrow, place), b(broad, place);
                for (double theta = -3.1; theta < 3.2; theta += 0.1)
                    EXPECT_NEAR(blend(theta), share * a(theta) + (1.0 - share) * b(theta), 1e-14);
                EXPECT_NEAR(blend.first_moment(),
                            share * a.first_moment() + (1.0 - share) * b.first_moment(), 1e-12);
            }
}

} // namespace
} // namespace seaway::sea
