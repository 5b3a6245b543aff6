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

} // namespace
} // namespace seaway::tests
