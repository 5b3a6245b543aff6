// SPDX-License-Identifier: Apache-2.0
// WaveMaps: keyframes of a sea whose waves this client has, made here as a server makes them. A point of a map takes
// less than a microsecond, a sum of all waves some tens, of a sea that changes some milliseconds for each time; a keyframe some milliseconds, once. So points are summed until
// sums have taken as long as the keyframes of their time would, and those are made then: whoever asks waits for no
// more than twice what the cheaper way would have taken, whether he asks about a time once or a thousand times ("ski rental":
// A. R. Karlin et al., "Competitive snoopy caching", Algorithmica 3, 1988).
//
// What answers from maps are off by is what the sea states of its interpolation, and what its waves are off by
// (RebuiltError). Thread-safe; one thread at a time makes keyframes. Memory: four keyframes a cascade, 2.4 MB each at 256 x 256, and a third of
// that for the waves; nothing before the first are made.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "client/held/keyframe_ring.h"
#include "client/held_surfaces.h"
#include "client/rebuilt/rebuilt_sea.h"
#include "client/rebuilt/wave_keyframes.h"

namespace seaway::client {

/// What sums take, of each wave: at one point, and for each time; docs/performance.md has the table.
inline constexpr double sum_wave_us = 0.0025;
inline constexpr double sum_wave_time_us = 0.002;
/// What making a keyframe for sampling takes, of each of its grid points.
inline constexpr double map_point_us = 0.05;
/// The same of a sea that changes, whose waves are laid out anew for each time.
inline constexpr double gliding_wave_time_us = 0.25;
inline constexpr double gliding_map_point_us = 0.07;

class WaveMaps {
  public:
    /// `waves` are those of the sea of `state`.
    WaveMaps(SeaStatePtr state, OwnSeaPtr waves);

    const SeaStatePtr& state() const { return state_; }
    bool are_of(const SeaStatePtr& state, const OwnSeaPtr& waves) const {
        return state_ == state && waves_ == waves;
    }

    /// The surface around a time, for so many more points, of so many times with its keyframes. False: these are to be summed,
    /// as all are without the first cascade, which has what the waves are off by.
    bool lend(sea::TimeUs time_us, std::size_t points, std::size_t times,
              HeldSurfaces::Lent& surface, std::uint32_t cascades = sea::all_cascades);
    /// The same for who keeps it, of points of one time. Nothing: to be summed.
    std::optional<LocalSurface> surface(sea::TimeUs time_us, std::size_t points,
                                        std::uint32_t cascades);
    /// Of one cascade, whatever it costs. What the waves are off by is no part of its errors, but of the first. Nothing: it
    /// cannot be made.
    std::optional<LocalSurface> map(sea::TimeUs time_us, int cascade);
    sea::MixedMaps& mixed() { return surfaces_.mixed(); }

    /// Keyframes made so far.
    std::uint64_t made() const { return made_; }

  private:
    struct Account { ///< of the times of one cell_span()
        TimeSpan times{0, 0};
        double spent_us = 0;
        std::uint64_t last_used = 0;
    };
    struct Needed {
        int cascade = 0;
        sea::TimeUs time_us = 0;
    };
    using Pairs = ShortList<Needed, 2 * sea::surface_pairs_max>;

    Pairs around(sea::TimeUs time_us, std::uint32_t cascades) const;
    HeldKeyframePtr held(const Needed& one) const; ///< or null
    /// What making takes that is not held around this time.
    double missing_us(sea::TimeUs time_us, std::uint32_t cascades) const;
    /// Is all there, or have these points, and those before them, been worth making it?
    bool are_worth(sea::TimeUs time_us, std::size_t points, std::size_t times,
                   std::uint32_t cascades);
    Account& account_of(const TimeSpan& times);
    std::optional<LocalSurface> made_surface(sea::TimeUs time_us, std::uint32_t cascades);
    // making_ held.
    bool make_what_lacks(sea::TimeUs time_us, std::uint32_t cascades); ///< false: it cannot
    HeldKeyframePtr make(const Needed& one);

    const SeaStatePtr state_;
    const OwnSeaPtr waves_;
    const std::vector<double> waves_count_; ///< one a cascade

    KeyframeRing ring_;
    HeldSurfaces surfaces_;

    std::mutex mutex_; ///< of the accounts
    std::array<Account, 8> accounts_;
    std::uint64_t uses_ = 0;

    std::mutex making_; ///< of what follows
    WaveKeyframes keyframes_;
    std::atomic<bool> cannot_be_made_ = false; ///< a tile has a size without a transform
    std::atomic<std::uint64_t> made_ = 0;
};

/// Those of the seas that were sampled last: each may hold some tens of MB. Thread-safe.
class MapsOfSeas {
  public:
    std::shared_ptr<WaveMaps> of(const SeaStatePtr& state, const OwnSeaPtr& waves);
    void forget(std::uint32_t epoch);
    void clear();

  private:
    static constexpr std::size_t seas_max = 2;
    std::mutex mutex_;
    std::vector<std::shared_ptr<WaveMaps>> seas_; ///< the last one that came last
};

} // namespace seaway::client
