// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "sea/basics/dispersion.h"
#include "tests/sea/csv.h"

namespace seaway::sea {
namespace {

using testing::Table;

Dispersion gravity_waves(double depth_m) {
    return {9.81, 0.0, depth_m};
}

TEST(Dispersion, D01_wavelength_speed_and_group_speed_match_the_table) {
    const Table table("D01_dispersion_table");
    for (std::size_t r = 0; r < table.size(); ++r) {
        const Dispersion d = gravity_waves(table.number(r, "depth_m"));
        const double omega = two_pi / table.number(r, "T_s");
        const double k = d.wavenumber(omega);
        // k is printed to 15 digits, L, C and Cg to 12: half a unit of the last is up to 5e-12.
        EXPECT_NEAR(k / table.number(r, "k_rad_m"), 1.0, 1e-12);
        EXPECT_NEAR(two_pi / k / table.number(r, "L_m"), 1.0, 5e-12);
        EXPECT_NEAR(omega / k / table.number(r, "C_m_s"), 1.0, 5e-12);
        EXPECT_NEAR(d.group_speed(k) / table.number(r, "Cg_m_s"), 1.0, 5e-12);
    }
}

TEST(Dispersion, D02_relative_depth_and_shoaling_match_the_table) {
    const Table table("D02_spm_table_c1");
    for (std::size_t r = 0; r < table.size(); ++r) {
        const double depth = table.number(r, "d_over_L0"); // L0 = 1 m: omega^2 = 2 pi g
        const Dispersion d = gravity_waves(depth);
        const double omega = std::sqrt(two_pi * 9.81);
        const double k = d.wavenumber(omega);
        // The table has 8 digits: half a unit of the last is 5e-8 of the smallest leading digits.
        EXPECT_NEAR(k * depth / two_pi / table.number(r, "d_over_L"), 1.0, 1e-7);
        EXPECT_NEAR(k * depth / table.number(r, "kd"), 1.0, 1e-7);
        EXPECT_NEAR(std::tanh(k * depth) / table.number(r, "tanh_kd"), 1.0, 1e-7);
        const double n = d.group_speed(k) * k / omega;
        EXPECT_NEAR(n / table.number(r, "n"), 1.0, 1e-7);
        const double deep_speed = 9.81 / omega;
        EXPECT_NEAR(d.group_speed(k) / deep_speed / table.number(r, "Cg_over_C0"), 1.0, 1e-7);
        EXPECT_NEAR(std::sqrt(0.5 * deep_speed / d.group_speed(k)) / table.number(r, "H_over_H0"),
                    1.0, 1e-7);
    }
}

TEST(Dispersion, D03_surface_tension_matches_the_table) {
    const Table table("D03_dispersion_capillary");
    for (std::size_t r = 0; r < table.size(); ++r) {
        const Dispersion d{9.81, 7.4e-5, table.number(r, "depth_m")};
        const double k = table.number(r, "k_rad_m");
        EXPECT_NEAR(d.omega(k) / table.number(r, "omega_rad_s"), 1.0, 1e-12);
        EXPECT_NEAR(d.group_speed(k) / table.number(r, "domega_dk_m_s"), 1.0, 2e-12);
        EXPECT_NEAR(d.wavenumber(d.omega(k)) / k, 1.0, 1e-12);
    }
}

TEST(Dispersion, P05_wafo_wavenumbers_match) {
    const Table table("P05_wafo_moments_dispersion");
    int rows = 0;
    for (std::size_t r = 0; r < table.size(); ++r) {
        const std::string& params = table.text(r, "params");
        const double depth = params.find("h=20") != std::string::npos ? 20.0 : deep_water_m;
        const double argument = std::strtod(params.c_str() + (params.find('=') + 1), nullptr);
        const double tolerance = table.number(r, "rel_tol");
        const Dispersion d = gravity_waves(depth);
        if (table.text(r, "quantity") == "omega(k)")
            EXPECT_NEAR(d.omega(argument) / table.number(r, "value"), 1.0, tolerance);
        else if (table.text(r, "quantity") == "k(omega)")
            EXPECT_NEAR(d.wavenumber(argument) / table.number(r, "value"), 1.0, tolerance);
        else
            continue;
        ++rows;
    }
    EXPECT_EQ(rows, 11);
}

TEST(Dispersion, P06_mhkit_wavenumbers_match) {
    const Table table("P06_mhkit_dispersion");
    for (std::size_t r = 0; r < table.size(); ++r) {
        const Dispersion d = gravity_waves(table.number(r, "depth_m"));
        EXPECT_NEAR(d.wavenumber(table.number(r, "omega_rad_s")) / table.number(r, "k_rad_m"), 1.0,
                    1e-6);
    }
}

// Naive: cosh(kd) overflows, sinh(2kd)/cosh^2 is inf/inf.
TEST(Dispersion, A6_A7_nothing_overflows_from_a_puddle_to_the_trench) {
    for (const double depth : {1e-2, 1.0, 120.0, 1.1e4, deep_water_m})
        for (double k = 1e-8; k < 1e8; k *= 3.0) {
            const Dispersion d{9.81, 7.4e-5, depth};
            ASSERT_TRUE(std::isfinite(d.omega(k)) && d.omega(k) > 0.0) << depth << " " << k;
            ASSERT_TRUE(std::isfinite(d.group_speed(k)) && d.group_speed(k) > 0.0);
            // Newton in ln k ends at rounding.
            ASSERT_NEAR(d.wavenumber(d.omega(k)) / k, 1.0, 1e-12) << depth << " " << k;
        }
}

TEST(Dispersion, A6_eleven_kilometres_is_deep_water) {
    const Dispersion trench = gravity_waves(1.1e4);
    const Dispersion deep = gravity_waves(deep_water_m);
    for (double k = 2e-3; k < 1e3; k *= 1.7) {
        EXPECT_NEAR(trench.omega(k) / deep.omega(k), 1.0, 1e-12);
        EXPECT_NEAR(trench.group_speed(k) / deep.group_speed(k), 1.0, 1e-12);
    }
}

TEST(Dispersion, shallow_waves_run_at_sqrt_gd) {
    const Dispersion d = gravity_waves(1.0);
    const double k = two_pi / 200.0; // kd = 0.03: physics.md section 3 asks 0.05 % below 0.05
    EXPECT_NEAR(d.omega(k) / k / std::sqrt(9.81), 1.0, 5e-4);
    EXPECT_DOUBLE_EQ(d.group_speed(0.0), std::sqrt(9.81));
    EXPECT_EQ(d.omega(0.0), 0.0);
}

// Group speed is the derivative of omega.
TEST(Dispersion, group_speed_is_the_slope_of_omega) {
    for (const double depth : {0.1, 3.0, 50.0, deep_water_m})
        for (double k = 1e-3; k < 1e3; k *= 2.3) {
            const Dispersion d{9.81, 7.4e-5, depth};
            const double h = 1e-5 * k;
            // Central difference: truncation 1e-10, rounding 1e-11.
            EXPECT_NEAR((d.omega(k + h) - d.omega(k - h)) / (2 * h) / d.group_speed(k), 1.0, 1e-8);
        }
}

TEST(Dispersion, I25_shallower_water_slows_every_wave) {
    for (double k = 1e-3; k < 100.0; k *= 2.0) {
        double faster = std::numeric_limits<double>::infinity();
        for (const double depth : {1e3, 1e2, 1e1, 1.0, 0.1}) {
            const double omega = gravity_waves(depth).omega(k);
            EXPECT_LE(omega, faster);
            faster = omega;
        }
    }
}

} // namespace
} // namespace seaway::sea
