// SPDX-License-Identifier: Apache-2.0
// How much further the water at a place may be within what a clock is off by (decision 0062).
//
// Heights are looked at some moments apart. Between three of them, s apart, runs their parabola, and the sea differs from it by at most
// s^3 / (9 sqrt 3) of the largest third rate of the height. Of that rate a sea state tells enough: waves run with
// w^2 <= g k, so its mean square over all waves is at most g^3 times the rms of slopes times that of curvatures (Cauchy and
// Schwarz), of which bound_sigmas count. What stands still sees waves pass that others carry along and squeeze: both are taken at
// sigmas_carried deviations, since waves that are carried faster still do not have bound_sigmas of their own at the same time and place.
// In a sea that repeats each wave turns by up to a turn a period more.
// However far apart they are, no height is above that of the sea.
//
// Stylised waves (sea/waves/sine_waves.h) may run faster than waves of water do: of those it is a guess.
//
// Pure; thread-safe; some nanoseconds.
#pragma once

#include <span>

#include "client/link/connection.h"

namespace seaway::client {

struct SeaMotion {
    double rate_mps = 0;        ///< rms of d height / dt, at most
    double third_rate_mps3 = 0; ///< bound on the third one, at a fixed place
    double highest_m = 0;       ///< bound on heights, of either sign

    /// What is looked at leaves so much of this unknown, by moments that are `apart_s` apart.
    double between_m(double apart_s) const;
    /// So much that all of these have no more.
    SeaMotion with(const SeaMotion& other) const;
};

/// Of the seas that tell one, that of the strongest gravity; of none the earth's. A sea that glides tells none: its waves are on
/// their way between two that do.
sea::WaveLaw fastest_law(std::span<const SeaStatePtr> states);
/// From this time on. `otherwise`: of a state that tells no law of its waves.
SeaMotion motion_of(const SeaState& state, sea::TimeUs time_us, const sea::WaveLaw& otherwise = {});

/// Heights are looked at so many moments before, and as many after, at most.
inline constexpr int looks_each_way_max = 4;
/// One where that leaves little beside what the sea moves within `off_s`, as of some tens of milliseconds; else more.
int looks_each_way(const SeaMotion& motion, double off_s);

/// How far heights are from the middle one of these, which are an odd number of moments `apart_s` apart: at any moment from the first to
/// the last. `folded`: some of them are of several sheets; of more than three moments, others may have come and gone in between, and
/// nothing is known but how high the sea is.
double furthest_m(std::span<const double> heights_m, double apart_s, const SeaMotion& motion,
                  bool folded);

} // namespace seaway::client
