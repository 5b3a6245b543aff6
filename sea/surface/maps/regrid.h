// SPDX-License-Identifier: Apache-2.0
// Regrid: a periodic map on another grid, exactly. Its waves are told apart by a transform, those of both
// grids are kept, and the sum of them is taken at the other grid's points (trigonometric interpolation:
// Wright et al. 2015, "Extension of Chebfun to periodic functions").
//
//     Regrid small(256, 81), large(81, 256);
//     small.maps(height, rate, height_small, rate_small);   // any two maps at once
//     large.maps(height_small, rate_small, height_again, rate_again);
//
// Kept is the disc of lattice indices 4 (nx^2 + ny^2) < smaller size^2. A map whose waves lie within it
// comes back as it was, to single precision (regrid_precision). Even noise that was put on the smaller grid keeps
// disc_share(smaller) of its variance on the larger one, the same everywhere: waves in the corners of the square
// beyond the disc are nobody's and are left out.
//
// Between grids of one side, or of two, maps of heights and their rates may also be taken to another time (rotations.h).
//
// Displacements need not be sent at all: D = +i k/|k| coth(|k| d) h, wave by wave (sea/waves/realization.h), so
// that they follow from a map of heights on the way, and their time rates from its time rate.
//
// Immutable; thread-safe (each thread has scratch of its own, at most 6 n^2 floats). Cost: two maps of 256 to 81 or back some
// tenths of a millisecond.
#pragma once

#include <cstdlib>
#include <span>
#include <vector>

#include "base/instructions.h"
#include "sea/surface/maps/keyframe.h"
#include "sea/surface/maps/rotations.h"

namespace seaway::sea {

/// The smallest grid that holds waves of lattice index up to `reach` (any direction), of at most `size`
/// points a side: a product of 2, 3 and 5, which transforms are quick at. `size` if none is smaller.
int smallest_grid(double reach, int size);

/// Share of a grid's waves that lie within its disc: of its even noise, too.
double disc_share(int size);

/// How far waves of a grid's disc move water sideways, coth(k d) of their height.
class Orbits {
  public:
    Orbits(int size, double length_m, double depth_m);

    /// Mean of coth^2(k d) / 2: what even noise of heights becomes in one component of the displacement that follows
    /// from them, in variance. 1/2 in deep water.
    double gain() const { return gain_; }
    int size() const { return size_; }
    /// coth(k d) over the length of the lattice index (i, j), which is not 0.
    float over_index(int i, int j) const {
        const int side = (size_ + 1) / 2;
        return over_index_[static_cast<std::size_t>(std::abs(j) * side + std::abs(i))];
    }

  private:
    int size_;
    double gain_ = 0;
    std::vector<float> over_index_; ///< [j][i], one quarter
};

/// What going to a smaller grid and back adds to a value, as a share of four times the rms of its map: twice the
/// largest that was seen on any of the sizes.
inline constexpr double regrid_precision = 1e-6;

class Regrid {
  public:
    /// Sides, 1 to 4096, products of 2, 3 and 5.
    Regrid(int from, int to, Instructions instructions = best_instructions());

    /// Each [y][x] and of the size that its side has; `out` must be another map than the two that are read.
    void maps(std::span<const float> a, std::span<const float> b, std::span<float> out_a,
              std::span<float> out_b) const;
    /// These maps of a keyframe, which must be linear fields that both hold; values of `out` are made room for.
    void maps(const Keyframe& keyframe, FieldSet fields, Keyframe& out) const;

    /// Of a map of heights (a) and its time rate (b) the displacements and their time rates, too, on the disc that
    /// `orbits` is of, the smaller one. Spans that are empty are not wanted.
    struct Two {
        std::span<float> a, b;
    };
    void maps(std::span<const float> a, std::span<const float> b, const Orbits& orbits, Two height,
              Two x, Two y) const;

    /// Of a map of heights (a) and its time rate (b) those of another time, on the disc that `rotations` are of. The same
    /// bits for all instructions.
    void maps(std::span<const float> a, std::span<const float> b, const Rotations& rotations,
              std::span<float> out_a, std::span<float> out_b) const;

    int from() const { return from_.length; }
    int to() const { return to_.length; }

    /// Can transforms be of this length?
    static bool takes(int size);

  private:
    struct Length {
        int length = 0;
        std::vector<int> radices;
        std::vector<float> twiddles; ///< as line_kernel.h says
    };
    static Length length_of(int n);
    struct Scratch;
    static Scratch& scratch();
    void rows_in(std::span<const float> a, std::span<const float> b, Scratch& scratch) const;
    void columns(Scratch& scratch) const;
    void turn(const Rotations& rotations, Scratch& scratch) const;
    enum class Way { height, along_x, along_y };
    void columns_back(Way way, const Orbits* orbits, Scratch& scratch) const;
    void make_room(Scratch& scratch) const;
    void take(std::span<const float> a, std::span<const float> b, Scratch& scratch) const;
    void give(Way way, const Orbits* orbits, Two out, Scratch& scratch) const;
    void rows_out(std::span<float> a, std::span<float> b, Scratch& scratch) const;

    Length from_;
    Length to_;
    int smaller_;
    int reach_; ///< largest index along an axis that is kept
    Instructions instructions_;
};

} // namespace seaway::sea
