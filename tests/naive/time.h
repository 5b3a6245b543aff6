// SPDX-License-Identifier: Apache-2.0
// Phases in single precision, and seas between two moments.
#pragma once

#include <cmath>
#include <complex>
#include <cstdint>

namespace seaway::naive {

/// B3: the phase as the product of two floats, rad.
inline float phase_rad(double omega_radps, double time_s) {
    return static_cast<float>(omega_radps) * static_cast<float>(time_s);
}

/// B2: the time of a frame whose number has no sign, s.
inline double time_of_frame(int number, double frame_s) {
    return static_cast<unsigned>(number) * frame_s;
}

/// B6: the velocity as the change since the last frame, over what a frame takes.
inline double velocity_by_frames(double before, double now, double frame_s) {
    return (now - before) / frame_s;
}

/// B7: whole turns in a loop, rounded down, rad/s.
inline double looped_omega(double omega_radps, double loop_s) {
    const double step = 6.283185307179586 / loop_s;
    return step * std::floor(omega_radps / step);
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

/// H3: of two frames the newer one, by 16-bit numbers as they are.
inline bool newer(std::uint16_t number, std::uint16_t than) {
    return number > than;
}

/// I7: the phase with the frequency of now and the time since the start, rad.
inline double phase_after_change(double omega_now_radps, double time_s) {
    return omega_now_radps * time_s;
}

} // namespace seaway::naive
