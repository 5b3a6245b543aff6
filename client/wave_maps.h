// SPDX-License-Identifier: Apache-2.0
// WaveMaps: keyframes of a sea whose waves this client has, made here as a server makes them. A point of a map takes
// a microsecond or so, a sum of all waves some tens, of a sea that changes some milliseconds more for each time; a keyframe takes some
// milliseconds, once. So points are summed until keyframes of their time pay (wave_prices.h), and those are made then.
//
// What answers from maps are off by is what the sea states of its interpolation, and what its waves are off by
// (RebuiltError). Thread-safe. One thread at a time makes keyframes; who would wait for it for longer than sums take sums meanwhile. A call
// makes no more than take it twice as long as its sum, but one; the next call goes on. Memory: three keyframes a cascade where time runs on, four of two
// times in turns, 2.4 MB each at 256 x 256 and 38 at 1024 x 1024, and a third of that for the waves; nothing before the first are made.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "base/elapsed.h"
#include "client/held/keyframe_ring.h"
#include "client/held_surfaces.h"
#include "client/rebuilt/rebuilt_sea.h"
#include "client/rebuilt/wave_keyframes.h"
#include "client/wave_prices.h"

namespace seaway::client {

class WaveMaps {
  public:
    /// `waves` are those of the sea of `state`; `worked_s` is what the calling thread has worked, s.
    WaveMaps(SeaStatePtr state, OwnSeaPtr waves, double (*worked_s)() = thread_cpu_seconds);

    const SeaStatePtr& state() const { return state_; }
    bool are_of(const SeaStatePtr& state, const OwnSeaPtr& waves) const {
        return state_ == state && waves_ == waves;
    }

    /// The surface around the times of a batch. False: it is to be summed, as all are without the first cascade, which has
    /// what the waves are off by.
    bool lend(const WaveBatch& batch, HeldSurfaces::Lent& surface);
    /// The same for who keeps it.
    std::optional<LocalSurface> surface(const WaveBatch& batch);
    /// Of one cascade, whatever it costs. What the waves are off by is no part of its errors, but of the first. Nothing: it
    /// cannot be made.
    std::optional<LocalSurface> map(sea::TimeUs time_us, int cascade);
    /// A batch has been summed instead (WavePrices::summed()).
    void summed(const WaveBatch& batch, double took_us, double laid_out_us = 0);
    sea::MixedMaps& mixed() { return surfaces_.mixed(); }

    /// Keyframes made so far.
    std::uint64_t made() const { return made_; }
    /// Lets go of all of them.
    void let_go();

  private:
    struct Needed {
        int cascade = 0;
        sea::TimeUs time_us = 0;
    };
    using Pairs = ShortList<Needed, 2 * sea::surface_pairs_max>;

    Pairs around(sea::TimeUs time_us, std::uint32_t cascades) const;
    Pairs longest_first(Pairs needed) const;       ///< for which time may run on
    HeldKeyframePtr held(const Needed& one) const; ///< or null
    /// All around this time?
    bool are_held(sea::TimeUs time_us, std::uint32_t cascades) const;
    /// What making takes that is not held around this time.
    double missing_us(sea::TimeUs time_us, std::uint32_t cascades) const;
    /// Is all there, or to be made for this?
    bool is_worth(const WaveBatch& batch);
    /// Not held where another thread makes some, and summing takes less than to wait for it.
    std::unique_lock<std::mutex> turn_to_make(const WaveBatch& batch);
    void answers(const WaveBatch& batch); ///< by maps
    /// With all that it needs; nothing without.
    std::optional<LocalSurface> held_surface(sea::TimeUs time_us, std::uint32_t cascades);
    // making_ held.
    /// Keyframes around a time, for about as long as `at_most_us`, one at least. False: some are still missing.
    bool make_what_lacks(sea::TimeUs time_us, std::uint32_t cascades, double at_most_us);
    HeldKeyframePtr make(const Needed& one);
    bool make_for(const WaveBatch& batch); ///< as many as are in keeping with it

    const SeaStatePtr state_;
    const OwnSeaPtr waves_;
    double (*const worked_s_)();
    WavePrices prices_;

    KeyframeRing ring_;
    HeldSurfaces surfaces_;

    std::atomic<sea::TimeUs> used_us_ = 0; ///< last: its keyframes stay while others are made

    std::mutex making_; ///< of what follows
    WaveKeyframes keyframes_;
    std::atomic<bool> cannot_be_made_ = false; ///< a tile has a size without a transform
    std::atomic<std::uint64_t> made_ = 0;
};

/// Those of the seas that were sampled last. Thread-safe.
class MapsOfSeas {
  public:
    std::shared_ptr<WaveMaps> of(const SeaStatePtr& state, const OwnSeaPtr& waves);
    void forget(std::uint32_t epoch);
    void clear();

  private:
    static constexpr std::size_t seas_max = 4;
    static constexpr std::size_t with_maps_max = 2; ///< each may hold some tens of MB
    std::mutex mutex_;
    std::vector<std::shared_ptr<WaveMaps>> seas_; ///< the one that was sampled last is the last
};

} // namespace seaway::client
