// SPDX-License-Identifier: Apache-2.0
// Rotations: what heights and their time rates become by themselves while time goes on. A map of heights and one
// of their rates at one moment are all that there is to know of free waves: each wave vector holds one wave that runs along it and one
// that runs against it, and the two maps tell them apart. So for every one of them, T later,
//
//     h(T) = h cos(wT) + h' sin(wT) / w,        h'(T) = h' cos(wT) - h w sin(wT),
//
// the solution of h'' = -w^2 h, with w of the dispersion (sea/basics/dispersion.h) and of the loop (sea/waves/realize.h).
// The mean of a map stays as it is.
//
//     const Rotations rotations(81, 2111.0, law, 640'000);
//     Regrid(81, 81).maps(height, rate, rotations, height_then, rate_then);
//
// Whoever has the same numbers gets the same bits: tables are rounded to single precision from double, and nothing is
// fused. Immutable; thread-safe. 81 x 81: 0.1 ms to make, 0.2 ms to use, 40 KB.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <vector>

#include "sea/basics/dispersion.h"
#include "sea/basics/time.h"

namespace seaway::sea {

class Rotations {
  public:
    /// Of the disc of a grid. `forward_us`: either way, in the time of the sea.
    Rotations(int size, double length_m, const WaveLaw& law, TimeUs forward_us);

    struct Turn {
        float cosine = 1;
        float sine_over_w_s = 0;
        float sine_w_radps = 0; ///< w sin(wT)
    };
    /// Of the lattice index (i, j).
    const Turn& of_index(int i, int j) const {
        return turns_[static_cast<std::size_t>(std::abs(j) * side_ + std::abs(i))];
    }
    int size() const { return size_; }
    std::size_t bytes() const { return turns_.size() * sizeof(Turn); }

  private:
    int size_;
    int side_;
    std::vector<Turn> turns_; ///< [j][i], one quarter
};

} // namespace seaway::sea
