// SPDX-License-Identifier: Apache-2.0
// FoamLaw: what breaking means for one sea, in numbers: the mean foam coverage, and for each
// cascade the expected breaking at a point given that cascade's own strains.
//
// A point breaks while J = (1+a)(1+b) - c^2 < threshold, where a = lx Dxx, b = ly Dyy,
// c = sqrt(lx ly) Dxy are sums over all cascades (traps T47, hard case E6). Tiles of different
// length meet each other in every phase, so the history of a cascade cannot hold the joint J. It
// holds the conditional expectation of the shortfall max(0, threshold - J) given its own strains
// (a, b, c); the others (a', b', c') are Gaussian with the second moments of the realised modes.
// Along T' = a' + b', the others' compression, J is a parabola:
//
//     J(T') = J_own + beta T' + gamma (T'^2 - V),      J_own = (1+a)(1+b) - c^2
//     V = E[T'^2],  d = E[T'(a'-b')] / V,  k = E[T'c'] / V
//     beta = ((2 + a + b) - d (a - b) - 4 k c) / 2,  gamma = (1 - d^2 - 4 k^2) / 4
//
// (kx^2 ky^2 = (kx ky)^2, so E[a'b'] = E[c'^2] and E[J | own] = J_own),
// and what T' leaves open of a'-b' and c' widens beta, so that the variance of J given the own
// strains is exact. The mean of max(0, threshold - J) under that parabola has a closed form. Its
// average over the own strains is within some percent of the truth (docs/foam.md) and is divided
// out, so that the mean foam of a sea is exact.
//
// What breaking makes of a point is its shortfall and, where it breaks at all, the model's bias:
// breaking = max(0, threshold - J) + (J < threshold ? bias : 0).
//
// Immutable values and pure functions; thread-safe.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sea/basics/foam_range.h"
#include "sea/foam/whitecaps.h"
#include "sea/scene/scene.h"
#include "sea/waves/realization.h"

namespace seaway::sea {

/// Second moments of a, b, c: averages over time and place, 1.
struct StrainMoments {
    double aa = 0;
    double bb = 0;
    double cc = 0;
    double ab = 0;
    double ac = 0;
    double bc = 0;

    StrainMoments& operator+=(const StrainMoments& other);
    friend StrainMoments operator+(StrainMoments x, const StrainMoments& y) { return x += y; }
};

/// Of the realised modes of one cascade: every travelling wave has variance 2 |h0(k)|^2.
StrainMoments strain_moments(const CascadeModes& modes, const Choppiness& choppiness);

/// E[max(0, threshold - J)] for Gaussian strains; relative error about 1e-5.
double mean_shortfall(double threshold, const StrainMoments& moments);

/// P(J < threshold) for Gaussian strains: the share of undisplaced area that breaks at any moment.
/// For long-crested waves Phi((threshold - 1) / (lambda sqrt(mss))).
double breaking_share(double threshold, const StrainMoments& moments);

/// What the other cascades do to J at a point, in the terms of the file banner.
struct OthersShape {
    double variance = 0;        ///< V
    double difference = 0;      ///< d
    double shear = 0;           ///< k
    double difference_rest = 0; ///< Var(a'-b' - d T')
    double shear_rest = 0;      ///< Var(c' - k T')
    double cross_rest = 0;      ///< their covariance
};

OthersShape others_shape(const StrainMoments& others);

/// E[max(0, threshold - J) | own a, b, c] + bias P(J < threshold | own a, b, c), see above, in double
/// precision. The history computes the same in single precision (foam.cpp).
double conditional_breaking(double threshold, double bias, const OthersShape& others, double a,
                            double b, double c);

/// Coverage below this on average is no foam at all: the law is calm and nothing is computed.
inline constexpr double foam_mean_min = 1e-6;

/// Where a threshold comes from that the scene does not give.
struct ObservedFoam {
    FoamWind wind;
    double share = 0; ///< whitecap_share() of that wind: what the mean coverage is to be
};

struct FoamLaw {
    FoamModel model;      ///< as the scene has it
    double threshold = 0; ///< of the model, or what gives the observed share; -1 .. 1
    std::optional<ObservedFoam> observed; ///< where the model has no threshold
    Choppiness choppiness;
    TimeUs loop_period_us = 0; ///< of the sea; 0: never repeats
    double mean_coverage = 0;  ///< F in equilibrium, before clamping: gain tau E[breaking]; or 0;
                               ///< at most foam_mean_max
    struct Cascade {
        OthersShape others;       ///< all cascades but this one
        double mean_breaking = 0; ///< of conditional_breaking over this cascade's own strains
    };
    std::vector<Cascade> cascades;

    /// Nothing breaks, or foam_mean_min says so.
    bool calm() const { return mean_coverage == 0; }
};

using FoamLawPtr = std::shared_ptr<const FoamLaw>;

/// About 20 ms for three cascades. `model` must have a threshold and be within the ranges of a scene.
/// decay_s = 0 means no history: foam is where waves break now, gain_per_s * 1 s * breaking (hard
/// case E3).
FoamLawPtr make_foam_law(const Realization& sea, const FoamModel& model);

/// The same for a scene, realised as `sea`; about 60 ms where the threshold is to be found.
FoamLawPtr make_foam_law(const Scene& scene, const Realization& sea);

/// What a scene allows has foam: crests break where the surface moves sideways.
inline bool has_foam(const Effects& effects) {
    return effects.choppy && effects.foam;
}
/// The law of a scene that has foam, realised as `sea`; else null.
FoamLawPtr foam_law_of(const Scene& scene, const Realization& sea);

/// One line for people: mean coverage, threshold and where it comes from; says so where the observed
/// share is out of reach of every threshold, or where the mean is above 1 and all the sea is white.
std::string describe(const FoamLaw& law);

/// What a user should know before trusting foam, as scene_warnings() of the rest of a scene: that no
/// threshold gives the observed share. None without a law.
std::vector<std::string> foam_warnings(const FoamLawPtr& law);

/// The scene with the threshold that was found written out, so that its TOML tells it and gives the
/// same foam, bit for bit. A sea without foam keeps coverage = "observed", which finds none again.
Scene with_threshold(Scene scene, const FoamLaw& law);

} // namespace seaway::sea
