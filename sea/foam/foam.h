// SPDX-License-Identifier: Apache-2.0
// Foam: where waves have broken lately, as state of the server in undisplaced coordinates.
//
// Coverage f obeys f(t+dt) = f exp(-dt/tau) + gain * shortfall * tau (1 - exp(-dt/tau)): the same
// at any tick and after any pause, bounded, and contractive. Ticks lie on a grid of sea time
// (foam_ticks.h), so that foam at a time is the same after a restart, for another client and in a
// picture made alone: to 1e-4 of the spread of the ratios, in a loop to rounding. shortfall = max(0, threshold - J), plus the
// model's bias where it is not 0, with J of the summed strains. Tiles
// are not commensurate, so each cascade keeps the history of the expected shortfall given its own
// waves (foam_law.h), as its ratio to the mean; the map Field::foam is that ratio, 1 on average.
// Sampled at an undisplaced point X, never at the displaced one (traps T51):
//
//     F(X) = clamp(mean * (2 product over cascades of (1 + ratio_c(X mod length_c)) / 2 - 1), 0, 1)
//
// Maps are not clamped, samples are (T50). One cascade: F = mean * ratio. Several: the sum of what
// each cascade says alone, plus half of what they would say together if breaking were not averaged
// over time; the half is measured. Against one brute-force history of the joint Jacobian the mean
// coverage is within 2 %, the correlation 0.63 to 0.84; docs/foam.md has the table and the
// combinations that are worse.
//
//     const FoamLawPtr law = make_foam_law(sea.scene, *sea.realization);  // once a sea
//     FoamHistory history(law, cascade, size, interval_us);    // one a cascade that someone wants
//     // each keyframe: does the ticks that are due, or starts anew after a pause or at the first call
//     Result<void> done = history.advance_to(time_us, [&](TimeUs t_us) {
//         return synthesize_one({cascade, t_us, foam_inputs});  // Result<KeyframePtr>
//     });
//     history.fill(keyframe.plane(Field::foam));
//     // beside the maps, once a message: law->mean_coverage
//
// A history belongs to one thread. One tick of 256 x 256 takes about 0.25 ms with AVX2, 0.5 ms
// without.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "base/result.h"
#include "sea/basics/field.h"
#include "sea/foam/foam_kernel.h"
#include "sea/foam/foam_law.h"
#include "sea/foam/foam_ticks.h"
#include "sea/surface/maps/keyframe.h"

namespace seaway::sea {

/// What a history needs of a keyframe.
inline constexpr FieldSet foam_inputs{Field::strain_xx, Field::strain_yy, Field::strain_xy};

/// The share of a history that is left after dt. decay 0: none; decay infinite: all.
double foam_remains(double dt_s, double decay_s);

/// Coverage at a point, 0 .. 1, from the mean and the sampled ratio of every cascade.
double foam_coverage(double mean, std::span<const float> ratios);

class FoamHistory {
  public:
    /// Starts at the average. A calm law keeps it there for ever and looks at no keyframe.
    FoamHistory(FoamLawPtr law, int cascade, int size, TimeUs interval_us,
                Instructions instructions = best_instructions());

    using StrainsAt = std::function<Result<KeyframePtr>(TimeUs)>;

    /// Brings the map to a time: the ticks up to it and, between two ticks, the rest of the way. On
    /// from an earlier call it asks for the strains of the ticks since then; at the first call, back
    /// in time, or after a gap longer than the memory, for those of the memory (foam_ticks.h). An
    /// error is that of strains_at.
    Result<void> advance_to(TimeUs time_us, const StrainsAt& strains_at);

    /// The long part of it, in slices: walks at most `ticks_max` >= 1 ticks of those that
    /// advance_to(time_us) would have to, and says whether all are done; the map stays what it was
    /// until then. A start that is half-way is gone on with, also to a later time.
    Result<bool> walk_towards(TimeUs time_us, int ticks_max, const StrainsAt& strains_at);
    /// How many ticks are left of that.
    int ticks_to(TimeUs time_us) const;

    /// One step of dt >= 0 of the law itself, on no grid; the keyframe must hold foam_inputs of this
    /// cascade, size x size.
    void advance(const Keyframe& strains, double dt_s);

    /// For seas that change: the law of each moment; ticks stay those of the constructor's law. Where the law of a tick
    /// is calm, its strains are not looked at and the map goes towards the average.
    using LawAt = std::function<FoamLawPtr(TimeUs)>;
    void follow(LawAt law_at) { law_at_ = std::move(law_at); }

    /// The map Field::foam, [y][x], size * size values: finite, >= 0, 1 on average.
    void fill(std::span<float> plane) const;
    std::span<const float> ratios() const { return shown_.empty() ? state_ : shown_; }

  private:
    /// state -> state after dt with these strains; all that is added is multiplied by `weight`.
    void step(const FoamLaw& law, std::vector<float>& state, const Keyframe& strains, double dt_s,
              double decay_s, double weight = 1.0) const;
    /// One step in which nothing breaks anywhere more than elsewhere.
    void forget(double dt_s, double weight);
    FoamLawPtr law_at(TimeUs time_us) const { return law_at_ ? law_at_(time_us) : law_; }
    /// What is held, or will be at the end of the start, is on the way to this tick.
    bool goes_on_to(TimeUs tick_us) const;
    void start_for(TimeUs tick_us);
    /// This cascade says nothing about where waves break, or nothing is remembered.
    bool has_no_history() const;
    bool idle(const FoamLaw& law) const; ///< this cascade says nothing about where waves break

    FoamLawPtr law_;
    LawAt law_at_; ///< null: it is law_ for ever
    int cascade_;
    TimeUs interval_us_;
    FoamTicks ticks_;
    const FoamKernel* kernel_;
    bool started_ = false;
    TimeUs tick_us_ = 0;        ///< the tick that state_ stands at
    TimeUs start_end_us_ = 0;   ///< before this tick the start is half-way, and state_ no history
    double start_weight_ = 1.0; ///< of what is added until then
    std::vector<float> state_;  ///< ratio of the history
    std::vector<float> shown_;  ///< what the map is where it is not state_; else empty
};

} // namespace seaway::sea
