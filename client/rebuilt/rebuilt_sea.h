// SPDX-License-Identifier: Apache-2.0
// OwnSea: a sea whose waves this client has itself, so that it answers at any place and time, past or future,
// without keyframes and without asking. RebuiltSea is a steady one, GlidingSea (gliding_sea.h) one on its way to
// another. Both sum the waves directly (sea/waves/reference.h).
//
// Immutable; thread-safe. Cost of an answer: some 2.5 ns a wave, of a gale 30 us for the height, 60 with normal and sheets; some 3 ns a wave for each
// time; where it folds 0.2 to 5 ms more.
#pragma once

#include <functional>
#include <memory>
#include <span>

#include "base/result.h"
#include "protocol/messages.h"
#include "sea/surface/below.h"
#include "sea/waves/probes.h"
#include "sea/waves/reference.h"
#include "sea/waves/transition.h"

namespace seaway::client {

/// Bounds on what the waves of a rebuilt sea are off by at any place and time, m: of waves that were rounded sea::bound_sigmas standard
/// deviations, of strains sea::fold_sigmas.
struct RebuiltError {
    double height_m = 0;
    double displacement_m = 0; ///< of a component of D
    double strain = 0;         ///< of grad D; 0: too little to hide a fold
};

class RebuiltSea;

class OwnSea {
  public:
    virtual ~OwnSea() = default;

    /// Points of equal times should stand together. All of the same length; `terms` may be empty. `cascades`: of these alone,
    /// a bit each. Returns what laying the waves out for the first of their times took, s of this thread: as much in gentle seas as in
    /// steep ones.
    virtual double answer(std::span<const sea::QueryPoint> points, std::span<sea::Answer> answers,
                          std::span<sea::ErrorTerms> terms,
                          std::uint32_t cascades = sea::all_cascades) const = 0;
    /// Its waves at a time, and what they are off by then.
    virtual sea::RealizationPtr waves_at(sea::TimeUs time_us) const = 0;
    virtual RebuiltError error() const = 0;
    /// From what to what it is on its way; null: it is steady.
    virtual const sea::SeaTransition* change() const { return nullptr; }
    /// Calls `look` with the sea of one time.
    virtual void at(sea::TimeUs time_us,
                    const std::function<void(const RebuiltSea&)>& look) const = 0;
};
using OwnSeaPtr = std::shared_ptr<const OwnSea>;

class RebuiltSea final : public OwnSea {
  public:
    /// `state` is of the same sea: of it comes how far points move.
    RebuiltSea(sea::RealizationPtr waves, const protocol::SeaStateValues& state,
               const RebuiltError& error, sea::WaveGrowth growth = {});

    double answer(std::span<const sea::QueryPoint> points, std::span<sea::Answer> answers,
                  std::span<sea::ErrorTerms> terms,
                  std::uint32_t cascades = sea::all_cascades) const override;
    sea::RealizationPtr waves_at(sea::TimeUs) const override { return waves_; }
    RebuiltError error() const override { return error_; }
    void at(sea::TimeUs, const std::function<void(const RebuiltSea&)>& look) const override {
        look(*this);
    }

    /// Its waves at a time, and what laying them out took, s of this thread.
    struct LaidOut {
        sea::DirectSum::Moment moment;
        double took_s;
    };
    LaidOut laid_out(sea::TimeUs time_us, std::uint32_t cascades) const;

    /// Of a moment of sum(), which may be of some cascades alone. `terms`: filled in, or null.
    sea::Answer answer(const sea::QueryPoint& point, const sea::DirectSum::Moment& moment,
                       sea::ErrorTerms* terms = nullptr) const;
    /// With the water at a depth (sea/surface/below.h).
    sea::Answer answer(const sea::QueryPoint& point, double z_m,
                       const sea::DirectSum::Moment& moment, sea::WaterBelow& water) const;
    const sea::DirectSum& sum() const { return sum_; }

  private:
    sea::InverseOptions options(const sea::QueryPoint& point) const;
    /// `area`: the Jacobian of the answer.
    void add_error(const sea::QueryPoint& point, double area, sea::Answer& answer,
                   sea::ErrorTerms* terms) const;

    const sea::RealizationPtr waves_;
    const sea::DirectSum sum_;
    sea::FoldSearch folds_;
    RebuiltError error_;
    double curvature_per_m_; ///< at most
};

using RebuiltSeaPtr = std::shared_ptr<const RebuiltSea>;

/// Is it the sea of this state - of a glide, the one that it leads to -, by the probes that came with it? An error (not_held): it is
/// further from them than eight deviations of its error, where an answer's bound is five, or none came.
Result<void> agrees(const protocol::SeaStateValues& state, const RebuiltSea& sea);

/// Makes the sea of the scene that a sea state brings, and holds it against the probes. Of a glide: the sea that it leads to, whose
/// phases go on from `before`, the waves that the glide begins with; null: they are those of the scene. Errors (not_held): no
/// scene or no probes were sent, the scene cannot be read or names files, its tiles are not those of the sea,
/// or its waves are not: this program draws them otherwise, or the sea has changed on the way. Blocks for
/// as long as the sea takes to be realised (sea/waves/realize.h).
Result<RebuiltSeaPtr> rebuild_from_scene(const protocol::SeaStateValues& state,
                                         const sea::Realization* before = nullptr);

} // namespace seaway::client
