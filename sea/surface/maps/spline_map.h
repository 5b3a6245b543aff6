// SPDX-License-Identifier: Apache-2.0
// SplineMap: a keyframe made ready for sampling between its grid points.
//
// Bicubic B-spline interpolation (Unser 1999, "Splines: a perfect fit"): a periodic recursive
// prefilter turns the maps into coefficients once, then a sample is a 4 x 4 weighted sum. It
// passes through every grid value, is twice differentiable, and its error for a wave of q = k dx is
// about 4.3 (q / 2 pi)^4 of the amplitude at the worst place: ten times below Catmull-Rom at the
// finest waves we keep. The derivatives of the same spline give slopes and strains, so six maps are
// all a sampler needs.
//
// Immutable once built; sampling is thread-safe and allocates nothing. Building a 256 x 256 map
// takes about 4 ms, a sample 30 ns from the cache and ten times that from memory.
#pragma once

#include <memory>
#include <optional>
#include <span>

#include "base/aligned_floats.h"
#include "sea/basics/lagrangian_point.h"
#include "sea/surface/maps/keyframe.h"
#include "sea/surface/maps/pauses.h"
#include "sea/surface/maps/spline_channels.h"
#include "sea/surface/maps/strain_windows.h"

namespace seaway::sea {

/// Values and horizontal derivatives of the six surface fields at one point.
struct SplineSample {
    // [channel], as spline_channels.h says; 3 and 7 are unused.
    float value[spline_channel::count];
    float d_dx[spline_channel::count];
    float d_dy[spline_channel::count];
};

class SplineMap {
  public:
    /// The keyframe must hold height and height_rate; displacements that it does not hold are zero. `pause` as in pauses.h.
    explicit SplineMap(const Keyframe& keyframe, Pauses::Pause pause = nullptr);

    TimeUs time_us() const { return time_us_; }
    std::uint32_t epoch() const { return epoch_; }
    /// It held displacements and rates, and those of all of its waves.
    bool moves_sideways() const { return moves_sideways_; }
    std::size_t bytes() const { return bytes_of(size_); }
    /// What a map of this size takes, coefficients and windows.
    static std::size_t bytes_of(int size) {
        return count_of(size) * sizeof(float) + StrainWindows::bytes_of(size);
    }

    /// Where a sample is taken from. Who takes several, from several maps, asks for all cells first: what
    /// a sample waits for is memory, and it is being fetched from then on.
    struct Cell {
        const float* first; ///< of 4 x 4 coefficients
        float fraction_x;
        float fraction_y;
    };
    /// Undisplaced coordinates, any finite value; reduced modulo the tile in double precision.
    Cell cell(double x_m, double y_m) const;
    SplineSample sample(const Cell& cell) const;
    SplineSample sample(double x_m, double y_m) const { return sample(cell(x_m, y_m)); }

    // For who samples whole grids: coefficients()[y + 1][x + 1][channel], channels as in
    // spline_channels.h, -1 <= x, y < size + 2; the border repeats the other side of the tile.
    static constexpr int channels = spline_channel::count;
    static constexpr int border = 3; ///< one before, two after
    int size() const { return size_; }
    std::size_t texels() const { return count_of(size_) / channels; } ///< of coefficients()
    double length_m() const { return length_m_; }
    std::span<const float> coefficients() const { return {coefficients_.get(), count_of(size_)}; }

    /// How strongly the map squeezes the surface, place by place.
    const StrainWindows& windows() const { return *windows_; }

  private:
    static std::size_t count_of(int size) {
        const auto side = static_cast<std::size_t>(size + border);
        return side * side * channels;
    }
    float* texel(int x, int y); ///< -1 .. size+1: a border repeats the other side

    int size_;
    double length_m_;
    TimeUs time_us_;
    std::uint32_t epoch_;
    bool moves_sideways_;
    AlignedFloats coefficients_;
    std::optional<StrainWindows> windows_; ///< made last, of the coefficients
};

using SplineMapPtr = std::shared_ptr<const SplineMap>;

} // namespace seaway::sea
