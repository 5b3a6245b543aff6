// SPDX-License-Identifier: Apache-2.0
// All sheets of a folded sea by brute force, in double precision, owing nothing to sea/surface: D and
// the height of every cascade on a lattice several times finer than its grid (one transform by FFTW),
// Newton from every cell of a lattice over all that points may move whose image may hold the target.
//
//     BruteField field(sea, t_us);
//     BruteSheets sheets(field, centre, half_m);      // a second; then any target within half_m of it
//     for (const BruteSheet& s : sheets.above(x, y)) ...
//
// A fold narrower than half of the finest grid spacing may be overlooked, nothing else. What it finds
// is as good as the lattice's splines, 1e-4 of the finest waves: polish() goes on with the exact sum.
#pragma once

#include <array>
#include <complex>
#include <cstdint>
#include <vector>

#include "sea/basics/lagrangian_point.h"
#include "sea/surface/sheets.h"
#include "sea/waves/reference.h"

namespace seaway::tests {

/// Splines of D and of the height of one cascade at one time.
class BruteTile {
  public:
    BruteTile(const sea::CascadeModes& modes, sea::TimeUs phase_time_us);
    void add(sea::LagrangianPoint& sum, double x_m, double y_m) const;
    double reach_m() const { return reach_m_; } ///< |D| stays below

  private:
    int count_; ///< lattice points a side
    double length_m_;
    /// [y][x]: D_x, D_y, height, 0; two vectors each.
    std::vector<std::array<double, 4>> coefficients_;
    double reach_m_ = 0;
};

class BruteField {
  public:
    BruteField(const sea::Realization& sea, sea::TimeUs time_us);
    /// Displacement, strain and height; the rest is zero.
    sea::LagrangianPoint at(sea::Vec2 X) const;
    sea::Vec2 landed(sea::Vec2 X, const sea::LagrangianPoint& p) const {
        return {X.x + choppiness_.x * p.displacement_x, X.y + choppiness_.y * p.displacement_y};
    }
    double reach_m() const { return reach_m_; }   ///< lambda |D| stays below
    double finest_m() const { return finest_m_; } ///< grid spacing of the finest waves
    const sea::Choppiness& choppiness() const { return choppiness_; }

  private:
    sea::Choppiness choppiness_;
    std::vector<BruteTile> tiles_;
    double reach_m_ = 0;
    double finest_m_ = 1e9;
};

struct BruteSheet {
    sea::Vec2 at; ///< X
    double height_m;
    double jacobian;
};

class BruteSheets {
  public:
    /// Targets within `half_m` of `centre`, in x and in y.
    BruteSheets(const BruteField& field, sea::Vec2 centre, double half_m);

    std::vector<BruteSheet> above(sea::Vec2 target) const;

    /// Undisplaced places that come down within the square, lattice points, with their J.
    struct Place {
        sea::Vec2 at;
        sea::Vec2 landed;
        double jacobian;
    };
    const std::vector<Place>& places() const { return places_; }
    double step_m() const { return step_m_; }

  private:
    std::size_t bin(double x_m, double y_m) const;

    const BruteField& field_;
    sea::Vec2 low_; ///< of the square of targets
    double step_m_;
    double bin_m_;
    int bins_;
    std::vector<Place> places_;
    std::vector<std::vector<sea::Vec2>>
        starts_; ///< [bin]: middles of cells whose image may reach it
};

/// How far sideways of its target a sheet ends at a fold, m, to second order: the gradient's smallest
/// singular value s falls to zero along the direction v that it nearly puts to nothing, and over that
/// way the sheet goes on by half of s each metre.
double ends_within_m(const BruteField& field, const BruteSheet& sheet);

/// The sheets of the exact sum that Newton reaches from `starts`, each of them once.
std::vector<BruteSheet> polish(const sea::DirectSum::Moment& moment, sea::Vec2 target,
                               const std::vector<BruteSheet>& starts);

} // namespace seaway::tests
