// SPDX-License-Identifier: Apache-2.0
// Hulls that much slows, or nothing.
#include <algorithm>
#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/client/floating.h"

namespace seaway::tests {
namespace {

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

// Naive: with the inertia of one look half of the way it gains 4 to 60 % within five minutes, towards the axis of the least.
TEST(Buoyancy, a_spin_in_the_air_keeps_its_energy) {
    for (const double spin_radps : {2.0, 8.0, 20.0}) {
        Floating box;
        const double about[3] = {1, 0.3, 0.1};
        for (int i = 0; i < 3; ++i)
            box.body.angular_velocity_radps[i] = spin_radps * about[i];
        const auto energy_j = [&] {
            double rows[3][3], momentum[3];
            seaway_rows(box.body.orientation, rows);
            seaway_along_axes(rows, box.hull.inertia_kgm2, box.body.angular_velocity_radps,
                              momentum);
            return 0.5 * seaway_dot(momentum, box.body.angular_velocity_radps);
        };
        const double before_j = energy_j();
        for (int i = 0; i < 300 * 60; ++i) {
            box.body.position_m[2] = 1e6;
            ASSERT_EQ(box.ride(still_water, 0, frame_s), SEAWAY_OK);
        }
        EXPECT_NEAR(energy_j(), before_j, 0.01 * before_j) << spin_radps;
    }
}

// Naive: a thousandth of the smallest number is 0, and so is the part of a step of what spins beyond all numbers: it never ends.
TEST(Buoyancy, steps_of_any_length_of_any_spin_end) {
    for (const double step_s : {1e-321, 1.0 / 60, 1.0})
        for (const double spin_radps : {0.0, 1e5, 1e200, std::nan("")}) {
            Floating box;
            box.body.angular_velocity_radps[1] = spin_radps;
            const seaway_code code = box.ride(still_water, 0, step_s);
            EXPECT_TRUE(spin_radps < 1e100 ? code == SEAWAY_OK
                                           : code == SEAWAY_BAD_ARGUMENT || step_s < 1e-300)
                << spin_radps << ' ' << step_s << ' ' << code;
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

// Naive: a panel's drag stands in its middle, which a face of two triangles that turns about its own has at a third of what it is.
TEST(Buoyancy, linear_drag_is_that_of_what_moves_along_normals_over_all_of_a_face) {
    Floating box;
    box.hull.linear_drag = 100;
    box.body.position_m[2] = -10;
    box.body.velocity_mps[0] = 2;
    box.body.angular_velocity_radps[2] = 0.3;
    const seaway_load load = box.load(still_water);
    constexpr double length = Floating::length_m, beam = Floating::beam_m,
                     high = Floating::height_m;
    // The two ends meet the flow. Sides, deck and bottom slide along it.
    EXPECT_NEAR(load.drag_n[0], -100 * 2 * 2 * beam * high, 1e-9);
    // The integral of an arm's square over a face is side^3 / 12, of four faces.
    const double arms_m4 = 2 * high * (std::pow(length, 3) + std::pow(beam, 3)) / 12;
    EXPECT_NEAR(load.drag_nm[2], -100 * 0.3 * arms_m4, 1e-9);
}

TEST(Buoyancy, a_cube_of_quadratic_drag_one_half_has_the_drag_of_a_cube) {
    Floating cube;
    seaway_box(1, 1, 1, cube.vertices_m, cube.triangles);
    cube.hull.quadratic_drag = 0.5;
    cube.body.position_m[2] = -10;
    cube.body.velocity_mps[0] = 2;
    const seaway_load load = cube.load(still_water);
    // Measured is 1.05 (Hoerner, Fluid-Dynamic Drag, 3-17).
    EXPECT_NEAR(-load.drag_n[0] / (0.5 * Floating::density_kgpm3 * 4), 1.05, 0.15 * 1.05);
}

TEST(Buoyancy, drag_takes_energy_however_a_hull_moves) {
    Floating box;
    box.hull.linear_drag = 100;
    box.hull.quadratic_drag = 1;
    for (int i = 0; i < 1000; ++i) {
        const double turn[3] = {std::sin(i), std::sin(2.0 * i), std::sin(3.0 * i)};
        seaway_turn(box.body.orientation, turn);
        for (int axis = 0; axis < 3; ++axis) {
            box.body.velocity_mps[axis] = 5 * std::sin(5.0 * i + axis);
            box.body.angular_velocity_radps[axis] = 3 * std::sin(7.0 * i * (axis + 1));
        }
        const seaway_load load = box.load(still_water);
        EXPECT_LT(seaway_dot(load.drag_n, box.body.velocity_mps) +
                      seaway_dot(load.drag_nm, box.body.angular_velocity_radps),
                  0)
            << i;
    }
}

// Naive: weight is not slowed with the drag that bears it, and long steps sink faster.
TEST(Buoyancy, what_sinks_has_its_terminal_speed_in_steps_of_any_length) {
    for (const double step_s : {1.0 / 240, 0.1, 1.0}) {
        Floating cube;
        seaway_box(1, 1, 1, cube.vertices_m, cube.triangles);
        cube.hull.mass_kg = 1200;
        cube.hull.quadratic_drag = 0.5;
        cube.body.position_m[2] = -10;
        for (int i = 0; i < 20 / step_s; ++i)
            ASSERT_EQ(cube.ride(still_water, 0, step_s), SEAWAY_OK);
        // 200 kg in water are borne by density / 2 * v^2 m2.
        EXPECT_NEAR(cube.body.velocity_mps[2], -std::sqrt(2 * 0.2 * SEAWAY_GRAVITY_MPS2), 1e-6)
            << step_s;
    }
}

} // namespace
} // namespace seaway::tests
