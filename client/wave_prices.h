// SPDX-License-Identifier: Apache-2.0
// WavePrices: what sums of waves and keyframes made of them take, and when the second pay. Sums pay, by what they took, towards
// the keyframes that would have spared them; these are made once they are paid for ("ski rental": A. R. Karlin
// et al., "Competitive snoopy caching", Algorithmica 3, 1988).
//
// Keyframes last for a cell of time, those between which all times are interpolated. Where time runs from cell to cell, a sum pays for
// those of the next one only with what it takes beyond what keyframes cost for as long as it ran (one a cascade and interval): less is
// no reason to have any, however often it is paid. Where maps answer, what they spare counts as what sums would have taken. So whoever
// asks waits for no more than about twice what the cheaper way would have taken, whether he asks about a time once or a thousand times.
//
// Prices begin with what was measured of a gale on one machine and follow what things take: a sum of a steep sea ten times as
// much, maps of stylised waves a hundred times. What a machine, or what else runs on it, makes all of them cost is told by the laying out of
// waves, which is part of every sum and takes as much in gentle seas as in steep ones: so keyframes have a price there before one is made.
// Thread-safe; some 0.1 us.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <vector>

#include "client/held_surfaces.h"
#include "client/rebuilt/rebuilt_sea.h"

namespace seaway::client {

/// What sums take, of each wave: at one point, and for each time; of a sea that changes its waves are laid out anew. Of a stylised wave
/// at one point what it adds to a map's.
inline constexpr double sum_wave_us = 0.005;
inline constexpr double sum_wave_time_us = 0.004;
inline constexpr double gliding_wave_time_us = 0.25;
/// What making a keyframe for sampling takes, of each of its grid points; and for each stylised wave besides.
inline constexpr double map_point_us = 0.05;
inline constexpr double gliding_map_point_us = 0.07;
inline constexpr double map_plane_wave_us = 0.005;
inline constexpr double map_shaped_wave_us = 0.06;

/// What a point from maps takes. Sums that are listed at less are of so few waves that no keyframe ever pays.
inline constexpr double sampled_point_us = 1;

/// Points that are asked about at once, of so many times with the same keyframes.
struct WaveBatch {
    sea::TimeUs time_us = 0; ///< one of them
    std::size_t points = 1;
    std::size_t times = 1;
    std::uint32_t cascades = sea::all_cascades;
};

class WavePrices {
  public:
    WavePrices(const SeaState& state, const OwnSea& waves);

    double keyframe_us(int cascade) const;
    double sum_us(const WaveBatch& batch) const;

    // Times are what a thread has worked.
    /// A keyframe has been made.
    void made(int cascade, double took_us);
    /// Points were summed whose keyframes are those of `cell`. `laid_out_us`: of that for the waves of one time; 0: it is not known.
    void summed(const TimeSpan& cell, const WaveBatch& batch, double took_us, double laid_out_us);
    /// They were answered from those.
    void spared(const TimeSpan& cell, const WaveBatch& batch);
    /// Have sums of this cell, with these, paid for keyframes, and for what has been spent on it?
    bool pays(const TimeSpan& cell, const WaveBatch& batch, double keyframes_us);
    /// Some have been made.
    void spend(const TimeSpan& cell, double keyframes_us);

  private:
    struct Account {
        TimeSpan cell{0, 0};
        std::uint32_t cascades = 0; ///< that were asked about
        double credit_us = 0;       ///< of the cells beside it
        double sums_us = 0;         ///< what sums took, and what keyframes have spared
        double spent_us = 0;        ///< on keyframes
        std::uint64_t last_used = 0;
    };
    struct Cascade {
        double interval_us = 0;
        double sum_point_us = 0;
        double lay_out_us = 0;     ///< for a time
        double sum_time_us = 0;    ///< with it
        double keyframe_us = 0;    ///< as listed
        double keyframe_takes = 1; ///< times that, and machine_takes_
    };
    double listed_point_us(std::uint32_t cascades) const;
    double listed_sum_us(const WaveBatch& batch) const;
    double listed_lay_out_us(std::uint32_t cascades) const;
    // mutex_ held.
    double expected_us(const Cascade& cascade) const;
    /// A new one takes over what is left of its neighbours'.
    Account& account_of(const TimeSpan& cell, std::uint32_t cascades);
    /// What is left for the next cell: no more than all keyframes of one.
    double credit_left_us(const Account& account) const;

    mutable std::mutex mutex_;
    std::vector<Cascade> cascades_;
    double sums_take_ = 1;     ///< times listed_sum_us()
    double machine_takes_ = 1; ///< times what is listed
    /// Places that are no numbers, and times whose waves are laid out already, take next to nothing: others do not.
    static constexpr double sums_take_min = 0.5;
    std::array<Account, 8> accounts_;
    std::uint64_t uses_ = 0;
};

} // namespace seaway::client
