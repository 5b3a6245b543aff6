// SPDX-License-Identifier: Apache-2.0
// Foam while one sea glides over to another: the law of each moment. The mean coverage glides with the amplitudes
// (glide_share) between those of the two seas; where crests break is by the waves of the moment and a threshold that
// glides likewise, taken in steps, of which a history notices nothing: it holds what has broken, not what breaks.
// Where only one of the seas has foam, its threshold holds throughout.
//
// Thread-safe. A step costs what make_foam_law() does, once.
#pragma once

#include <array>
#include <mutex>

#include "sea/foam/foam_law.h"
#include "sea/waves/transition.h"

namespace seaway::sea {

class FoamGlide {
  public:
    /// `change` outlives it.
    FoamGlide(const SeaTransition& change, FoamLawPtr from, FoamLawPtr to)
        : change_(change), from_(std::move(from)), to_(std::move(to)) {}

    /// Nothing breaks on the way either.
    bool calm() const { return from_->calm() && to_->calm(); }
    /// Between which the threshold glides.
    double first_threshold() const {
        return from_->calm() && !to_->calm() ? to_->threshold : from_->threshold;
    }
    double last_threshold() const {
        return to_->calm() && !from_->calm() ? from_->threshold : to_->threshold;
    }
    /// The law to go on by at this time; its mean coverage is not what the sea's glides through. Where both are calm it is
    /// the first until the glide ends, and nothing is made.
    FoamLawPtr at(TimeUs time_us) const;

  private:
    static constexpr int steps = 16;

    const SeaTransition& change_;
    const FoamLawPtr from_;
    const FoamLawPtr to_;
    mutable std::mutex mutex_;
    mutable std::array<FoamLawPtr, steps> laws_; ///< in the middle of each step of the share
};

} // namespace seaway::sea
