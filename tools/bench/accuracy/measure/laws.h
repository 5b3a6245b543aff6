// SPDX-License-Identifier: Apache-2.0
// What each knob is expected to cost of the height, before anything is measured: rms over places and
// times, from the waves alone. Sources add in the square. Where sea/surface states a law (cubic spline,
// Hermite weights, codec bounds) it is that one.
//
// Pure functions; thread-safe. Some milliseconds.
#pragma once

#include "tools/bench/accuracy/seas/configured_sea.h"

namespace seaway::bench {

/// Root mean squares, m.
struct Prediction {
    double space_m = 0;   ///< K2: between grid points
    double time_m = 0;    ///< K8: between keyframes
    double codec_m = 0;   ///< K9: quantised to twice the bound, evenly spread
    double format_m = 0;  ///< K5: values of 16 bits
    double inverse_m = 0; ///< K10: fixed-point steps
    double modes_m = 0;   ///< K1, K11: waves that are left out
    double phase_m = 0;   ///< K7: phases that were rounded
    double latency_m = 0; ///< K14
    double rms_m() const;
    /// Of slopes: space, time and codec together; cubic splines alone. Displacements that are off move and
    /// bend it a little more in a steep sea.
    double slope_rms = 0;
};

/// `time_us` matters to K7 alone.
Prediction predict(const Waves& waves, const Configuration& configuration, sea::TimeUs time_us);

/// Share of a unit wave's variance that a rule misses between two keyframes at phase step u = omega * interval.
double missed_in_time(TimeRule rule, double u);

/// The waves that a spectrum asks for and no tile holds, as rms of heights in m: of the deep tail
/// alpha g^2 / omega^5 above k_c it is sqrt(alpha) / (2 k_c).
struct Missing {
    double longer_m = 0;  ///< than the longest tile holds
    double shorter_m = 0; ///< than the finest band
    double between_m = 0; ///< bands that leave gaps
    double slope_rms = 0; ///< of the shorter ones, down to ripples of 1.7 cm
    double rms_m() const;
};
Missing missing_waves(const Waves& waves);

} // namespace seaway::bench
