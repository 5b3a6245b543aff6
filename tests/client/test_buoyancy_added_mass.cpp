// SPDX-License-Identifier: Apache-2.0
// The water that goes along with a hull.
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>

#include <gtest/gtest.h>

#include "tests/client/floating.h"

namespace seaway::tests {
namespace {

/// Of the body with what it drags along.
double kinetic_j(const Floating& floating) {
    double rows[3][3], along[3], around[3], mass[3], inertia[3];
    for (int i = 0; i < 3; ++i) {
        mass[i] = floating.hull.mass_kg * (1 + floating.hull.added_mass[i]);
        inertia[i] = floating.hull.inertia_kgm2[i] * (1 + floating.hull.added_inertia[i]);
    }
    seaway_rows(floating.body.orientation, rows);
    seaway_along_axes(rows, mass, floating.body.velocity_mps, along);
    seaway_along_axes(rows, inertia, floating.body.angular_velocity_radps, around);
    return 0.5 * (seaway_dot(along, floating.body.velocity_mps) +
                  seaway_dot(around, floating.body.angular_velocity_radps));
}

/// Deep below, lighter than the water and askew: it rises and turns as it does.
struct Rising : Floating {
    Rising() {
        hull.added_mass[0] = 0.1;
        hull.added_mass[1] = 0.6;
        hull.added_mass[2] = 1.2;
        roll_to(30);
        const double pitched[3] = {0, 0.4, 0};
        seaway_turn(body.orientation, pitched);
        body.position_m[2] = -1000;
        body.velocity_mps[0] = 3;
        body.angular_velocity_radps[1] = 0.5;
        body.angular_velocity_radps[2] = 0.2;
    }
};

// Naive: a force changes the velocity along each axis of the body, and velocity is what lasts while it turns: then turning alone makes
// energy, or loses it. By Kirchhoff's equations it does neither.
TEST(Buoyancy, a_body_with_added_mass_that_turns_has_no_more_energy_than_before) {
    Rising canoe;
    const auto energy_j = [&] {
        return kinetic_j(canoe) - (Floating::density_kgpm3 * 8 - canoe.hull.mass_kg) *
                                      SEAWAY_GRAVITY_MPS2 * (canoe.body.position_m[2] + 1000);
    };
    const double before_j = energy_j();
    double most_j = 0;
    for (int i = 0; i < 2400; ++i) { // 10 s
        ASSERT_EQ(canoe.ride(still_water, 0, frame_s / 4), SEAWAY_OK);
        most_j = std::max(most_j, kinetic_j(canoe));
        // Of first order in the step: a thousandth of what comes and goes.
        ASSERT_NEAR(energy_j(), before_j, 0.01 * most_j) << i;
    }
    EXPECT_GT(most_j, 20 * before_j);
}

// Naive: a part of a step is as long as hydrostatics allow. At 60 steps a second Munk's moment then leaves it spinning by 9.6 rad/s.
TEST(Buoyancy, added_mass_turns_a_body_as_far_in_long_steps_as_in_short_ones) {
    const auto spin_radps = [](double step_s) {
        Rising canoe;
        for (int i = 0; i < static_cast<int>(std::lround(10 / step_s)); ++i)
            EXPECT_EQ(canoe.ride(still_water, 0, step_s), SEAWAY_OK);
        return seaway_length(canoe.body.angular_velocity_radps);
    };
    const double limit_radps = spin_radps(1.0 / 3840); // 3.0
    // It has turned a few times around: of first order in parts of an eighth of a radian, a tenth.
    for (const double step_s : {0.5, 0.1, 1.0 / 60})
        EXPECT_NEAR(spin_radps(step_s), limit_radps, 0.15 * limit_radps) << step_s;
}

// Naive: momentum over ground. Water that takes a hull along turns it by nothing.
TEST(Buoyancy, a_hull_that_drifts_with_the_water_keeps_its_course) {
    for (const double spin_radps : {0.0, 0.2}) {
        Floating boat;
        boat.hull.added_mass[0] = 0.05;
        boat.hull.added_mass[1] = 0.9;
        boat.hull.added_mass[2] = 1.0;
        boat.body.velocity_mps[0] = 2;
        boat.body.velocity_mps[1] = 1;
        boat.body.angular_velocity_radps[2] = spin_radps;
        const auto current = [](const seaway_point&) {
            return seaway_answer{0, {0, 0, 1}, {2, 1, 0}, 0, 0, 0};
        };
        for (int i = 0; i < 3600; ++i)
            ASSERT_EQ(boat.ride(current, 0, frame_s), SEAWAY_OK);
        EXPECT_NEAR(boat.body.velocity_mps[0], 2, 1e-6);
        EXPECT_NEAR(boat.body.velocity_mps[1], 1, 1e-6);
        EXPECT_NEAR(boat.body.angular_velocity_radps[2], spin_radps, 1e-6);
    }
}

// Naive: velocities last where the box dips in as well, and the water that it takes along from then on is fast for nothing: it got
// 12 m/s within ten minutes from a fall of 1.5 m.
TEST(Buoyancy, a_box_with_added_mass_that_was_dropped_askew_gets_no_faster_whatever_the_step) {
    for (const double step_s : {1.0 / 240, 1.0 / 60, 0.1, 1.0})
        for (const double drag : {0.0, 1.0, 10.0}) {
            Floating box;
            box.hull.added_mass[2] = 0.8;
            box.hull.linear_drag = drag;
            box.roll_to(25);
            const double pitched[3] = {0, 0.4, 0};
            seaway_turn(box.body.orientation, pitched);
            box.body.position_m[2] = 1.5;
            for (int i = 0; i < static_cast<int>(600 / step_s); ++i) {
                ASSERT_EQ(box.ride(still_water, 0, step_s), SEAWAY_OK);
                // It falls 2 m until it floats: sqrt(2 g 2 m) is 6.3 m/s. It rises no higher than it was, nor dives deeper.
                ASSERT_LT(seaway_length(box.body.velocity_mps), 6.3) << step_s << ' ' << drag;
                ASSERT_LT(std::abs(box.body.position_m[2]), 1.51) << step_s << ' ' << drag;
            }
        }
}

/// Long waves and short ones on them, as steep as they come, from several sides.
seaway_answer short_waves(const seaway_point& at) {
    constexpr double amplitude_m[4] = {6, 3, 1, 0.3}, k_radpm[4] = {0.03, 0.06, 0.2, 0.7},
                     direction_rad[4] = {0, 0.4, -0.7, 1.2};
    seaway_answer water{0, {0, 0, 1}, {0, 0, 0}, 0, 0, 0};
    for (int i = 0; i < 4; ++i) {
        const double kx = k_radpm[i] * std::cos(direction_rad[i]);
        const double ky = k_radpm[i] * std::sin(direction_rad[i]);
        const double omega = std::sqrt(SEAWAY_GRAVITY_MPS2 * k_radpm[i]);
        const double phase =
            kx * at.x_m + ky * at.y_m - omega * 1e-6 * static_cast<double>(at.time_us) + i;
        water.height_m += amplitude_m[i] * std::cos(phase);
        water.normal[0] += amplitude_m[i] * kx * std::sin(phase);
        water.normal[1] += amplitude_m[i] * ky * std::sin(phase);
        water.velocity_mps[0] += amplitude_m[i] * omega * kx / k_radpm[i] * std::cos(phase);
        water.velocity_mps[1] += amplitude_m[i] * omega * ky / k_radpm[i] * std::cos(phase);
        water.velocity_mps[2] += amplitude_m[i] * omega * std::sin(phase);
    }
    const double length = seaway_length(water.normal);
    for (double& part : water.normal)
        part /= length;
    return water;
}

// Naive: parts as long as hydrostatics allow and added mass that comes for nothing: a pole spun by 1e6 rad/s.
TEST(Buoyancy, a_slender_hull_with_added_mass_is_not_spun_by_long_steps) {
    const double sizes_m[2][3] = {{1, 0.3, 0.2}, {0.5, 0.06, 0.04}};
    for (const auto& [length_m, beam_m, height_m] : sizes_m) {
        Floating pole;
        seaway_box(length_m, beam_m, height_m, pole.vertices_m, pole.triangles);
        const double square_m2[3] = {length_m * length_m, beam_m * beam_m, height_m * height_m};
        pole.hull.mass_kg = 0.5 * Floating::density_kgpm3 * length_m * beam_m * height_m;
        for (int i = 0; i < 3; ++i)
            pole.hull.inertia_kgm2[i] =
                pole.hull.mass_kg / 12 * (square_m2[(i + 1) % 3] + square_m2[(i + 2) % 3]);
        const double added_mass[3] = {0.1, 1, 1};
        std::copy_n(added_mass, 3, pole.hull.added_mass);
        for (const double drag : {0.0, 0.1})
            for (const double step_s : {1.0 / 60, 0.1, 0.5}) {
                pole.hull.quadratic_drag = drag;
                pole.body = {{0, 0, 0}, {1, 0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
                double fastest_mps = 0; // of an edge
                for (int i = 0; i < static_cast<int>(60 / step_s); ++i) {
                    ASSERT_EQ(pole.ride(short_waves, i * step_s, step_s), SEAWAY_OK);
                    fastest_mps =
                        std::max(fastest_mps, std::hypot(beam_m, height_m) / 2 *
                                                  seaway_length(pole.body.angular_velocity_radps));
                }
                // Nothing takes away what waves push into a pole without drag: 6 m/s at most, as water and poles move, in steps
                // of any length. A tenth of what slows a blunt one leaves 2 m/s.
                EXPECT_LT(fastest_mps, drag > 0 ? 4 : 12)
                    << length_m << ' ' << drag << ' ' << step_s;
            }
    }
}

// Naive: added mass resists and is not pushed: a float on a swell went half as far to and fro as the water around it.
TEST(Buoyancy, a_small_float_goes_to_and_fro_with_a_long_wave_whatever_water_it_takes_along) {
    constexpr double amplitude_m = 0.1, k = 2 * M_PI / 100, omega = 0.7851; // sqrt(g k)
    const auto wave = [](const seaway_point& at) {
        const double phase = k * at.x_m - omega * 1e-6 * static_cast<double>(at.time_us);
        const double slope = -amplitude_m * k * std::sin(phase), length = std::hypot(1, slope);
        const double speed_mps = amplitude_m * omega;
        return seaway_answer{amplitude_m * std::cos(phase),
                             {-slope / length, 0, 1 / length},
                             {speed_mps * std::cos(phase), 0, speed_mps * std::sin(phase)},
                             0,
                             0,
                             0};
    };
    for (const double added : {0.0, 0.5, 2.0}) {
        Floating box;
        box.hull.added_mass[0] = box.hull.added_mass[1] = added;
        box.hull.linear_drag = 20; // what it began with dies away in a minute
        std::complex<double> surge = 0;
        const int steps = static_cast<int>(std::lround(20 * 2 * M_PI / omega / frame_s));
        for (int i = -steps; i < steps; ++i) {
            if (i >= 0)
                surge += box.body.velocity_mps[0] *
                         std::polar(2.0 / steps, omega * i * frame_s - k * box.body.position_m[0]);
            ASSERT_EQ(box.ride(wave, i * frame_s, frame_s), SEAWAY_OK);
        }
        // A box of 4 m: a wave of 100 m is the same over it but for (k length)^2 / 24, 0.3 %.
        EXPECT_NEAR(std::abs(surge) / (amplitude_m * omega), 1, 0.01) << added;
    }
}

/// Columns of 0.2 x 0.2 m that fill the box.
struct Columns : Floating {
    std::vector<double> points_m, volumes_m3;

    Columns() {
        for (int i = 0; i < 200; ++i) {
            points_m.insert(points_m.end(), {-1.9 + 0.2 * (i % 20), -0.9 + 0.2 * (i / 20), 0});
            volumes_m3.push_back(0.04);
        }
        hull.vertices_m = points_m.data();
        hull.vertex_count = volumes_m3.size();
        hull.volumes_m3 = volumes_m3.data();
        hull.column_m = height_m;
        hull.triangle_count = 0;
    }
};

// Naive: a column dips as fast as the water rises, whatever slope it moves into, and takes its water along for nothing: twice the
// momentum. Pressure takes a part of it on the way; the shapes agree but for what lies within a column.
TEST(Buoyancy, columns_and_the_mesh_of_one_box_keep_the_same_momentum_flying_into_a_slope) {
    const auto momentum_kgmps = [](Floating& box, double slope) {
        std::fill_n(box.hull.added_mass, 3, 1.0);
        box.body.velocity_mps[0] = 20;
        box.body.position_m[2] = 0.51 + 2 * slope;
        const double length = std::hypot(1, slope);
        const auto water = [&](const seaway_point& at) -> seaway_answer {
            return {slope * at.x_m, {-slope / length, 0, 1 / length}, {0, 0, 0}, 0, 0, 0};
        };
        while (box.load(water).submerged_m3 < 4)
            EXPECT_EQ(box.ride(water, 0, 1.0 / 2000), SEAWAY_OK);
        return 2 * box.hull.mass_kg * box.body.velocity_mps[0];
    };
    for (const double slope : {0.0, 0.3, 0.6}) {
        Floating mesh;
        Columns columns;
        const double of_mesh = momentum_kgmps(mesh, slope);
        EXPECT_NEAR(momentum_kgmps(columns, slope), of_mesh, 0.03 * of_mesh) << slope;
        EXPECT_LT(of_mesh, 1.005 * Floating::mass_kg * 20);
    }
}

// Water that breaks is a cliff between two corners of a hull, which dips an end into it. A weighted mean of what pressure does to the
// hull alone and of what the steepest water does to water is the most that it can do with added mass.
TEST(Buoyancy, added_mass_lets_no_water_throw_a_hull_harder) {
    for (const double cliff_m : {0.0, 0.1, 2.0, 50.0})
        for (const double dips_m : {1e-9, 1e-3, 0.5, 3.0}) {
            const auto thrown_mps = [&](double added) {
                Floating box;
                box.hull.added_mass[0] = box.hull.added_mass[1] = box.hull.added_mass[2] = added;
                box.body.position_m[2] = Floating::height_m / 2 + cliff_m - dips_m;
                const double slope = 0.999;
                EXPECT_EQ(box.ride(
                              [&](const seaway_point& at) {
                                  return seaway_answer{at.x_m > 0 ? cliff_m : 0,
                                                       {-slope, 0, std::sqrt(1 - slope * slope)},
                                                       {0, 0, 0},
                                                       0,
                                                       0,
                                                       0};
                              },
                              0, 1e-3), // one part
                          SEAWAY_OK);
                return std::abs(box.body.velocity_mps[0]);
            };
            const double steepest_mps = SEAWAY_GRAVITY_MPS2 * SEAWAY_SLOPE_MAX * 1e-3;
            for (const double added : {1.0, 30.0})
                EXPECT_LE(thrown_mps(added), std::max(thrown_mps(0), steepest_mps) * (1 + 1e-9))
                    << cliff_m << ' ' << dips_m << ' ' << added;
        }
}

} // namespace
} // namespace seaway::tests
