// SPDX-License-Identifier: Apache-2.0
// What the checks of values in messages are made of. Errors name the field, its value and its range.
#pragma once

#include <limits>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "protocol/limits.h"
#include "protocol/messages.h"

namespace seaway::protocol {

template <class T>
Result<void> in_range(std::string_view field, T value, T lo, T hi) {
    if (value >= lo && value <= hi) // false for NaN
        return {};
    return Error{wire::ErrorCode::bad_value,
                 fmt::format("{} is {}, allowed are {} to {}", field, value, lo, hi)};
}

template <class Vector>
std::size_t count(const Vector* list) {
    return list == nullptr ? 0 : list->size();
}

inline Result<void> text_fits(std::string_view field, const flatbuffers::String* text,
                              std::size_t bytes_max) {
    return in_range<std::size_t>(fmt::format("length of {}", field), count(text), 0, bytes_max);
}

/// Between keyframes.
inline constexpr std::int64_t interval_us_max = std::int64_t{3600} * 1'000'000;

/// The first failure of several checks.
template <class... Checks>
Result<void> all_of(Checks&&... checks) {
    Result<void> first;
    (void)((first = std::forward<Checks>(checks), first.has_value()) && ...);
    return first;
}

/// Of a Spectrum or a SeaState.
template <class Law>
Result<void> check_law(std::string_view of, const Law& law) {
    const auto name = [of](std::string_view field) { return std::string(of) + std::string(field); };
    return all_of(
        in_range(name("gravity_mps2"), law.gravity_mps2(), 1e-3, 1e3),
        in_range(name("surface_tension_m3ps2"), law.surface_tension_m3ps2(), 0.0, 1.0),
        in_range(name("depth_m"), law.depth_m(), 1e-3, std::numeric_limits<double>::infinity()),
        in_range<std::int64_t>(name("loop_period_us"), law.loop_period_us(), 0,
                               limits::time_us_max));
}

} // namespace seaway::protocol
