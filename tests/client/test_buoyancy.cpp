// SPDX-License-Identifier: Apache-2.0
#include "client/buoyancy.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "sea/basics/constants.h"
#include "tests/client/floating.h"

namespace seaway::tests {
namespace {

constexpr double weight_npm3 = Floating::density_kgpm3 * SEAWAY_GRAVITY_MPS2;

TEST(Buoyancy, gravity_is_that_of_the_waves) {
    EXPECT_EQ(SEAWAY_GRAVITY_MPS2, sea::gravity_default_mps2);
}

TEST(Buoyancy, a_box_floats_at_the_draught_of_archimedes_from_wherever_it_is_dropped) {
    for (const double dropped_m : {-3.0, 0.2, 2.0}) {
        Floating box;
        box.hull.linear_drag = 500;
        box.hull.quadratic_drag = 1;
        box.body.position_m[2] = dropped_m;
        for (int i = 0; i < 120 * 60; ++i)
            ASSERT_EQ(box.ride(still_water, i * frame_s, frame_s), SEAWAY_OK);
        const double draught_m = Floating::height_m / 2 - box.body.position_m[2];
        const double archimedes_m =
            Floating::mass_kg / (Floating::density_kgpm3 * Floating::length_m * Floating::beam_m);
        // What is promised; what is left of the heave after two minutes is far less.
        EXPECT_NEAR(draught_m, archimedes_m, 0.01 * archimedes_m) << dropped_m;
    }
}

TEST(Buoyancy, a_box_rights_itself_from_30_degrees) {
    Floating box;
    box.hull.linear_drag = 500;
    box.hull.quadratic_drag = 1;
    box.roll_to(30);
    double farthest_deg = 0;
    for (int i = 0; i < 60 * 60; ++i) {
        ASSERT_EQ(box.ride(still_water, i * frame_s, frame_s), SEAWAY_OK);
        farthest_deg = std::max(farthest_deg, box.lean_deg());
    }
    EXPECT_LT(box.lean_deg(), 0.5); // damped: it has come to rest
    EXPECT_LT(farthest_deg, 30.1);  // it swings to the other side, never further than it came from
}

struct Heave {
    double period_s;
    double decrement; ///< logarithm of what is left of it after a period
};

/// Of ten swings after it was let go 0.05 m too deep.
Heave heave_of(Floating& box) {
    box.body.position_m[2] = -0.05;
    std::vector<double> crossings_s;
    double last_m = box.body.position_m[2];
    std::vector<double> troughs_m{-0.05};
    double lowest_m = 0;
    for (int i = 0; crossings_s.size() < 11 && i < 36'000; ++i) {
        EXPECT_EQ(box.ride(still_water, i * frame_s, frame_s), SEAWAY_OK);
        const double now_m = box.body.position_m[2];
        lowest_m = std::min(lowest_m, now_m);
        if (last_m < 0 && now_m >= 0) {
            crossings_s.push_back((i + last_m / (last_m - now_m)) * frame_s);
            troughs_m.push_back(lowest_m);
            lowest_m = 0;
        }
        last_m = now_m;
    }
    if (crossings_s.size() < 11)
        return {0, 0}; // it does not heave
    return {(crossings_s[10] - crossings_s[0]) / 10, std::log(troughs_m[1] / troughs_m[11]) / 10};
}

TEST(Buoyancy, heave_has_the_period_and_the_decay_of_its_equation) {
    for (const double added : {0.0, 0.8}) {
        Floating box;
        box.hull.added_mass[2] = added;
        box.hull.linear_drag = 60;
        const Heave heave = heave_of(box);
        // (m + a33) z'' + b33 z' + c33 z = 0: T = 2 pi / sqrt(c/M - (b/2M)^2), decrement b T / 2M.
        const double moved_kg = Floating::mass_kg * (1 + added);
        const double c33 = weight_npm3 * Floating::length_m * Floating::beam_m;
        const double bottom_m2 = 8; // the sides slide along
        const double b33 = box.hull.linear_drag * bottom_m2;
        const double damped = b33 / (2 * moved_kg);
        const double period_s = 2 * M_PI / std::sqrt(c33 / moved_kg - damped * damped);
        // Promised are 5 %; parts of a step of 1/60 s miss less than 1 %.
        EXPECT_NEAR(heave.period_s, period_s, 0.01 * period_s) << added;
        // Backward Euler of a step of 1/60 s has its own part of it: 5 %.
        EXPECT_NEAR(heave.decrement, damped * period_s, 0.05 * damped * period_s) << added;
    }
}

/// Volume below z = 0 of a leaning box and its middle, by cells.
struct Cells {
    double volume_m3 = 0;
    double moment_m4[3] = {0, 0, 0};
};

Cells cells_below(const Floating& box, int a_side) {
    Cells cells;
    double rows[3][3];
    seaway_rows(box.body.orientation, rows);
    const double cell_m3 = 8.0 / a_side / a_side / a_side;
    for (int i = 0; i < a_side * a_side * a_side; ++i) {
        const int cell[3] = {i % a_side, i / a_side % a_side, i / a_side / a_side};
        const double size_m[3] = {Floating::length_m, Floating::beam_m, Floating::height_m};
        double at[3];
        for (int axis = 0; axis < 3; ++axis)
            at[axis] = size_m[axis] * ((cell[axis] + 0.5) / a_side - 0.5);
        double arm_m[3];
        seaway_to_world(rows, at, arm_m);
        if (arm_m[2] + box.body.position_m[2] > 0)
            continue;
        cells.volume_m3 += cell_m3;
        seaway_add(cells.moment_m4, cell_m3, arm_m);
    }
    return cells;
}

TEST(Buoyancy, force_and_torque_are_those_of_the_displaced_water_at_any_attitude) {
    for (const double z_m : {-0.9, -0.2, 0.3})
        for (const double turn : {0.0, 0.4, 1.1, 2.9}) {
            Floating box;
            box.body.position_m[2] = z_m;
            const double about[3] = {turn, -0.7 * turn, 0.3};
            seaway_turn(box.body.orientation, about);
            const seaway_load load = box.load(still_water);
            const Cells cells = cells_below(box, 80);
            // Cells of 5 x 2.5 x 1.25 cm: a layer of half of one on the waterplane, the signs of which are random.
            EXPECT_NEAR(load.submerged_m3, cells.volume_m3, 0.02) << z_m << ' ' << turn;
            EXPECT_NEAR(load.force_n[2], weight_npm3 * load.submerged_m3, 1e-6);
            EXPECT_NEAR(std::hypot(load.force_n[0], load.force_n[1]), 0, 1e-6); // a closed hull
            EXPECT_NEAR(load.torque_nm[0], weight_npm3 * cells.moment_m4[1], 0.02 * weight_npm3);
            EXPECT_NEAR(load.torque_nm[1], -weight_npm3 * cells.moment_m4[0], 0.04 * weight_npm3);
            EXPECT_NEAR(load.torque_nm[2], 0, 1e-6);
        }
}

TEST(Buoyancy, water_that_slopes_pushes_downhill_by_weight_times_slope) {
    Floating box;
    box.body.position_m[2] = -10;
    const double slope = 0.2;
    const seaway_load load = box.load([&](const seaway_point& at) {
        const double length = std::sqrt(1 + slope * slope);
        return seaway_answer{slope * at.x_m, {-slope / length, 0, 1 / length}, {0, 0, 0}, 0, 0, 0};
    });
    EXPECT_NEAR(load.force_n[0], -slope * weight_npm3 * 8, 1e-6 * weight_npm3);
    EXPECT_NEAR(load.force_n[2], weight_npm3 * 8, 1e-6 * weight_npm3);
}

TEST(Buoyancy, between_samples_the_water_goes_on_by_its_slope_and_as_it_rises) {
    // A slope that runs on: eta = slope (x - speed t), whose water moves along and up as it has to.
    constexpr double slope = 0.1;
    constexpr double speed_mps = 7;
    constexpr double along_mps = 0.5;
    const auto running = [&](double time_s) {
        return [=](const seaway_point& at) {
            const double length = std::sqrt(1 + slope * slope);
            return seaway_answer{slope * (at.x_m - speed_mps * time_s),
                                 {-slope / length, 0, 1 / length},
                                 {along_mps, 0, slope * (along_mps - speed_mps)},
                                 0,
                                 0,
                                 0};
        };
    };
    Floating box;
    box.load(running(0)); // asks where it is
    box.body.position_m[0] = 2;
    box.body.position_m[2] = -0.3;
    seaway_load later;
    seaway_hull_load(&box.hull, &box.body, box.points.data(), box.answers.data(), 0.5, &later);
    const seaway_load asked_again = box.load(running(0.5));
    for (int i = 0; i < 3; ++i) {
        EXPECT_NEAR(later.force_n[i], asked_again.force_n[i], 1e-6);
        EXPECT_NEAR(later.torque_nm[i], asked_again.torque_nm[i], 1e-6);
    }
}

TEST(Buoyancy, a_hull_as_light_as_a_toy_floats_at_ten_steps_a_second) {
    Floating box;
    box.hull.mass_kg = 40; // of 8 m3: it heaves 7 times a second
    for (double& inertia : box.hull.inertia_kgm2)
        inertia *= box.hull.mass_kg / Floating::mass_kg;
    box.hull.linear_drag = 1;
    box.roll_to(5);
    box.body.position_m[2] =
        0.7; // 0.1 m above the water; 25 m is where half of it under water would throw it
    for (int i = 0; i < 600; ++i) {
        ASSERT_EQ(box.ride(still_water, i * 0.1, 0.1), SEAWAY_OK);
        // Not higher than it was dropped from.
        ASSERT_LT(std::abs(box.body.position_m[2]), 1.0) << i;
    }
}

TEST(Buoyancy, sample_points_float_as_deep_as_the_box_that_they_stand_for) {
    const double points_m[12] = {1, 0.5, 0, 1, -0.5, 0, -1, 0.5, 0, -1, -0.5, 0};
    const double volumes_m3[4] = {2, 2, 2, 2};
    Floating box;
    box.hull.vertices_m = points_m;
    box.hull.vertex_count = 4;
    box.hull.triangle_count = 0;
    box.hull.volumes_m3 = volumes_m3;
    box.hull.column_m = Floating::height_m;
    box.hull.linear_drag = 500;
    box.roll_to(20);
    box.body.position_m[2] = 1;
    ASSERT_EQ(seaway_hull_fault(&box.hull), nullptr) << seaway_hull_fault(&box.hull);
    for (int i = 0; i < 120 * 60; ++i)
        ASSERT_EQ(box.ride(still_water, i * frame_s, frame_s), SEAWAY_OK);
    EXPECT_NEAR(box.body.position_m[2], 0, 0.005);
    EXPECT_LT(box.lean_deg(), 0.5);
}

TEST(Buoyancy, drag_of_any_strength_takes_a_body_along_with_the_water_and_not_further) {
    for (const double drag : {10.0, 1e5, 1e12}) {
        Floating box;
        box.hull.linear_drag = drag;
        box.hull.quadratic_drag = drag / 1000;
        const Water stream = [](const seaway_point&) {
            return seaway_answer{0, {0, 0, 1}, {3, -4, 0}, 0, 0, 0};
        };
        for (int i = 0; i < 600; ++i) {
            ASSERT_EQ(box.ride(stream, i * 0.1, 0.1), SEAWAY_OK);
            EXPECT_LE(std::hypot(box.body.velocity_mps[0], box.body.velocity_mps[1]), 5.02) << drag;
        }
        if (drag > 100) {
            EXPECT_NEAR(box.body.velocity_mps[0], 3, 0.03) << drag;
        }
    }
}

// Naive: added mass is a part of the body in the air as well. It falls at half of g, and Munk's moment turns it head over heels.
TEST(Buoyancy, a_body_in_the_air_falls_as_bodies_do_and_keeps_its_spin) {
    Floating box;
    const double added[3] = {0.05, 0.7, 0.9};
    std::copy(added, added + 3, box.hull.added_mass);
    std::copy(added, added + 3, box.hull.added_inertia);
    const Water far_below = [](const seaway_point&) {
        return seaway_answer{-1e6, {0, 0, 1}, {0, 0, 0}, 0, 0, 0};
    };
    const double spin[3] = {0.1, 4, 0.1}; // about the axis that bodies tumble about
    std::copy(spin, spin + 3, box.body.angular_velocity_radps);
    box.body.velocity_mps[0] = 8;
    const auto momentum = [&] {
        double rows[3][3];
        std::array<double, 3> kept{};
        seaway_rows(box.body.orientation, rows);
        seaway_along_axes(rows, box.hull.inertia_kgm2, box.body.angular_velocity_radps,
                          kept.data());
        return kept;
    };
    const std::array<double, 3> before = momentum();
    for (int i = 0; i < 600; ++i)
        ASSERT_EQ(box.ride(far_below, i * frame_s, frame_s), SEAWAY_OK);
    for (size_t i = 0; i < 3; ++i)
        EXPECT_NEAR(momentum()[i], before[i], 1e-9 * before[1]);
    EXPECT_NEAR(box.body.velocity_mps[0], 8, 1e-9);
    EXPECT_NEAR(box.body.velocity_mps[2], -10 * SEAWAY_GRAVITY_MPS2, 1e-9);
}

TEST(Buoyancy, what_cannot_be_moved_is_refused_and_left_as_it_is) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    Floating box;
    const Water none = [&](const seaway_point&) {
        return seaway_answer{nan, {nan, nan, nan}, {nan, nan, nan}, nan, SEAWAY_INVALID, 0};
    };
    EXPECT_EQ(box.ride(none, 0, frame_s), SEAWAY_BAD_ARGUMENT);
    for (int number = 0; number < 7; ++number) { // of the answer that one corner got
        const Water one_is_none = [&, number](const seaway_point& at) {
            seaway_answer answer = still_water(at);
            if (at.x_m > 0 && at.y_m > 0)
                (number == 0  ? answer.height_m
                 : number < 4 ? answer.normal[number - 1]
                              : answer.velocity_mps[number - 4]) = nan;
            return answer;
        };
        EXPECT_EQ(box.ride(one_is_none, 0, frame_s), SEAWAY_BAD_ARGUMENT) << number;
    }
    for (double* of_body : {&box.body.position_m[0], &box.body.velocity_mps[2],
                            &box.body.angular_velocity_radps[1], &box.body.orientation[3]}) {
        const double was = *of_body;
        *of_body = nan;
        EXPECT_EQ(box.ride(still_water, 0, frame_s), SEAWAY_BAD_ARGUMENT);
        *of_body = was;
    }
    for (const double bad_s : {-0.1, 1.1, nan})
        EXPECT_EQ(box.ride(still_water, 0, bad_s), SEAWAY_BAD_ARGUMENT) << bad_s;
    EXPECT_EQ(box.ride(still_water, 0, 0), SEAWAY_OK);
    EXPECT_EQ(box.body.position_m[2], 0);
    box.hull.mass_kg = 1e-9; // a box of 8 m3
    EXPECT_EQ(box.ride(still_water, 0, frame_s), SEAWAY_BAD_ARGUMENT);
    EXPECT_EQ(box.body.position_m[2], 0);
}

// An answer that nobody filled in: of water without a slope a mesh would fall as through air.
TEST(Buoyancy, water_whose_normal_has_no_length_is_refused) {
    Floating box;
    const Water empty = [](const seaway_point&) { return seaway_answer{}; };
    EXPECT_EQ(box.ride(empty, 0, frame_s), SEAWAY_BAD_ARGUMENT);
    EXPECT_EQ(box.body.velocity_mps[2], 0);
}

// Naive: a depth that is no number is not below the water, and the hull falls as through air.
TEST(Buoyancy, points_that_are_no_numbers_are_refused) {
    Floating box;
    ASSERT_EQ(box.ride(still_water, 0, 0.1), SEAWAY_OK);
    for (const double wrong : {std::nan(""), HUGE_VAL}) {
        box.points[5].x_m = wrong;
        EXPECT_EQ(
            seaway_hull_step(&box.hull, &box.body, box.points.data(), box.answers.data(), 0.1),
            SEAWAY_BAD_ARGUMENT);
    }
}

TEST(Buoyancy, a_hull_without_parts_takes_no_step) {
    Floating box;
    box.hull.triangle_count = 0;
    box.hull.volumes_m3 = nullptr;
    box.hull.column_m = 1;
    EXPECT_EQ(box.ride(still_water, 0, frame_s), SEAWAY_BAD_ARGUMENT);
    const std::vector<double> volumes(box.hull.vertex_count, 1.0);
    box.hull.volumes_m3 = volumes.data();
    EXPECT_EQ(box.ride(still_water, 0, frame_s), SEAWAY_OK);
    box.hull.column_m = 0;
    EXPECT_EQ(box.ride(still_water, 0, frame_s), SEAWAY_BAD_ARGUMENT);
    box.hull.triangle_count = 12;
    box.hull.triangles = nullptr;
    EXPECT_EQ(box.ride(still_water, 0, frame_s), SEAWAY_BAD_ARGUMENT);
}

/// Without the two faces that are across this axis.
void open_along(int axis, Floating& box) {
    std::vector<std::uint32_t> left;
    for (size_t i = 0; i < box.hull.triangle_count; ++i) {
        double area_m2[3];
        seaway_triangle(&box.hull, i, area_m2);
        if (area_m2[axis] == 0)
            left.insert(left.end(), box.triangles + 3 * i, box.triangles + 3 * i + 3);
    }
    std::copy(left.begin(), left.end(), box.triangles);
    box.hull.triangle_count = left.size() / 3;
}

// Naive: areas that add up to nothing are taken for a closed mesh: those of a tube do as well.
TEST(Buoyancy, a_hull_without_bow_and_stern_is_not_closed_wherever_it_lies) {
    for (const double away_m : {0.0, 0.5, -3.0, 1e5})
        for (int axis = 0; axis < 3; ++axis) {
            Floating box;
            for (int i = 0; i < 24; ++i) // no two axes by the same way
                box.vertices_m[i] += (1 + i % 3) * away_m;
            EXPECT_EQ(seaway_hull_fault(&box.hull), nullptr) << seaway_hull_fault(&box.hull);
            open_along(axis, box);
            ASSERT_EQ(box.hull.triangle_count, 8u);
            EXPECT_STREQ(seaway_hull_fault(&box.hull), "the mesh is not closed")
                << axis << ", " << away_m;
        }
}

// Naive: the volume is compared by three axes, which a tube askew to all of them leaves the same.
TEST(Buoyancy, a_tube_along_a_diagonal_is_not_closed) {
    Floating box;
    open_along(2, box);
    const double axes[3][3] = {{1, -1, 0}, {1, 1, -2}, {1, 1, 1}};
    for (int v = 0; v < 8; ++v) {
        double turned_m[3] = {0, 0, 0};
        for (int axis = 0; axis < 3; ++axis)
            seaway_add(turned_m, box.vertices_m[3 * v + axis] / seaway_length(axes[axis]),
                       axes[axis]);
        std::copy(turned_m, turned_m + 3, box.vertices_m + 3 * v);
    }
    EXPECT_STREQ(seaway_hull_fault(&box.hull), "the mesh is not closed");
}

TEST(Buoyancy, a_hull_that_cannot_float_is_told_why) {
    const auto fault = [](const std::function<void(Floating&)>& spoil) {
        Floating box;
        spoil(box);
        const char* said = seaway_hull_fault(&box.hull);
        return std::string(said ? said : "");
    };
    EXPECT_EQ(fault([](Floating&) {}), "");
    EXPECT_NE(fault([](Floating& box) { box.hull.mass_kg = 0; }), "");
    EXPECT_NE(fault([](Floating& box) { box.hull.inertia_kgm2[1] = std::nan(""); }), "");
    EXPECT_NE(fault([](Floating& box) { box.hull.added_mass[0] = -1; }), "");
    EXPECT_NE(fault([](Floating& box) { box.hull.vertex_count = 0; }), "");
    EXPECT_NE(fault([](Floating& box) { box.vertices_m[5] = std::nan(""); }), "");
    EXPECT_NE(fault([](Floating& box) { box.triangles[7] = 8; }), "");
    EXPECT_NE(fault([](Floating& box) { box.hull.triangle_count = 0; }), "");
    EXPECT_EQ(fault([](Floating& box) { box.hull.triangle_count = 11; }), "the mesh is not closed");
    const auto columns = [&](std::vector<double> volumes_m3, double column_m) {
        return fault([&](Floating& box) {
            box.hull.triangle_count = 0;
            box.hull.vertex_count = volumes_m3.size();
            box.hull.volumes_m3 = volumes_m3.data();
            box.hull.column_m = column_m;
        });
    };
    EXPECT_EQ(columns({0, 3}, 1), "");
    EXPECT_EQ(columns({-1, 3}, 1), "a volume must be 0 or more");
    EXPECT_EQ(columns({HUGE_VAL, 3}, 1), "a volume must be 0 or more");
    EXPECT_NE(columns({1, 3}, HUGE_VAL), "");
    EXPECT_EQ(fault([](Floating& box) {
                  for (int i = 0; i < 36; i += 3)
                      std::swap(box.triangles[i], box.triangles[i + 1]);
              }),
              "it has no volume: triangles are anticlockwise from outside");
}

} // namespace
} // namespace seaway::tests
