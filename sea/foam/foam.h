// SPDX-License-Identifier: Apache-2.0
// Foam: where waves have broken lately, as state of the server in undisplaced coordinates.
//
// Coverage f obeys f(t+dt) = f exp(-dt/tau) + gain * shortfall * tau (1 - exp(-dt/tau)): the same
// at any tick and after any pause, bounded, and contractive: after a few decay times nobody can
// tell how a history began. shortfall = max(0, threshold - J) with J of the summed strains. Tiles
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
//     const FoamLawPtr law = make_foam_law(*sea.realization, sea.scene.foam);  // once a sea
//     FoamHistory history(law, cascade, size);                 // one a cascade that someone wants
//     // each keyframe: does one tick, or warms up after a pause or at the first call
//     Result<void> done = history.advance_to(time_us, interval_us, [&](TimeUs t_us) {
//         return synthesize_one({cascade, t_us, foam_inputs});  // Result<KeyframePtr>
//     });
//     history.fill(keyframe.plane(Field::foam));
//     // beside the maps, once a message: the mean; after a change of the sea it drifts to the new
//     mean = relax_foam_mean(mean, *law, dt_s);                // starts as law->mean_coverage
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
#include "sea/surface/keyframe.h"

namespace seaway::sea {

/// What a history needs of a keyframe.
inline constexpr FieldSet foam_inputs{Field::strain_xx, Field::strain_yy, Field::strain_xy};

/// A history starts, or starts anew after a longer pause, this many decay times back: what came
/// before counts for 0.25 % and is taken as average.
inline constexpr double foam_memory_decays = 6.0;

/// Ticks of one warm-up at most; a longer memory is walked in longer ticks.
inline constexpr int foam_warm_up_ticks_max = 64;

/// The share of a history that is left after dt. decay 0: none; decay infinite: all.
double foam_remains(double dt_s, double decay_s);

/// The mean coverage after dt under a law, from `mean` before; what is left below 1e-4 on a calm
/// sea is 0 (hard case E4).
double relax_foam_mean(double mean, const FoamLaw& law, double dt_s);

/// Coverage at a point, 0 .. 1, from the mean and the sampled ratio of every cascade.
double foam_coverage(double mean, std::span<const float> ratios);

class FoamHistory {
  public:
    /// Starts at the average. A calm law keeps it there for ever and looks at no keyframe.
    FoamHistory(FoamLawPtr law, int cascade, int size,
                Instructions instructions = best_instructions());

    using StrainsAt = std::function<Result<KeyframePtr>(TimeUs)>;

    /// Brings the history to a keyframe time. One interval on: one tick with the strains at
    /// time_us. First call, back in time, or a gap above foam_memory_decays: starts anew and walks
    /// through that memory in at most foam_warm_up_ticks_max ticks. An error is that of strains_at.
    Result<void> advance_to(TimeUs time_us, TimeUs interval_us, const StrainsAt& strains_at);

    /// One tick of dt >= 0, ending at the keyframe's time; it must hold foam_inputs of this
    /// cascade, size x size.
    void advance(const Keyframe& strains, double dt_s);

    /// Goes on under the law of a changed sea; what has broken under the old one fades out.
    void change_law(FoamLawPtr law);

    /// Forgets: back to the average.
    void restart();

    /// The map Field::foam, [y][x], size * size values: finite, >= 0, 1 on average.
    void fill(std::span<float> plane) const;
    std::span<const float> ratios() const { return ratios_; }

  private:
    FoamLawPtr law_;
    int cascade_;
    const FoamKernel* kernel_;
    bool started_ = false;
    TimeUs time_us_ = 0;
    std::vector<float> ratios_;
};

} // namespace seaway::sea
