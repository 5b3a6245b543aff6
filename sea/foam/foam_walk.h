// SPDX-License-Identifier: Apache-2.0
// FoamWalk: what a history of foam goes through on its way to a time, as ticks in numbers, for whoever holds its
// map: this process (foam.h) or a device. It knows where the map stands; it knows no map.
//
//     FoamWalk walk(law, cascade, interval_us);
//     while (const std::optional<FoamStep> step = walk.next(time_us))
//         ... ratio = step->tick(ratio, strains at step->time_us), at every point ...
//     const FoamView view = walk.at(time_us);
//     ... shown = 1 + view.departure * (view.tick(ratio, strains at time_us) - 1); ratio stays ...
//
// A step that was given out counts as done; who cannot do it calls restart(). For one thread.
#pragma once

#include <functional>
#include <optional>

#include "sea/foam/foam_kernel.h"
#include "sea/foam/foam_law.h"
#include "sea/foam/foam_ticks.h"

namespace seaway::sea {

/// The share of a history that is left after dt. decay 0: none; decay infinite: all.
double foam_remains(double dt_s, double decay_s);

/// One tick of a cascade by a law under which it breaks; all that is added is multiplied by `weight`.
FoamTick foam_tick(const FoamLaw& law, int cascade, double remains, double weight = 1.0);

/// This cascade says nothing about where waves break.
bool foam_idle(const FoamLaw& law, int cascade);

struct FoamStep {
    TimeUs time_us; ///< when the strains are of
    FoamTick tick;
};

/// What the map Field::foam is at a time, made of that of the last tick.
struct FoamView {
    FoamTick tick{};
    float departure = 1; ///< factor on ratio - 1

    /// It is the map of the last tick itself.
    bool is_state() const {
        return !tick.looks() && tick.remains == 1.0f && tick.added == 0.0f && departure == 1.0f;
    }
};

class FoamWalk {
  public:
    /// Begins at the average. A calm law keeps it there for ever, without a step.
    FoamWalk(FoamLawPtr law, int cascade, TimeUs interval_us);

    /// For seas that change: the law of each moment; ticks stay those of the constructor's law. Where the law of a
    /// tick is calm, its strains are not looked at and the map goes towards the average; where it is there, because no
    /// tick of the start has been of another law, there is no step. Where it `changes` not, until
    /// may_change(), the constructor's law is taken for that of all moments.
    using LawAt = std::function<FoamLawPtr(TimeUs)>;
    void follow(LawAt law_at, bool changes = true) {
        law_at_ = std::move(law_at);
        changes_ = changes;
    }
    void may_change() { changes_ = true; }

    /// Past ticks at which nothing is to be done, so many at most, on the way to a time: the two that follow no longer count
    /// them. Says how many.
    int pass_calm(TimeUs time_us, int most);
    /// How many steps next() has on the way to a time, at most.
    int ticks_to(TimeUs time_us) const;
    /// When the next one is, at the earliest.
    std::optional<TimeUs> next_us(TimeUs time_us) const;
    /// The next one; none: the map is where at() wants it. On from an earlier call these are the ticks since then; at
    /// the first call, back in time, or after a gap longer than the memory, those of the memory (foam_ticks.h). A
    /// start that is half-way is gone on with, also to a later time.
    std::optional<FoamStep> next(TimeUs time_us);
    /// After the last step to that time.
    FoamView at(TimeUs time_us) const;

    /// It has come further than this time.
    bool is_past(TimeUs time_us) const { return started_ && tick_us_ > time_us; }
    /// The map is lost, or stands on no tick: what comes next is a start.
    void restart() { started_ = false; }

    const FoamLaw& law() const { return *law_; }

  private:
    bool follows() const { return law_at_ && changes_; }
    FoamLawPtr law_at(TimeUs time_us) const { return follows() ? law_at_(time_us) : law_; }
    /// What is held, or will be at the end of the start, is on the way to this tick.
    bool goes_on_to(TimeUs tick_us) const;
    void start_for(TimeUs tick_us);
    void forget_before(FoamTick& tick) const;
    /// This cascade says nothing about where waves break, or nothing is remembered.
    bool has_no_history() const;

    FoamLawPtr law_;
    LawAt law_at_; ///< null: it is law_ for ever
    bool changes_ = false;
    int cascade_;
    FoamTicks ticks_;
    bool started_ = false;
    bool fresh_ = false;      ///< the map is that of before the start, to be taken for the average
    TimeUs tick_us_ = 0;      ///< the tick that the map stands at
    TimeUs start_end_us_ = 0; ///< before this tick the start is half-way, and the map no history
    double start_weight_ = 1.0; ///< of what is added until then
};

} // namespace seaway::sea
