// SPDX-License-Identifier: Apache-2.0
#include "server/journal/sea_clock.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace seaway::server {

std::int64_t SeaClock::utc_now_us() {
    return std::chrono::duration_cast<std::chrono::microseconds>(
               std::chrono::system_clock::now().time_since_epoch())
        .count();
}

SeaClock::SeaClock(std::int64_t epoch_utc_us, Microseconds utc, Microseconds steady,
                   sea::Paces paces)
    : epoch_utc_us_(epoch_utc_us), utc_(std::move(utc)), steady_(std::move(steady)),
      steady_us_(steady_()), elapsed_us_(utc_() - epoch_utc_us_), paces_(std::move(paces)),
      shown_us_(paces_.sea_time(elapsed_us_)) {}

SeaMoment SeaClock::moment() {
    const std::scoped_lock lock(mutex_);
    return locked_moment();
}

SeaMoment SeaClock::locked_moment() {
    // In this order a stop between the two leaves the sea behind, which heals, and not ahead.
    const std::int64_t utc_us = utc_();
    const std::int64_t steady_us = steady_();
    const sea::TimeUs passed_us = std::max<sea::TimeUs>(steady_us - steady_us_, 0);
    steady_us_ = std::max(steady_us_, steady_us);
    elapsed_us_ += passed_us;
    // Whole microseconds are pulled: what is left of them counts the next time, however often the clock is read.
    unspent_us_ += passed_us;
    const sea::TimeUs most_us = unspent_us_ / pull_parts;
    unspent_us_ %= pull_parts;
    const sea::TimeUs behind_us = utc_us - epoch_utc_us_ - elapsed_us_;
    const sea::TimeUs caught_up_us =
        behind_us > leap_us ? behind_us : std::clamp(behind_us, -most_us, most_us);
    elapsed_us_ += caught_up_us;
    leapt_us_ += caught_up_us > leap_us ? caught_up_us : 0;
    paces_.forget_before(elapsed_us_);
    const sea::TimeUs by_paces_us = paces_.sea_time(elapsed_us_);
    shown_us_ = std::max(shown_us_, by_paces_us);
    return {shown_us_,
            elapsed_us_,
            paces_.at(elapsed_us_).permille,
            behind_us - caught_up_us,
            epoch_utc_us_,
            shown_us_ - by_paces_us,
            leapt_us_};
}

void SeaClock::follow(const sea::Pace& pace) {
    const std::scoped_lock lock(mutex_);
    const sea::TimeUs elapsed_us = locked_moment().elapsed_us;
    paces_.add(pace);
    if (paces_.are_far_behind(shown_us_, elapsed_us)) // as its clients do
        shown_us_ = paces_.sea_time(elapsed_us);
}

sea::Pace SeaClock::next_pace(sea::TimeUs from_us, int permille) {
    const std::scoped_lock lock(mutex_);
    sea::Pace pace = paces_.next(from_us, permille);
    pace.sea_us = std::max(pace.sea_us, shown_us_);
    return pace;
}

std::vector<sea::Pace> SeaClock::paces() {
    const std::scoped_lock lock(mutex_);
    (void)locked_moment();
    return paces_.all();
}

std::optional<sea::TimeUs> SeaClock::wait_us(sea::TimeUs sea_us) {
    const std::scoped_lock lock(mutex_);
    const sea::TimeUs now_us = locked_moment().elapsed_us;
    const std::optional<sea::TimeUs> then_us = paces_.moment_of(sea_us, now_us);
    return then_us ? std::optional(*then_us - now_us) : std::nullopt;
}

double SeaClock::hurry() {
    const std::scoped_lock lock(mutex_);
    return paces_.hurry(locked_moment().elapsed_us);
}

sea::TimeUs SeaClock::hurried(sea::TimeUs us) {
    return std::llround(hurry() * static_cast<double>(us));
}

std::string utc_text(std::int64_t utc_us) {
    using namespace std::chrono;
    constexpr sys_time<microseconds> first = sys_days(year(0) / 1 / 1);
    constexpr sys_time<microseconds> end = sys_days(year(10000) / 1 / 1);
    if (utc_us < first.time_since_epoch().count() || utc_us >= end.time_since_epoch().count())
        return fmt::format("{} us since 1970", utc_us);
    const sys_time<microseconds> instant{microseconds(utc_us)};
    const auto day = floor<days>(instant);
    const year_month_day date(day);
    const hh_mm_ss time(instant - day);
    return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}.{:06}Z", static_cast<int>(date.year()),
                       static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
                       time.hours().count(), time.minutes().count(), time.seconds().count(),
                       time.subseconds().count());
}

} // namespace seaway::server
