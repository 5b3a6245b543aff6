// SPDX-License-Identifier: Apache-2.0
// A box of 4 x 2 x 1 m of half the density of the water, and waters for it.
#pragma once

#include <cmath>
#include <functional>
#include <vector>

#include "client/buoyancy.h"

namespace seaway::tests {

/// Water of this height, slope and velocity at a point.
using Water = std::function<seaway_answer(const seaway_point&)>;

inline constexpr double frame_s = 1.0 / 60; ///< a step of an engine

inline seaway_answer still_water(const seaway_point&) {
    return {0, {0, 0, 1}, {0, 0, 0}, 0, 0, 0};
}

struct Floating {
    static constexpr double length_m = 4;
    static constexpr double beam_m = 2;
    static constexpr double height_m = 1;
    static constexpr double density_kgpm3 = 1000;
    static constexpr double mass_kg = 4000; ///< draught 0.5 m

    double vertices_m[24];
    std::uint32_t triangles[36];
    seaway_hull hull{};
    seaway_body body{{0, 0, 0}, {1, 0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
    std::vector<seaway_point> points;
    std::vector<seaway_answer> answers;

    Floating() {
        seaway_box(length_m, beam_m, height_m, vertices_m, triangles);
        hull.mass_kg = mass_kg;
        const double square_m2[3] = {length_m * length_m, beam_m * beam_m, height_m * height_m};
        for (int i = 0; i < 3; ++i) // of a homogeneous box
            hull.inertia_kgm2[i] = mass_kg / 12 * (square_m2[(i + 1) % 3] + square_m2[(i + 2) % 3]);
        hull.density_kgpm3 = density_kgpm3;
        hull.vertices_m = vertices_m;
        hull.vertex_count = 8;
        hull.triangles = triangles;
        hull.triangle_count = 12;
    }
    Floating(const Floating&) = delete;

    void roll_to(double degrees) {
        body.orientation[0] = std::cos(degrees * M_PI / 360);
        body.orientation[1] = std::sin(degrees * M_PI / 360);
    }
    double roll_deg() const {
        return 360 / M_PI * std::atan2(body.orientation[1], body.orientation[0]);
    }
    /// How far its upright axis leans, degrees.
    double lean_deg() const {
        double rows[3][3];
        seaway_rows(body.orientation, rows);
        return 180 / M_PI * std::acos(std::fmin(rows[2][2], 1));
    }

    seaway_code ride(const Water& water, double time_s, double step_s) {
        points.resize(hull.vertex_count);
        answers.resize(hull.vertex_count);
        const auto asked = [](void* context, const seaway_point* at, size_t count,
                              seaway_answer* out) {
            for (size_t i = 0; i < count; ++i)
                out[i] = (*static_cast<const Water*>(context))(at[i]);
            return SEAWAY_OK;
        };
        Water copy = water;
        return seaway_hull_ride(&hull, &body, asked, &copy, static_cast<int64_t>(time_s * 1e6),
                                step_s, points.data(), answers.data());
    }

    seaway_load load(const Water& water) {
        points.resize(hull.vertex_count);
        answers.resize(hull.vertex_count);
        seaway_hull_points(&hull, &body, 0, points.data());
        for (size_t i = 0; i < points.size(); ++i)
            answers[i] = water(points[i]);
        seaway_load load;
        seaway_hull_load(&hull, &body, points.data(), answers.data(), 0, &load);
        return load;
    }
};

} // namespace seaway::tests
