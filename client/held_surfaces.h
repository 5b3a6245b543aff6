// SPDX-License-Identifier: Apache-2.0
// Held surfaces: those that a client made last of the keyframes that it holds, ready for the next points of the same keyframes.
//
// Thread-safe. Nothing is allocated where the keyframes' splines are made already: surfaces are made in places that are there from the
// beginning. One is used for as long as the ring would give the same keyframes.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <limits>
#include <mutex>
#include <optional>

#include "client/local_surface.h"

namespace seaway::client {

/// Times with the same keyframes, from_us <= time < until_us.
struct TimeSpan {
    sea::TimeUs from_us = std::numeric_limits<sea::TimeUs>::min();
    sea::TimeUs until_us = std::numeric_limits<sea::TimeUs>::max();

    bool contains(sea::TimeUs time_us) const { return from_us <= time_us && time_us < until_us; }
    TimeSpan within(const TimeSpan& other) const;
};

/// The times of one time_cell().
TimeSpan cell_span(const SeaState& state, sea::TimeUs time_us);

class HeldSurfaces {
    struct Place {
        std::atomic<int> users = 0; ///< grows with mutex_ held alone
        std::uint64_t last_used = 0;
        SeaStatePtr state;
        sea::FieldSet fields;
        std::uint32_t cascades = 0;
        TimeSpan times;
        std::uint64_t ring_changes = 0;
        std::optional<LocalSurface> local;
    };

  public:
    /// A surface that stays while this lives.
    class Lent {
      public:
        Lent() = default;
        ~Lent();
        Lent(const Lent&) = delete;
        Lent& operator=(const Lent&) = delete;

        const LocalSurface& operator*() const { return place_ ? *place_->local : *own_; }
        const LocalSurface* operator->() const { return &**this; }
        /// It is of every time of these.
        const TimeSpan& times() const { return place_ ? place_->times : own_times_; }

      private:
        friend class HeldSurfaces;
        void give_back();

        Place* place_ = nullptr;
        std::optional<LocalSurface> own_; ///< where all places are taken
        TimeSpan own_times_;
    };

    /// The surface around one time, as local_surface().
    Result<void> lend(const SeaStatePtr& state, const KeyframeRing& ring, sea::TimeUs time_us,
                      sea::FieldSet fields, Lent& lent, std::uint32_t cascades = sea::all_cascades);
    /// The same, of those that are made already: at once.
    bool find(const SeaStatePtr& state, const KeyframeRing& ring, sea::TimeUs time_us,
              sea::FieldSet fields, Lent& lent, std::uint32_t cascades = sea::all_cascades);
    /// For whoever asks a surface of these again and again about one time.
    sea::MixedMaps& mixed() { return mixed_; }
    /// Lets go of keyframes that the ring has let go.
    void follow(const KeyframeRing& ring);

  private:
    static bool fits(const Place& place, const SeaStatePtr& state, sea::TimeUs time_us,
                     sea::FieldSet fields, std::uint32_t cascades);
    void take(Place& place, Lent& lent);

    static constexpr std::size_t places = 4;

    std::mutex mutex_;
    std::array<Place, places> places_;
    std::uint64_t uses_ = 0;
    sea::MixedMaps mixed_;
};

} // namespace seaway::client
