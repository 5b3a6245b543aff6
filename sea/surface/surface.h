// SPDX-License-Identifier: Apache-2.0
// Surface: the sea at any point in a span of time, from two keyframes a cascade.
//
// Bicubic splines in space, cubic Hermite in time (maps carry their time rates), all cascades
// summed before the displacement is inverted (hard case D6). The server's answers, a client's own
// answers and the height of a rendered vertex all come from here.
//
// Immutable; thread-safe; allocates nothing but what searches for sheets keep for the next one of their thread. Where the surface is
// gentle and alone, which bounds prove place by place, points are solved some at a time (point_kernel.h): see
// docs/performance/points.md for what they cost. Elsewhere one by one, with all sheets, ten to fifty times that.
#pragma once

#include <initializer_list>
#include <span>

#include "base/short_list.h"
#include "sea/surface/answer.h"
#include "sea/surface/inverse.h"
#include "sea/surface/map_error.h"
#include "sea/surface/maps/spline_map.h"
#include "sea/surface/mixed_maps.h"
#include "sea/surface/point_kernel.h"
#include "sea/waves/realization.h"

namespace seaway::sea {

/// The two keyframes of one cascade that a time lies between; they may be the same map.
struct SplinePair {
    SplineMapPtr before;
    SplineMapPtr after;
};

/// How points are answered.
struct Answering {
    AnswerParts parts = AnswerParts::all;
    /// Of who asks about the same times again, with one surface and others.
    MixedMaps* mixed = nullptr;
    /// One a point, or none. Answers with them end as near to the solution as without, but not with the same bits.
    std::span<PointMemory> memory = {};
    /// One a point, filled in, or none.
    std::span<ErrorTerms> terms = {};
};

class Surface {
  public:
    /// `pairs` may be any subset of the cascades, surface_pairs_max at most; `error` is of these.
    Surface(std::span<const SplinePair> pairs, Choppiness choppiness, FoldSearch folds,
            const MapError& error, double tolerance_m = InverseOptions{}.tolerance_m);
    Surface(std::initializer_list<SplinePair> pairs, Choppiness choppiness, FoldSearch folds,
            const MapError& error, double tolerance_m = InverseOptions{}.tolerance_m)
        : Surface(std::span(pairs.begin(), pairs.size()), choppiness, folds, error, tolerance_m) {}

    /// The undisplaced sea. Beyond a pair's span the sea soon stands (hermite_beyond).
    LagrangianPoint at(double x_m, double y_m, TimeUs time_us) const;

    /// Height, normal, velocity above a world point, with a bound on the error of the height. A
    /// time outside the span of a pair is flagged answer_extrapolated.
    Answer answer(const QueryPoint& point) const;

    /// The same bits as one by one, in two thirds of the time. Points of one time should stand together.
    void answer(std::span<const QueryPoint> points, std::span<Answer> answers,
                const Answering& how = {}) const;
    /// The same by a kernel of the caller's choice: all kernels give the same bits.
    void answer(std::span<const QueryPoint> points, std::span<Answer> answers, const Answering& how,
                const PointKernel& kernel) const;
    /// With the search for sheets whether it is needed or not, and Newton in double precision.
    Answer answer_carefully(const QueryPoint& point) const;

    /// Another one for each surface of the process.
    std::uint64_t number() const { return number_; }
    /// Its maps at one time, for MixedMaps.
    void mix(TimeUs time_us, const PointKernel& kernel, std::span<const AlignedFloats> maps) const;

    std::span<const SplinePair> pairs() const { return {pairs_.data(), pairs_.size()}; }
    const Choppiness& choppiness() const { return choppiness_; }
    const FoldSearch& folds() const { return folds_; }
    const MapError& map_error() const { return error_; }
    /// Bound on a height where the surface is that steep, at the worst place and time between samples.
    double height_bound_m(double slope) const;
    double flat_height_bound_m() const { return flat_height_bound_m_; } ///< of slope 0
    /// What maps may be wrong by where folds are told apart: of lambda D, m, and of lambda grad D.
    double fold_blur_m() const { return fold_blur_m_; }
    double fold_strain_blur() const { return fold_strain_blur_; }

    /// The time lies between the keyframes of every pair.
    bool covers(TimeUs time_us) const;

  private:
    struct AtTime;
    class TimesOfBlock;
    /// between_samples() of a place on the grid of a cascade.
    template <class Real>
    struct Between {
        Real east;
        Real north;
    };
    template <class Real, class BetweenOf>
    Real height_bound_m(const BetweenOf& between, const AtTime& then, const Real& sideways) const;
    template <class BetweenOf>
    ErrorTerms terms_of(const BetweenOf& between, const AtTime& then, double sideways) const;
    /// `terms`: filled in, or null.
    Answer careful(const QueryPoint& point, const AtTime& then, ErrorTerms* terms) const;
    /// Of those that were solved, but for velocities; `then` and `to`: one a point.
    void gentle(const PointBlock& points, const AtTime* const* then, Answer* const* to) const;
    template <class Some>
    void tell(const Some& some, const AtTime& then, Answer* const* to) const;
    ErrorTerms gentle_terms(const PointBlock& points, std::size_t p, const AtTime& then,
                            const Answer& answer) const;
    /// PointBlock::size points at most, whose times are `then`.
    void answer_block(std::span<const QueryPoint> points, std::span<Answer> answers,
                      const Answering& how, const PointKernel& kernel,
                      std::span<const PointTile> tiles, std::span<const AtTime* const> then) const;
    std::uint32_t lasting_flags(TimeUs time_us) const;

    std::uint64_t number_;
    ShortList<SplinePair, surface_pairs_max> pairs_;
    Choppiness choppiness_;
    FoldSearch folds_;
    MapError error_;
    double tolerance_m_;
    double sideways_; ///< the larger choppiness
    double fold_blur_m_;
    double fold_strain_blur_;
    double flat_height_bound_m_;
    ShortList<PointTile, surface_pairs_max> tiles_; ///< of pairs_, for kernels
    bool moves_sideways_ = true;                    ///< every map does
};

} // namespace seaway::sea
