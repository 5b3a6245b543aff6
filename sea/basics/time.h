// SPDX-License-Identifier: Apache-2.0
// Sea time and the fixed-point phase of a mode.
//
// Sea time is a whole number of microseconds since the sea's epoch. A mode's frequency is stored as
// turns per microsecond in 0.64 fixed point; its phase at time t is rate * t modulo 2^64: integer,
// exact, the same on CPU and GPU, at t = 0 and after 30 years, forward and backward. A frequency is
// rounded once, when it is stored: at most 2^-65 turns/us, 1.8e-7 rad after 1e6 s and 1.7e-4 rad
// after 1e9 s. No phase is ever accumulated.
//
// Pure functions; thread-safe.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

namespace seaway::sea {

/// Sea time, microseconds since the sea's epoch; negative is before it. Phases are exact for all of
/// int64; a surface may be asked for within -time_us_max .. time_us_max.
using TimeUs = std::int64_t;

/// 1e12 s, 31 700 years. The rest of int64, nine times as much, is room for the keyframes around a
/// time, for the memory of foam before it and for differences of two times.
inline constexpr TimeUs time_us_max = 1'000'000'000'000'000'000;

inline constexpr bool in_time_range(TimeUs t_us) {
    return t_us >= -time_us_max && t_us <= time_us_max;
}

/// A mode's frequency in turns per microsecond, 0.64 fixed point.
using Rate = std::uint64_t;

inline constexpr double microseconds_per_second = 1e6;

inline constexpr double seconds_from_us(TimeUs t_us) {
    return static_cast<double>(t_us) / microseconds_per_second;
}
inline constexpr double time_max_s = seconds_from_us(time_us_max);

/// Nearest microsecond. |t_s| up to 9.2e12 s.
inline TimeUs us_from_seconds(double t_s) {
    return std::llround(t_s * microseconds_per_second);
}

/// omega_radps >= 0 and below 1e6 (half a turn a microsecond is 3.1e6).
inline Rate rate_from_omega(double omega_radps) {
    constexpr double two_to_64_us_per_turn = 0x1p64 / (2.0 * std::numbers::pi * 1e6);
    return static_cast<Rate>(omega_radps * two_to_64_us_per_turn + 0.5);
}

/// The angular frequency that a stored rate stands for, rad/s.
inline double omega_from_rate(Rate rate) {
    return static_cast<double>(rate) * (2.0 * std::numbers::pi * 1e6 / 0x1p64);
}

/// Phase in turns, 0.64 fixed point: exact.
inline std::uint64_t phase_turns(Rate rate, TimeUs t_us) {
    return rate * static_cast<std::uint64_t>(t_us);
}

/// Turns, 0.64 fixed point, wrapped to [-pi, pi), rad.
inline double rad_from_turns(std::uint64_t turns) {
    return static_cast<double>(static_cast<std::int64_t>(turns)) * (std::numbers::pi / 0x1p63);
}

/// Phase wrapped to [-pi, pi), rad.
inline double phase_rad(Rate rate, TimeUs t_us) {
    return rad_from_turns(phase_turns(rate, t_us));
}

} // namespace seaway::sea
