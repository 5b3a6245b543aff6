// SPDX-License-Identifier: Apache-2.0
// Predictor: a keyframe's heights and rates from those of an earlier one, by themselves (rotations.h), with what that takes kept
// for the next time: keyframes of a cascade lie an interval apart, so it is mostly the same. For one thread.
#pragma once

#include <deque>
#include <span>

#include "sea/surface/maps/regrid.h"
#include "sea/surface/maps/rotations.h"

namespace seaway::sea {

class Predictor {
  public:
    /// What is kept: of each of 8 cascades at three rates, of two seas; and so many bytes of it, with one of any size.
    static constexpr std::size_t kept_max = 48;
    static constexpr std::size_t kept_bytes_max = 16u * 1024 * 1024;

    /// Of maps of `size` points a side ([y][x], Regrid::takes) over length_m those forward_us later. 0.2 ms for 81 x 81.
    void maps(int size, double length_m, const WaveLaw& law, TimeUs forward_us,
              std::span<const float> height, std::span<const float> rate,
              std::span<float> height_then, std::span<float> rate_then);

  private:
    struct Kept {
        double length_m;
        WaveLaw law;
        TimeUs forward_us;
        Rotations rotations;
        Regrid regrid;
    };
    const Kept& kept(int size, double length_m, const WaveLaw& law, TimeUs forward_us);

    std::deque<Kept> kept_; ///< newest last
};

} // namespace seaway::sea
