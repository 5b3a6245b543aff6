// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/accuracy/progress.h"

#include <algorithm>
#include <cstdio>

#include <fmt/format.h>

#include "base/elapsed.h"
#include "base/messages.h"

namespace seaway::bench {

namespace {

using Clock = std::chrono::steady_clock;
constexpr std::chrono::seconds between_lines{10};

} // namespace

Progress::Progress(int steps)
    : start_(Clock::now()), last_line_(start_), steps_(std::max(steps, 1)),
      terminal_(stderr_is_terminal()) {}

double Progress::seconds_left() const {
    const int measured = done_ - skipped_;
    return measured > 0 ? seconds_since(start_) / measured * (steps_ - done_) : 0.0;
}

void Progress::begin(const std::string& name) {
    constexpr int width = 30;
    const std::string left =
        done_ > skipped_ ? fmt::format("{:.0f} s left", seconds_left()) : std::string("starting");
    if (terminal_) {
        const auto full = static_cast<std::size_t>(width * done_ / steps_);
        tell(fmt::format("\r\033[K[{}{}] {}/{}, {}: {}", std::string(full, '#'),
                         std::string(width - full, '.'), done_, steps_, left, name));
    } else if (Clock::now() - last_line_ > between_lines) {
        last_line_ = Clock::now();
        tell(fmt::format("{}/{}, {}: {}\n", done_, steps_, left, name));
    }
}

void Progress::done(bool skipped) {
    ++done_;
    skipped_ += skipped;
}

void Progress::finish() {
    if (terminal_)
        tell("\r\033[K");
}

} // namespace seaway::bench
