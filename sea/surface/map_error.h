// SPDX-License-Identifier: Apache-2.0
// What maps cost in accuracy, and the bound on a height that follows from it.
//
// Errors of different waves, cascades, fields and causes have nothing to do with each other, so they are
// added in the square: everything here is a standard deviation unless it is called a bound. A stated
// bound is five standard deviations at the time and place of the answer, which one answer in a million
// exceeds if its errors are normal, and what single precision and the inverse leave is added to it.
//
// Pure; thread-safe. Some 20 ns a cascade.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "base/short_list.h"
#include "sea/basics/deviations.h"
#include "sea/basics/time.h"
#include "sea/surface/maps/hermite.h"

namespace seaway::sea {

/// 16 s^2 (1-s)^2: 0 at the ends of a cell, where maps and keyframes are right, 1 in its middle.
template <class Real>
[[gnu::always_inline]] inline Real between_samples(const Real& s) {
    const Real u = 4.0 * s * (1.0 - s);
    return u * u;
}

/// How near to half way: (4 s (1-s))^3, by which what coding leaves of predicted keyframes goes over to what it is there. So all
/// scenes have it (PredictedNoise.*).
inline double between_keyframes(double share) {
    const double u = 4.0 * share * (1.0 - share);
    return u * u * u;
}

/// Largest sum of the squared Hermite weights of two values and two rates, a rate over the interval having
/// `rate` times the variance of a value. They meet neither at a keyframe nor quite in the middle.
inline double codec_peak(double rate) {
    double largest = 1.0;
    for (int i = 1; i <= 16; ++i) {
        const double s = i / 32.0, r = 1.0 - s;
        const double before = r * r * (1.0 + 2.0 * s), after = s * s * (1.0 + 2.0 * r);
        largest = std::max(largest, before * before + after * after +
                                        rate * s * s * r * r * (s * s + r * r));
    }
    return largest;
}

/// Standard deviations of what one map of one cascade misses, in m of its value.
struct MapLoss {
    double time_m = 0;   ///< between keyframes, in the middle of the two
    double east_m = 0;   ///< between grid points, in the middle of a cell from west to east
    double north_m = 0;  ///< likewise from south to north
    double value_m = 0;  ///< by coding, of values at grid points
    double rate_mps = 0; ///< by coding, of time rates at grid points
    /// By coding, half way between two keyframes, of what runs along with the waves (CodedNoise); 0: values and rates of both
    /// have nothing to do with each other.
    double between_m = 0;
    double cut_m = 0; ///< everywhere and at any time: of waves that the map was sent without
    /// What a spline leaves out of a coded value's variance in the middle of a cell, by axis: a fifth where errors at
    /// the grid points are independent; nothing where they are long waves, coded on a smaller grid.
    double coded_relief = 0.2;

    /// Between grid points and keyframes, anywhere and at any time.
    double interpolation_variance_m2() const {
        return time_m * time_m + east_m * east_m + north_m * north_m + cut_m * cut_m;
    }
    /// All of it, keyframes `interval_s` apart.
    double largest_variance_m2(double interval_s) const {
        const double value_m2 = value_m * value_m;
        if (between_m > 0)
            return interpolation_variance_m2() + std::max(value_m2, between_m * between_m);
        const double rate_m2 = rate_mps * rate_mps * interval_s * interval_s;
        return interpolation_variance_m2() +
               (value_m2 > 0 ? value_m2 * codec_peak(rate_m2 / value_m2) : rate_m2 / 32.0);
    }
    /// Between two keyframes whose weights are `w`, `share` of their interval after the first; `east` and
    /// `north` are between_samples() of the place. Of independent errors at the grid points a spline makes
    /// less between them: by axis 0.756 of their variance in the middle of a cell, and nowhere more than
    /// 1 - 0.2 between_samples().
    double variance_m2(double share, double east, double north, const HermiteWeights& w) const {
        return at(share, w).variance_m2(east, north);
    }
    /// The same of one time, for many places. Real: double, or a vector of them, of several places side by side.
    struct AtTime {
        double time_m2;
        double cut_m2;
        double east_m2;
        double north_m2;
        double coded_m2;
        double coded_relief;
        template <class Real>
        [[gnu::always_inline]] Real variance_m2(const Real& east, const Real& north) const {
            return time_m2 + cut_m2 + east_m2 * east + north_m2 * north +
                   coded_variance_m2(east, north);
        }
        double space_variance_m2(double east, double north) const {
            return cut_m2 + east_m2 * east + north_m2 * north;
        }
        template <class Real>
        [[gnu::always_inline]] Real coded_variance_m2(const Real& east, const Real& north) const {
            return coded_m2 * (1.0 - coded_relief * east) * (1.0 - coded_relief * north);
        }
    };
    AtTime at(double share, const HermiteWeights& w) const {
        // Outside it is no bound, but grows in time; as far out as that it is of the height of the waves.
        const double time = time_m * between_samples(std::clamp(share, -2.0, 3.0));
        double coded = value_m * value_m * (w.value[0] * w.value[0] + w.value[2] * w.value[2]) +
                       rate_mps * rate_mps * (w.value[1] * w.value[1] + w.value[3] * w.value[3]);
        if (between_m > 0)
            coded = value_m * value_m + (between_m * between_m - value_m * value_m) *
                                            between_keyframes(std::clamp(share, 0.0, 1.0));
        return {time * time,       cut_m * cut_m, east_m * east_m,
                north_m * north_m, coded,         coded_relief};
    }
};

/// Of one cascade.
struct CascadeLoss {
    MapLoss height;
    MapLoss displacement; ///< of D, both components together
};

/// What maps of one cascade miss that come coarser than its sea says: further apart in time, or without their finest
/// waves.
struct CoarserLoss {
    TimeUs interval_us = 0;         ///< keyframes come so far apart; 0: neither
    double time_m = 0;              ///< MapLoss::time_m at that interval, of heights
    double displacement_time_m = 0; ///< and of D
    double cut_m = 0;               ///< MapLoss::cut_m of heights
    double displacement_cut_m = 0;  ///< and of D
    double strain = 0;              ///< of grad D by both, fold_sigmas standard deviations

    bool operator==(const CoarserLoss&) const = default;
};

/// What coding has left of the heights of a keyframe that was predicted, as its server found: rms over the map, m. It runs along
/// with the waves, so that it is of one pair of keyframes and of no other.
struct CodedNoise {
    std::uint64_t number = 0; ///< its own, among all keyframes of its server
    std::uint64_t before = 0; ///< that of the keyframe that it followed
    TimeUs before_us = 0;     ///< and its time
    double at_m = 0;          ///< at its own time; 0: nobody says
    double between_m =
        0; ///< half way between the two, or what MapLoss says elsewhere were too little; 0: it followed none

    bool operator==(const CodedNoise&) const = default;
};

/// A surface has no more cascades than this.
inline constexpr std::size_t surface_pairs_max = 16;

/// Of all maps of a surface.
struct MapError {
    ShortList<CascadeLoss, surface_pairs_max>
        cascades;                    ///< in the order of the surface's pairs, or empty
    double height_bound_m = 0;       ///< beside those: single precision
    double displacement_bound_m = 0; ///< likewise, of D
    double strain_bound = 0;         ///< of grad D: interpolation and single precision
    double codec_strain_bound = 0;   ///< of lambda grad D
    double rms_slope = 0;            ///< of the sea
    double curvature_per_m = 0;      ///< of the surface at choppiness 0, at most
};

/// Bound on a height where and when maps are worst, of a surface that is `sideways` higher a metre that a point is moved at
/// choppiness 1; interval_s(c): between the keyframes of a cascade.
template <class IntervalOf>
double largest_height_bound_m(const MapError& error, double sideways,
                              const IntervalOf& interval_s) {
    double variance_m2 = 0;
    for (std::size_t c = 0; c < error.cascades.size(); ++c) {
        const CascadeLoss& loss = error.cascades[c];
        variance_m2 += loss.height.largest_variance_m2(interval_s(c)) +
                       sideways * sideways * loss.displacement.largest_variance_m2(interval_s(c));
    }
    return bound_sigmas * std::sqrt(variance_m2) + error.height_bound_m +
           sideways * error.displacement_bound_m;
}

} // namespace seaway::sea
