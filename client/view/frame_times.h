// SPDX-License-Identifier: Apache-2.0
// FrameRate: how many frames a second of sea there are, and when each of them is: as seaway-view and seaway-bake number
// them. A value; pure.
#pragma once

#include <charconv>
#include <cmath>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "base/result.h"
#include "sea/basics/time.h"

namespace seaway::client {

/// Frames are numbered from 0 to one below this.
inline constexpr int frames_max = 1'000'000;
inline constexpr double frame_rate_max_hz = 1000;
inline constexpr double frame_rate_part_max = 1e6; ///< of N and D in N/D

struct FrameRate {
    double frames = 30;
    double seconds = 1; ///< in which so many come: 24000 in 1001

    double hz() const { return frames / seconds; }
    double frame_s() const { return seconds / frames; }
    /// From frame 0 to this one.
    double offset_s(int frame) const { return frame * seconds / frames; }
    /// The same, rounded once: it does not drift, and does not depend on which frame was the first.
    sea::TimeUs offset_us(int frame) const { return std::llround(frame * 1e6 * seconds / frames); }
    /// As an option says it.
    std::string text() const {
        return seconds == 1 ? fmt::format("{}", frames) : fmt::format("{}/{}", frames, seconds);
    }
    bool operator==(const FrameRate&) const = default;
};

/// "30", "23.976" or "24000/1001". The error names the option and what may stand there.
inline Result<FrameRate> parse_frame_rate(const std::string& option, std::string_view text) {
    FrameRate rate;
    const auto number = [](std::string_view word, double& value) {
        const auto [end, failure] = std::from_chars(word.data(), word.data() + word.size(), value);
        return failure == std::errc{} && end == word.data() + word.size() && value > 0;
    };
    const auto whole = [](double value) {
        return value == std::floor(value) && value <= frame_rate_part_max;
    };
    const std::size_t slash = text.find('/');
    const bool read = slash == text.npos ? number(text, rate.frames)
                                         : number(text.substr(0, slash), rate.frames) &&
                                               number(text.substr(slash + 1), rate.seconds) &&
                                               whole(rate.frames) && whole(rate.seconds);
    if (read && rate.hz() <= frame_rate_max_hz)
        return rate;
    return Error{fmt::format("{} {}: above 0, up to {:g}, or N/D (24000/1001) of whole numbers, "
                             "each up to {:g}",
                             option, text, frame_rate_max_hz, frame_rate_part_max)};
}

} // namespace seaway::client
