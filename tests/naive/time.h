// SPDX-License-Identifier: Apache-2.0
// Phases in single precision, and seas between two moments.
#pragma once

#include <cmath>
#include <complex>

namespace seaway::naive {

/// B3: the phase as the product of two floats, rad.
inline float phase_rad(double omega_radps, double time_s) {
    return static_cast<float>(omega_radps) * static_cast<float>(time_s);
}

/// B5: the wave turned on by a constant factor, frame by frame, never set anew.
class Rotation {
  public:
    Rotation(double omega_radps, double step_s) : step_(std::polar(1.0, omega_radps * step_s)) {}
    void advance() { value_ *= step_; }
    std::complex<float> value() const { return value_; }

  private:
    std::complex<float> step_, value_{1};
};

/// B9: seconds since 1970 in a float.
inline float seconds_since_epoch(double time_s) {
    return static_cast<float>(time_s);
}

/// G5: a straight line between two keyframes, 0 <= share <= 1.
inline double linear_in_time(double before, double after, double share) {
    return before + share * (after - before);
}

/// H5: each node changes its sea when the message arrives.
inline long long change_starts_us(long long arrival_us, long long /*stated_us*/) {
    return arrival_us;
}

} // namespace seaway::naive
