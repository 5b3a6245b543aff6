// SPDX-License-Identifier: Apache-2.0
#include "base/clock_filter.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "base/check.h"

namespace seaway {
namespace {

/// A slope needs this much time under it: over less, scatter looks like drift.
constexpr LocalUs slope_span_us = 10'000'000;
/// Quartz is better than this; a steeper line is scatter.
constexpr double slope_max = 500e-6;
/// The kept share of few samples is at least this many.
constexpr std::size_t kept_min = 3;
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
    const LocalUs round_trip_us = received_us - sent_us;
    const LocalUs middle_us = sent_us + round_trip_us / 2;
    window_.push_back({middle_us, round_trip_us, difference(sea_time_us, middle_us)});
    while (window_.size() > samples_max || window_.front().middle_us < middle_us - window_us)
        window_.pop_front();
    bound();
    if (at_heard_.least_us > at_heard_.most_us)
        window_.erase(window_.begin(), std::prev(window_.end()));
    estimate();
    bound();
}

void ClockFilter::bound() {
    heard_us_ = std::ranges::max_element(window_, {}, &Sample::middle_us)->middle_us;
    at_heard_ = {-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
    for (const Sample& sample : window_) {
        const auto offset_us = static_cast<double>(difference(sample.offset_us, base_us_));
        // What was said was so somewhere within the trip.
        const double off_us = rounding_us +
                              0.5 * (1 + rate_off_max) * static_cast<double>(sample.round_trip_us) +
                              rate_off_max * static_cast<double>(heard_us_ - sample.middle_us);
        at_heard_.least_us = std::max(at_heard_.least_us, offset_us - off_us);
        at_heard_.most_us = std::min(at_heard_.most_us, offset_us + off_us);
    }
}

ClockFilter::Range ClockFilter::allowed(LocalUs local_us) const {
    const double off_us = rate_off_max * std::abs(static_cast<double>(local_us - heard_us_));
    return {at_heard_.least_us - off_us, at_heard_.most_us + off_us};
}

void ClockFilter::estimate() {
    std::vector<Sample> kept(window_.begin(), window_.end());
    std::sort(kept.begin(), kept.end(),
              [](const Sample& a, const Sample& b) { return a.round_trip_us < b.round_trip_us; });
    const auto share =
        static_cast<std::size_t>(std::ceil(share_kept * static_cast<double>(kept.size())));
    kept.resize(std::min(kept.size(), std::max(share, kept_min)));
    best_round_trip_us_ = kept.front().round_trip_us;
    // Among few samples one bad trip would weigh a third: with no slope to fit, the best one
    // counts.
    const auto [first, last] =
        std::minmax_element(kept.begin(), kept.end(), [](const Sample& a, const Sample& b) {
            return a.middle_us < b.middle_us;
        });
    const bool fit = last->middle_us - first->middle_us >= slope_span_us;
    if (!fit)
        kept.resize(1);

    const LocalUs old_base_us = base_us_;
    base_us_ = kept.front().offset_us;
    shown_offset_us_ += static_cast<double>(difference(old_base_us, base_us_));
    origin_us_ = kept.front().middle_us;
    const auto count = static_cast<double>(kept.size());
    double mean_x = 0;
    double mean_y = 0;
    for (const Sample& sample : kept) {
        mean_x += static_cast<double>(sample.middle_us - origin_us_) / count;
        mean_y += static_cast<double>(sample.offset_us - base_us_) / count;
    }
    double xx = 0;
    double xy = 0;
    for (const Sample& sample : kept) {
        const double x = static_cast<double>(sample.middle_us - origin_us_) - mean_x;
        xx += x * x;
        xy += x * (static_cast<double>(sample.offset_us - base_us_) - mean_y);
    }
    slope_ = fit && xx > 0 ? std::clamp(xy / xx, -slope_max, slope_max) : 0;
    mean_us_ = mean_y - slope_ * mean_x;
}

double ClockFilter::target_offset_us(LocalUs local_us) const {
    const double line_us = mean_us_ + slope_ * static_cast<double>(local_us - origin_us_);
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
