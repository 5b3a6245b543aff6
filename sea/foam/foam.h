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
//         return strains_at(t_us);  // Result<KeyframePtr>, of foam_inputs
//     });
//     history.fill(keyframe.plane(Field::foam));
//     // beside the maps, once a message: law->mean_coverage
//
// A history belongs to one thread. One tick of 256 x 256 takes about 0.15 ms with AVX-512, 0.25 with AVX2, 0.5
// without.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "base/result.h"
#include "sea/basics/field.h"
#include "sea/foam/foam_kernel.h"
#include "sea/foam/foam_law.h"
#include "sea/foam/foam_walk.h"
#include "sea/surface/maps/keyframe.h"

namespace seaway::sea {

/// What a history needs of a keyframe.
inline constexpr FieldSet foam_inputs = strain_fields;

/// Coverage at a point, 0 .. 1, from the mean and the sampled ratio of every cascade.
double foam_coverage(double mean, std::span<const float> ratios);

/// The map of a history in this process's memory: size x size ratios, all 1 at first.
class FoamRatios {
  public:
    explicit FoamRatios(int size, Instructions instructions = best_instructions());

    /// Some values, one after the other. Several threads may each work on a part of its own: its bits are those that it has in the
    /// whole.
    struct Part {
        std::size_t first;
        std::size_t count;
    };
    int parts() const;
    Part part(int n) const;

    /// One tick. `strains`: foam_inputs of its cascade; may be null where the tick looks at none.
    void take(const FoamTick& tick, const Keyframe* strains);
    void take(const FoamTick& tick, const Keyframe* strains, Part part);
    /// The map as a view has it, to `plane`, which is all of it; it stays what it was.
    void show(const FoamView& view, const Keyframe* strains, std::span<float> plane) const;
    void show(const FoamView& view, const Keyframe* strains, std::span<float> plane,
              Part part) const;

    std::span<const float> values() const { return values_; }

  private:
    static constexpr std::size_t part_points = 4096; ///< whole vectors of every instruction set
    /// The strains of the map from `first` on.
    void advance(const FoamTick& tick, const Keyframe* strains, std::span<float> values,
                 std::size_t first) const;

    const FoamKernel* kernel_;
    std::vector<float> values_;
};

class FoamHistory {
  public:
    /// Starts at the average. A calm law keeps it there for ever and looks at no keyframe.
    FoamHistory(FoamLawPtr law, int cascade, int size, TimeUs interval_us,
                Instructions instructions = best_instructions());

    using StrainsAt = std::function<Result<KeyframePtr>(TimeUs)>;

    /// Brings the map to a time: the ticks up to it and, between two ticks, the rest of the way
    /// (FoamWalk). An error is that of strains_at.
    Result<void> advance_to(TimeUs time_us, const StrainsAt& strains_at);

    /// The long part of it, in slices: walks at most `ticks_max` >= 1 ticks of those that
    /// advance_to(time_us) would have to, and says whether all are done; the map stays what it was
    /// until then.
    Result<bool> walk_towards(TimeUs time_us, int ticks_max, const StrainsAt& strains_at);
    /// How many ticks are left of that.
    int ticks_to(TimeUs time_us) const { return walk_.ticks_to(time_us); }

    /// One step of dt >= 0 of the law itself, on no grid; the keyframe must hold foam_inputs of this
    /// cascade, size x size.
    void advance(const Keyframe& strains, double dt_s);

    /// FoamWalk::follow.
    void follow(FoamWalk::LawAt law_at) { walk_.follow(std::move(law_at)); }

    /// The map Field::foam, [y][x], size * size values: finite, >= 0, 1 on average.
    void fill(std::span<float> plane) const;
    std::span<const float> ratios() const { return shown_.empty() ? state_.values() : shown_; }

  private:
    Result<KeyframePtr> strains(const FoamTick& tick, TimeUs time_us, const StrainsAt& strains_at);

    int cascade_;
    FoamWalk walk_;
    FoamRatios state_;
    std::vector<float> shown_; ///< what the map is where it is not state_; else empty
};

} // namespace seaway::sea
