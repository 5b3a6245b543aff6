// SPDX-License-Identifier: Apache-2.0
// Hulls that much slows, or nothing.
#include <algorithm>
#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/client/floating.h"

namespace seaway::tests {
namespace {

constexpr double frame_s = 1.0 / 60;

// Naive: force and torque are divided each by its own, though what lies off the centre pulls along and around.
TEST(Buoyancy, drag_far_off_the_centre_slows_a_body_and_never_turns_it_back) {
    const double point_m[3] = {0, 0, -1}, volume_m3 = 0.2;
    for (const double drag : {100.0, 1e4, 1e5, 1e6, 1e9}) {
        Floating light;
        light.hull.mass_kg = 100;
        std::fill_n(light.hull.inertia_kgm2, 3, 100.0);
        light.hull.linear_drag = drag;
        light.hull.vertices_m = point_m;
        light.hull.vertex_count = 1;
        light.hull.triangle_count = 0;
        light.hull.volumes_m3 = &volume_m3;
        light.hull.column_m = 1;
        light.body.position_m[2] = 1;
        light.body.velocity_mps[0] = 1;
        light.body.angular_velocity_radps[1] = -1;
        ASSERT_EQ(light.ride(still_water, 0, frame_s), SEAWAY_OK);
        EXPECT_GE(light.body.velocity_mps[0], 0) << drag;
        EXPECT_LE(light.body.velocity_mps[0], 1) << drag;
    }
}

// Naive: a part turns by what the inertia is at its beginning, and each adds to the spin. Without drag and added mass what water
// and weight do is conservative: kinetic energy comes and goes, and its highest does not grow.
TEST(Buoyancy, a_box_that_nothing_slows_rolls_and_pitches_for_ever_and_no_faster) {
    Floating box; // made a beam of 4 x 1 x 1 m, which tumbles most
    seaway_box(4, 1, 1, box.vertices_m, box.triangles);
    box.hull.mass_kg = 2000;
    for (int i = 0; i < 3; ++i)
        box.hull.inertia_kgm2[i] = 2000.0 / 12 * (i == 0 ? 2 : 17);
    box.roll_to(29);
    const double pitched[3] = {0, 0.3, 0};
    seaway_turn(box.body.orientation, pitched);
    const auto energy_j = [&] {
        double rows[3][3], momentum[3];
        seaway_rows(box.body.orientation, rows);
        seaway_along_axes(rows, box.hull.inertia_kgm2, box.body.angular_velocity_radps, momentum);
        double twice = 0;
        for (int i = 0; i < 3; ++i)
            twice += momentum[i] * box.body.angular_velocity_radps[i] +
                     box.hull.mass_kg * box.body.velocity_mps[i] * box.body.velocity_mps[i];
        return 0.5 * twice;
    };
    std::array<double, 6> most_j{};
    for (double& most : most_j) // of 100 s each
        for (int i = 0; i < 6000; ++i) {
            ASSERT_EQ(box.ride(still_water, 0, frame_s), SEAWAY_OK);
            most = std::max(most, energy_j());
        }
    // Modes exchange what they have: some tenths from one span to the next.
    for (const double most : most_j)
        EXPECT_NEAR(most, most_j[0], 0.3 * most_j[0]);
}

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

// Naive: a force changes the velocity along each axis of the body, and velocity is what lasts while it turns: then turning alone makes
// energy, or loses it. By Kirchhoff's equations it does neither.
TEST(Buoyancy, a_body_with_added_mass_that_turns_has_no_more_energy_than_before) {
    Floating canoe;
    canoe.hull.added_mass[0] = 0.1;
    canoe.hull.added_mass[1] = 0.6;
    canoe.hull.added_mass[2] = 1.2;
    canoe.roll_to(30);
    const double pitched[3] = {0, 0.4, 0};
    seaway_turn(canoe.body.orientation, pitched);
    canoe.body.position_m[2] = 1e5; // far above the water
    canoe.body.velocity_mps[0] = 3;
    canoe.body.angular_velocity_radps[1] = 0.5;
    canoe.body.angular_velocity_radps[2] = 0.2;
    const auto energy_j = [&] {
        return kinetic_j(canoe) +
               canoe.hull.mass_kg * SEAWAY_GRAVITY_MPS2 * (canoe.body.position_m[2] - 1e5);
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

// It got 50 m/s from a fall of 1.5 m.
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
                // It has fallen 2 m until it floats: 6 m/s if all of that went into the lightest direction.
                ASSERT_LT(seaway_length(box.body.velocity_mps), 6) << step_s << ' ' << drag;
                ASSERT_LT(std::abs(box.body.position_m[2]), 2.1) << step_s << ' ' << drag;
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

// Naive: parts are as short as the water's push asks, not Munk's moment: at 60 steps a second a pole spun by 1e6 rad/s.
TEST(Buoyancy, a_slender_hull_with_added_mass_and_no_drag_spins_no_faster_than_short_steps_say) {
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
        double fastest_radps = 0;
        for (int i = 0; i < 60 * 120; ++i) {
            ASSERT_EQ(pole.ride(short_waves, i * frame_s, frame_s), SEAWAY_OK);
            fastest_radps =
                std::max(fastest_radps, seaway_length(pole.body.angular_velocity_radps));
        }
        // With 600 steps a second it is 73 and 55: nothing takes away what waves push in. Twice that, and some.
        EXPECT_LT(fastest_radps, 200) << length_m;
    }
}

// Naive: whoever needs many parts weighs nothing.
TEST(Buoyancy, a_slender_hull_is_refused_steps_that_are_too_long_for_it) {
    Floating canoe;
    seaway_box(6, 0.8, 0.35, canoe.vertices_m, canoe.triangles);
    canoe.hull.mass_kg = 110;
    const double square_m2[3] = {36, 0.64, 0.1225};
    for (int i = 0; i < 3; ++i)
        canoe.hull.inertia_kgm2[i] = 110.0 / 12 * (square_m2[(i + 1) % 3] + square_m2[(i + 2) % 3]);
    ASSERT_EQ(seaway_hull_fault(&canoe.hull), nullptr);
    EXPECT_EQ(canoe.ride(still_water, 0, 1), SEAWAY_BAD_ARGUMENT);
    EXPECT_EQ(canoe.body.velocity_mps[2], 0);
    EXPECT_EQ(canoe.ride(still_water, 0, 0.5), SEAWAY_OK);
    EXPECT_NE(canoe.body.velocity_mps[2], 0);
}

} // namespace
} // namespace seaway::tests
