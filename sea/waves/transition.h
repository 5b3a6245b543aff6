// SPDX-License-Identifier: Apache-2.0
// From one sea to the next without a jump (hard cases A22, I7).
//
// Both seas draw the same numbers, so what changes are amplitudes and, when depth, gravity or the
// loop change, frequencies. At the moment of change each wave keeps its phase: what the old
// frequency has turned it by and the new one would not have is folded into h0 as an exact number of
// 2^-64 turns. Then the amplitudes glide over, smoothly at both ends. While they do, phases run on
// past the end of either loop.
//
//     SeaTransition change(old_sea, new_sea, start_us, end_us);    // error if the tiles differ
//     RealizationPtr sea = change->at(time_us);                    // about 1 ms a 256 x 256
//     cascade
//
// What goes on is the clock of a wave; the phase that its scene gives it is its own. A wave that only the new sea has, or a
// stylised one of another vector, grows with its own clock, so that a sea whose waves run as those before it is that of
// its scene alone, whatever it glided from. A restarted server that replays the same changes gets the same sea.
// Immutable; thread-safe.
#pragma once

#include <span>

#include "base/result.h"
#include "sea/basics/field.h"
#include "sea/basics/glide.h"
#include "sea/waves/realization.h"
#include "sea/waves/reference.h"

namespace seaway::sea {

/// `to` with each phase, at this time, that of `from`, whose amplitudes are not looked at: both may be clocks alone (realize_clocks()).
/// Errors: cascades of other lengths or sizes.
Result<RealizationPtr> continued(const Realization& from, const Realization& to, TimeUs time_us);

class SeaTransition {
  public:
    /// Frequencies change at `start_us`; amplitudes between it and `end_us` >= start_us. `from` may
    /// be a sea that transitions have led to. Errors: cascades of other lengths or sizes.
    static Result<SeaTransition> create(RealizationPtr from, RealizationPtr to, TimeUs start_us,
                                        TimeUs end_us);

    /// The sea to be evaluated at this time: `from` before the start, `after()` from the end on. Between
    /// them it repeats with neither loop. Rates are those of the waves as they stand: the glide itself, which growing_at()
    /// has, adds at most 1.875 times the change of a height a duration.
    RealizationPtr at(TimeUs time_us) const;

    /// The same with the frequencies of the new sea at any time: all of the old sea before the start, all of the
    /// new one after the end. At its two ends it joins at() without a jump.
    /// Of these cascades alone, a bit each; what others have is not worked out (CascadeModes::is_there).
    RealizationPtr gliding(TimeUs time_us, std::uint32_t cascades = all_cascades) const;
    /// gliding() when there is this share of the new sea.
    RealizationPtr with_share(double share, std::uint32_t cascades = all_cascades) const;

    /// The new sea less the old one, with the depth of gliding() at this time: what its maps, times glide_rate(), add
    /// to the time rates of gliding()'s, which are those of waves that stand.
    RealizationPtr growth(TimeUs time_us, std::uint32_t cascades = all_cascades) const;
    /// growth() and what it counts with, for the exact sum; nothing at times that do not lie within the glide.
    WaveGrowth growing_at(TimeUs time_us) const;
    /// growth() for displacements, where the depth glides too: a wave of one height moves water further sideways as it
    /// becomes shallower.
    RealizationPtr displacement_growth(TimeUs time_us, std::uint32_t cascades = all_cascades) const;

    /// Whose maps' rates gain by growth(), and whose by displacement_growth(): nobody's where the depth stays.
    FieldSet grown() const;
    FieldSet grown_otherwise() const;
    /// rate += glide_rate() grown: onto a map of rates, from one of what its values grow by.
    void add_growth(std::span<float> rate, std::span<const float> grown, TimeUs time_us) const;

    /// Of the waves of this cascade that are there at any time of the glide, rad/m.
    double longest_radpm(std::size_t cascade) const;

    /// A sea none of whose waves is ever smaller than in the glide, with the larger choppiness and in the shallower
    /// water: what is bounded for it is bounded for gliding() at every time.
    RealizationPtr envelope() const;

    /// `to`, with every phase continuous at the start.
    const RealizationPtr& after() const { return after_; }

    TimeUs start_us() const { return start_us_; }
    TimeUs end_us() const { return end_us_; }

  private:
    SeaTransition() = default;
    bool changes_depth() const;

    RealizationPtr from_;
    // With the frequencies of the new sea and no loop, phases continuous at the start:
    RealizationPtr fading_;  ///< `from`'s amplitudes
    RealizationPtr growing_; ///< those of `to`
    RealizationPtr after_;   ///< on the loop of `to`
    TimeUs start_us_ = 0;
    TimeUs end_us_ = 0;
};

} // namespace seaway::sea
