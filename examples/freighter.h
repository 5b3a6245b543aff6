// SPDX-License-Identifier: Apache-2.0
// A freighter of 120 x 18 m as a hull for seaway/buoyancy.h: eleven rings of six corners, closed at both ends. Its shape is made
// up; weights and coefficients are what ships of this kind have.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include <seaway/buoyancy.h>

class Freighter {
  public:
    static constexpr double length_m = 120;
    static constexpr double beam_m = 18;
    static constexpr double depth_m = 12; ///< keel to deck
    static constexpr double draught_m = 6.5;
    static constexpr double weight_above_keel_m = 6.3; ///< centre of mass: GM comes to a metre

    Freighter() {
        for (std::uint32_t ring = 0; ring < rings; ++ring)
            add_ring(2.0 * ring / (rings - 1) - 1);
        for (std::uint32_t ring = 0; ring + 1 < rings; ++ring)
            for (std::uint32_t i = 0; i < corners; ++i)
                add_side(corners * ring + i, corners * ring + (i + 1) % corners);
        for (std::uint32_t i = 2; i < corners; ++i) {
            add_triangle(0, i - 1, i); // stern
            const std::uint32_t bow = corners * (rings - 1);
            add_triangle(bow, bow + i, bow + i - 1);
        }
        describe();
    }
    Freighter(const Freighter&) = delete;

    const seaway_hull& hull() const { return hull_; }

    /// Of the centre of mass above still water, afloat at its draught.
    static constexpr double afloat_m = weight_above_keel_m - draught_m;

  private:
    static constexpr std::uint32_t rings = 11;
    static constexpr std::uint32_t corners = 6;

    /// `along`: -1 at the stern, 1 at the bow. Full amidships, finer towards the ends and the keel.
    void add_ring(double along) {
        const double full = 1 - 0.75 * std::pow(std::abs(along), along > 0 ? 3 : 5);
        const std::array<double, 3> half_m{beam_m / 2 * full, beam_m / 2 * full * full,
                                           beam_m / 2 * 0.75 * full * full};
        const std::array<double, 3> above_keel_m{depth_m, 2, 0};
        for (int i = 0; i < 6; ++i) {
            const std::size_t height = static_cast<std::size_t>(i < 3 ? i : 5 - i);
            vertices_m_.push_back(along * length_m / 2);
            vertices_m_.push_back((i < 3 ? 1 : -1) * half_m[height]);
            vertices_m_.push_back(above_keel_m[height] - weight_above_keel_m);
        }
    }
    void add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        triangles_.insert(triangles_.end(), {a, b, c});
    }
    void add_side(std::uint32_t a, std::uint32_t b) {
        add_triangle(a, a + corners, b);
        add_triangle(b, a + corners, b + corners);
    }

    void describe() {
        hull_.vertices_m = vertices_m_.data();
        hull_.vertex_count = vertices_m_.size() / 3;
        hull_.triangles = triangles_.data();
        hull_.triangle_count = triangles_.size() / 3;
        const seaway_load load = afloat();
        trim(load);
        hull_.mass_kg = load.submerged_m3 * SEAWAY_DENSITY_KGPM3;
        const double gyration_m[3] = {0.38 * beam_m, 0.25 * length_m, 0.25 * length_m};
        for (int i = 0; i < 3; ++i)
            hull_.inertia_kgm2[i] = hull_.mass_kg * gyration_m[i] * gyration_m[i];
        const double added_mass[3] = {0.05, 0.7, 0.9};
        const double added_inertia[3] = {0.2, 0.9, 0.6};
        for (int i = 0; i < 3; ++i) {
            hull_.added_mass[i] = added_mass[i];
            hull_.added_inertia[i] = added_inertia[i];
        }
        hull_.linear_drag = 2500; // the waves that it makes, by its roll, its heave and its bow
        hull_.quadratic_drag = 0.4;
    }
    /// Loads are stowed so that it floats upright: the centre of mass comes over that of buoyancy.
    void trim(const seaway_load& afloat) {
        const double ahead_m = -afloat.torque_nm[1] / afloat.force_n[2];
        const double to_port_m = afloat.torque_nm[0] / afloat.force_n[2];
        for (std::size_t i = 0; i < vertices_m_.size(); i += 3) {
            vertices_m_[i] -= ahead_m;
            vertices_m_[i + 1] -= to_port_m;
        }
    }
    /// Of still water at its draught.
    seaway_load afloat() const {
        std::vector<seaway_point> points(hull_.vertex_count);
        std::vector<seaway_answer> still(hull_.vertex_count);
        for (seaway_answer& water : still)
            water.normal[2] = 1;
        const seaway_body body{{0, 0, afloat_m}, {1, 0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
        seaway_load load;
        seaway_hull_points(&hull_, &body, 0, points.data());
        seaway_hull_load(&hull_, &body, points.data(), still.data(), 0, &load);
        return load;
    }

    std::vector<double> vertices_m_;
    std::vector<std::uint32_t> triangles_;
    seaway_hull hull_{};
};
