// SPDX-License-Identifier: Apache-2.0
// Mixed maps: those of a surface at one time, mixed of its keyframes once that time has been asked about so often that it pays.
//
// A point reads 60 lines of a cache where two keyframes a cascade are mixed for it alone, and 21 of maps that are mixed
// already; to mix them reads and writes all of them once. What comes is not known, so they are mixed when as much has been
// lost by not having done it: at most twice the cost of who knew. Answers have the same bits either way.
//
// Thread-safe: who finds it busy, or no memory for them, goes without. Memory is kept for the next time: 16 bytes a texel, 3.2 MB of three cascades of
// 256 x 256; none before it is needed. To mix them takes 0.5 to 1 ms.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <mutex>

#include "base/aligned_floats.h"
#include "sea/basics/time.h"
#include "sea/surface/map_error.h"

namespace seaway::sea {

class Surface;
struct PointKernel;

class MixedMaps {
  public:
    /// After so many points of one time (docs/performance/points.md, "From maps that are held").
    static constexpr std::size_t pays_from_points = 6000;

    /// The maps, for as long as this lives; or nothing.
    class Lent {
      public:
        Lent() = default;
        ~Lent();
        Lent(const Lent&) = delete;
        Lent& operator=(const Lent&) = delete;

        explicit operator bool() const { return of_ != nullptr; }
        /// Of a pair: coefficients as in a SplineMap, spline_channel::mixed floats a texel.
        const float* map(std::size_t pair) const { return of_->maps_[pair].get(); }

      private:
        friend class MixedMaps;
        MixedMaps* of_ = nullptr;
    };

    /// For so many points at one time of a surface.
    void lend(const Surface& surface, TimeUs time_us, std::size_t points, const PointKernel& kernel,
              Lent& lent);

  private:
    bool has_room_for(const Surface& surface);

    std::mutex mutex_;
    std::uint64_t surface_ = 0; ///< Surface::number()
    TimeUs time_us_ = 0;
    std::size_t points_ = 0; ///< asked about at that time
    bool mixed_ = false;
    int users_ = 0;
    std::array<AlignedFloats, surface_pairs_max> maps_;
    std::array<std::size_t, surface_pairs_max> texels_{}; ///< that they have room for
};

} // namespace seaway::sea
