// SPDX-License-Identifier: Apache-2.0
#include "base/clock_filter.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "base/check.h"

namespace seaway {
namespace {

/// Quartz is better than this; a steeper line is scatter.
constexpr double slope_max = 500e-6;
/// What a clock wanders from its line, as a part (RFC 5905, PHI).
constexpr double wander = 15e-6;
/// A slope is believed where it makes more room than its own part of this time: over less, scatter looks like drift.
constexpr LocalUs settling_us = 2'000'000;
/// Times are whole microseconds, and so is the middle of a trip.
constexpr double rounding_us = 1.5;

/// The difference of any two times wraps instead of overflowing.
LocalUs difference(std::int64_t a, std::int64_t b) {
    return static_cast<LocalUs>(static_cast<std::uint64_t>(a) - static_cast<std::uint64_t>(b));
}

} // namespace

void ClockFilter::add(LocalUs sent_us, LocalUs received_us, std::int64_t sea_time_us) {
    if (received_us < sent_us)
        return;
    const Sample sample{sent_us, received_us - sent_us, difference(sea_time_us, sent_us)};
    window_.push_back(sample);
    const LocalUs middle_us = sample.middle_us();
    while (window_.size() > samples_max || window_.front().middle_us() < middle_us - window_us)
        window_.pop_front();
    shown_offset_us_ += static_cast<double>(difference(base_us_, sample.ahead_us));
    base_us_ = sample.ahead_us;
    heard();
    if (at_heard_.least_us > at_heard_.most_us) {
        window_.erase(window_.begin(), std::prev(window_.end()));
        heard();
    }
    slope_ = slope_of_most_room();
    middle_us_ = left(slope_, wander).middle_us();
}

void ClockFilter::heard() {
    heard_us_ = std::ranges::max(window_, {}, &Sample::middle_us).middle_us();
    at_heard_ = left(0, rate_off_max);
    at_heard_.least_us -= rounding_us;
    at_heard_.most_us += rounding_us;
    best_round_trip_us_ = std::ranges::min(window_, {}, &Sample::round_trip_us).round_trip_us;
}

ClockFilter::Range ClockFilter::left(double slope, double off) const {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    Range range{-infinity, infinity, heard_us_, heard_us_};
    for (const Sample& sample : window_) {
        const auto ahead_us = static_cast<double>(difference(sample.ahead_us, base_us_));
        const LocalUs received_us = sample.sent_us + sample.round_trip_us;
        const auto since_sent_us = static_cast<double>(heard_us_ - sample.sent_us);
        const auto since_received_us = static_cast<double>(heard_us_ - received_us);
        const double most_us = ahead_us + slope * since_sent_us + off * std::abs(since_sent_us);
        const double least_us = ahead_us - static_cast<double>(sample.round_trip_us) +
                                slope * since_received_us - off * std::abs(since_received_us);
        if (most_us < range.most_us) {
            range.most_us = most_us;
            range.most_at_us = sample.sent_us;
        }
        if (least_us > range.least_us) {
            range.least_us = least_us;
            range.least_at_us = received_us;
        }
    }
    return range;
}

/// Room is concave in the slope, and as the slope grows it grows by the time from the look that leaves no more to the one that
/// leaves no less: halved is where that turns.
double ClockFilter::slope_of_most_room() const {
    const auto gained_us = [this](double slope) {
        const Range range = left(slope, wander);
        return range.least_at_us - range.most_at_us;
    };
    const LocalUs level_us = gained_us(0);
    if (std::abs(level_us) <= settling_us)
        return 0;
    const double sign = level_us > 0 ? 1 : -1;
    const auto gains_still = [&](double steepness) {
        return sign * static_cast<double>(gained_us(sign * steepness)) >
               static_cast<double>(settling_us);
    };
    if (gains_still(slope_max))
        return sign * slope_max;
    double less = 0, more = slope_max;
    for (int halvings = 0; halvings < 24; ++halvings) {
        const double middle = 0.5 * (less + more);
        (gains_still(middle) ? less : more) = middle;
    }
    return sign * less;
}

ClockFilter::Range ClockFilter::allowed(LocalUs local_us) const {
    const double off_us = rate_off_max * std::abs(static_cast<double>(local_us - heard_us_));
    return {at_heard_.least_us - off_us, at_heard_.most_us + off_us, heard_us_, heard_us_};
}

double ClockFilter::target_offset_us(LocalUs local_us) const {
    const double line_us = middle_us_ + slope_ * static_cast<double>(local_us - heard_us_);
    const Range range = allowed(local_us);
    return std::clamp(line_us, range.least_us, range.most_us);
}

std::int64_t ClockFilter::now(LocalUs local_us) {
    SEAWAY_CHECK(synchronised(), "the clock is read before its first sample");
    const double target_us = target_offset_us(local_us);
    if (!shown_any_) {
        shown_any_ = true;
        shown_offset_us_ = target_us;
        shown_us_ = base_us_ + local_us + std::int64_t{std::llround(target_us)};
        shown_at_us_ = local_us;
        return shown_us_;
    }
    const auto elapsed_us = static_cast<double>(std::max<LocalUs>(local_us - shown_at_us_, 0));
    const double behind_us = target_us - shown_offset_us_;
    anew_ = anew_ && behind_us > step_us;
    if (behind_us > step_us && !anew_)
        shown_offset_us_ = target_us;
    else {
        const double rate = behind_us < -step_us ? 0.5 : anew_ ? 1.0 : slew_rate;
        shown_offset_us_ += std::clamp(behind_us, -rate * elapsed_us, rate * elapsed_us);
    }
    shown_at_us_ = std::max(shown_at_us_, local_us);
    shown_us_ =
        std::max(shown_us_, base_us_ + shown_at_us_ + std::int64_t{std::llround(shown_offset_us_)});
    return shown_us_;
}

ClockStatus ClockFilter::status(LocalUs local_us) const {
    ClockStatus status;
    status.samples = static_cast<int>(window_.size());
    if (window_.empty())
        return status;
    const double target_us = target_offset_us(local_us);
    status.offset_us = static_cast<double>(base_us_) + target_us;
    status.drift_ppm = slope_ * 1e6;
    status.slew_us = shown_any_ ? target_us - shown_offset_us_ : 0;
    status.round_trip_us = best_round_trip_us_;
    const Range range = allowed(local_us);
    status.error_us = std::max(range.most_us - target_us, target_us - range.least_us);
    return status;
}

} // namespace seaway
