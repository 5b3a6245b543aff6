// SPDX-License-Identifier: Apache-2.0
// How fast the waves of ramps and lists may turn: what the scene reader asks before anything is made
// of them. Pure; thread-safe.
#pragma once

#include <cstdint>

#include "sea/basics/dispersion.h"
#include "sea/waves/sine_waves.h"

namespace seaway::sea {

/// What a Rate is made of turns at most this fast (rate_from_omega); half a turn a microsecond, where
/// turns forward and back are the same, is 3.1e6 rad/s.
inline constexpr double rate_omega_max_radps = 1e6;

/// The highest frequency of the waves or octaves, before a loop rounds it. Not for more than
/// sine_steps_max.
double fastest_sine_radps(const SineRamps& ramps, std::uint64_t seed, std::uint32_t system,
                          const Dispersion& dispersion);

} // namespace seaway::sea
