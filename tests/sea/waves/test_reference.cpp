// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "sea/basics/field.h"
#include "sea/waves/reference.h"
#include "tests/sea/csv.h"
#include "tests/sea/sea_fixture.h"

namespace seaway::sea {
namespace {

using testing::one_wave;
using testing::windy_sea;

/// Plain sum over the whole plane, written once more from the definition.
LagrangianPoint brute_force(const Realization& sea, double x, double y, TimeUs t) {
    LagrangianPoint p;
    for (const CascadeModes& modes : sea.cascades) {
        const int size = modes.spec.size;
        const double step = modes.spec.wavenumber_step_radpm();
        for (int iy = 0; iy < size; ++iy)
            for (int ix = 0; ix < size; ++ix) {
                const auto i = static_cast<std::size_t>(iy * size + ix);
                const auto mirror =
                    static_cast<std::size_t>((size - iy) % size * size + (size - ix) % size);
                if (modes.h0[i] == 0.0 && modes.h0[mirror] == 0.0)
                    continue;
                const double kx = step * signed_index(ix, size);
                const double ky = step * signed_index(iy, size);
                const double k = std::hypot(kx, ky);
                const double d = k * std::tanh(k * modes.depth_m); // D = i k/|k| coth(kd) h
                const double omega = omega_from_rate(modes.rate[i]);
                const std::complex<double> i1(0, 1);
                const auto turn = std::exp(-i1 * phase_rad(modes.rate[i], t));
                const auto forward = modes.h0[i] * turn;
                const auto backward = std::conj(modes.h0[mirror] * turn);
                const auto h = (forward + backward) * std::exp(i1 * (kx * x + ky * y));
                const auto r = i1 * omega * (backward - forward) * std::exp(i1 * (kx * x + ky * y));
                p.height += h.real();
                p.displacement_x += (i1 * kx / d * h).real();
                p.displacement_y += (i1 * ky / d * h).real();
                p.height_rate += r.real();
                p.displacement_x_rate += (i1 * kx / d * r).real();
                p.displacement_y_rate += (i1 * ky / d * r).real();
                p.slope_x += (i1 * kx * h).real();
                p.slope_y += (i1 * ky * h).real();
                p.strain_xx += (-kx * kx / d * h).real();
                p.strain_yy += (-ky * ky / d * h).real();
                p.strain_xy += (-kx * ky / d * h).real();
            }
    }
    return p;
}

void expect_near(const LagrangianPoint& a, const LagrangianPoint& b, double tolerance) {
    for (const Field field : linear_fields)
        EXPECT_NEAR(value_of(a, field), value_of(b, field), tolerance) << info(field).name;
}

TEST(Reference, equals_the_definition_term_by_term) {
    const auto sea = testing::realized(windy_sea(), testing::three_cascades);
    const DirectSum sum(sea);
    for (const TimeUs t : {TimeUs{0}, us_from_seconds(12.34), us_from_seconds(-5.0)})
        for (const double x : {0.0, 13.7, -250.3})
            expect_near(sum.at(x, 2.0 * x + 1.0, t), brute_force(*sea, x, 2.0 * x + 1.0, t), 1e-11);
}

// A field that nobody sums would be zero in every reference made from it.
TEST(Reference, fills_every_linear_field_of_the_table) {
    const LagrangianPoint p =
        DirectSum(testing::realized(windy_sea(), testing::three_cascades)).at(3.0, 4.0, 5'000'000);
    for (const Field field : linear_fields)
        EXPECT_NE(value_of(p, field), 0.0) << info(field).name;
}

// T28: with exp(+i w t) on h0 the sea runs upwind.
TEST(Reference, T28_a_one_mode_sea_travels_along_plus_k) {
    const DirectSum sum(one_wave(100.0, 64, 3, 4, 1.0));
    const double k = two_pi / 100.0 * 5.0;
    const double speed = omega_from_rate(sum.sea().cascades[0].rate[4 * 64 + 3]) / k;
    for (const double t : {0.0, 0.4, 0.8, 1.2}) {
        // The crest that was at the origin is c t further along (0.6, 0.8).
        const LagrangianPoint p = sum.at(0.6 * speed * t, 0.8 * speed * t, us_from_seconds(t));
        EXPECT_NEAR(p.height, 1.0, 1e-9); // time is whole microseconds
        EXPECT_NEAR(p.height_rate, 0.0, 1e-5);
    }
}

// I15, T27, D5: displacement -i k/|k| h would flatten crests.
TEST(Reference, T27_D08_displacement_sharpens_crests_into_a_trochoid) {
    const testing::Table table("D08_trochoid_harmonics");
    for (std::size_t r = 0; r < table.size(); ++r) {
        const double steepness = table.number(r, "lambda_k_a");
        const double k = two_pi / 10.0;
        const double a = steepness / k;
        const DirectSum sum(one_wave(10.0, 16, 1, 0, a));
        const auto moment = sum.at_time(0);
        EXPECT_NEAR(1.0 + moment.at(0, 0).strain_xx, table.number(r, "J_crest"), 1e-9);
        EXPECT_NEAR(1.0 + moment.at(5, 0).strain_xx, table.number(r, "J_trough"), 1e-9);
        // Harmonics of the Eulerian profile: integrals over the label X, dx = J dX.
        double mean = 0, b[5] = {};
        const int n = 4096;
        for (int i = 0; i < n; ++i) {
            const LagrangianPoint p = moment.at(10.0 * i / n, 0.0);
            const double x = 10.0 * i / n + p.displacement_x;
            const double weight = (1.0 + p.strain_xx) / n;
            mean += p.height * weight;
            for (int m = 1; m <= 4; ++m)
                b[m] += 2.0 * p.height * std::cos(m * k * x) * weight;
        }
        EXPECT_NEAR(mean / a, table.number(r, "mean/a"), 1e-9);
        for (int m = 1; m <= 4; ++m)
            EXPECT_NEAR(b[m] / a, table.number(r, "b" + std::to_string(m) + "/a"), 1e-9);
    }
}

TEST(Reference, rates_slopes_and_strains_are_derivatives) {
    const auto sea = testing::realized(windy_sea(), testing::three_cascades);
    const DirectSum sum(sea);
    const TimeUs t = us_from_seconds(100.0);
    const double h = 1e-3;
    const LagrangianPoint p = sum.at(5, 7, t);
    const LagrangianPoint later = sum.at(5, 7, t + 1000), earlier = sum.at(5, 7, t - 1000);
    const LagrangianPoint east = sum.at(5 + h, 7, t), west = sum.at(5 - h, 7, t);
    const LagrangianPoint north = sum.at(5, 7 + h, t), south = sum.at(5, 7 - h, t);
    const double tolerance = 1e-5; // h^2/6 times third derivatives of order 10, rounding 1e-11/h
    EXPECT_NEAR((later.height - earlier.height) / 2e-3, p.height_rate, tolerance);
    EXPECT_NEAR((later.displacement_x - earlier.displacement_x) / 2e-3, p.displacement_x_rate,
                tolerance);
    EXPECT_NEAR((later.displacement_y - earlier.displacement_y) / 2e-3, p.displacement_y_rate,
                tolerance);
    EXPECT_NEAR((east.height - west.height) / (2 * h), p.slope_x, tolerance);
    EXPECT_NEAR((north.height - south.height) / (2 * h), p.slope_y, tolerance);
    EXPECT_NEAR((east.displacement_x - west.displacement_x) / (2 * h), p.strain_xx, tolerance);
    EXPECT_NEAR((north.displacement_y - south.displacement_y) / (2 * h), p.strain_yy, tolerance);
    EXPECT_NEAR((north.displacement_x - south.displacement_x) / (2 * h), p.strain_xy, tolerance);
    EXPECT_NEAR((east.displacement_y - west.displacement_y) / (2 * h), p.strain_xy, tolerance);
}

// G1, T39: in float, or with k x multiplied out, the sea turns into steps far from the origin.
TEST(Reference, I29_far_away_and_long_after_a_wave_is_where_it_must_be) {
    const double length = 512.0; // a power of two: n * length is exact
    const DirectSum sum(one_wave(length, 64, 7, -5, 1.5, 0.3));
    const TimeUs t = us_from_seconds(1e9);
    for (const double turns : {0.0, 1.0, -1.0, 19531.0, -19531.0}) // 1e7 m
        EXPECT_NEAR(sum.at(100.25 + turns * length, -30.5 - turns * length, t).height,
                    sum.at(100.25, -30.5, t).height, 1e-12);
    // Against the stored frequency in long double: phase reduced in exact integers.
    const Rate rate = sum.sea().cascades[0].rate[(64 - 5) * 64 + 7];
    const long double turns = static_cast<long double>(rate) * 1e15L / 0x1p64L;
    const long double phase =
        2.0L * 3.14159265358979323846L *
        (7.0L * 100.25L / 512.0L + 5.0L * 30.5L / 512.0L - std::remainder(turns, 1.0L));
    EXPECT_NEAR(sum.at(100.25, -30.5, t).height, 1.5 * std::cos(double(phase) + 0.3), 2e-5);
}

TEST(Reference, B2_time_runs_backward_as_well) {
    const DirectSum sum(one_wave(100.0, 64, 2, 0, 1.0));
    const double omega = omega_from_rate(sum.sea().cascades[0].rate[2]);
    for (const double t : {-5.0, -1e6})
        EXPECT_NEAR(sum.at(0, 0, us_from_seconds(t)).height, std::cos(omega * t),
                    std::abs(t) * 1e-12 + 1e-12); // omega * t in double
}

} // namespace
} // namespace seaway::sea
