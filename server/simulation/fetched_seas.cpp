// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/fetched_seas.h"

#include <algorithm>
#include <utility>

#include "sea/foam/foam_ticks.h"

namespace seaway::server {

namespace {

/// Of the cascade that looks back furthest.
sea::TimeUs foam_memory_us(const RunningSea& sea) {
    sea::TimeUs longest_us = 0;
    for (const sea::CascadeBudget& cascade : sea.budget.cascades)
        longest_us =
            std::max(longest_us, sea::foam_ticks(sea.foam_law->model.decay_s, cascade.interval_us,
                                                 sea.foam_law->loop_period_us)
                                     .memory_us);
    return longest_us;
}

} // namespace

std::vector<std::uint32_t> fetched_epochs(const SeaCourse& course,
                                          std::span<const sea::TimeUs> times_us,
                                          sea::FieldSet fields) {
    const bool foam = course.first()->foam_law && fields.contains(sea::Field::foam);
    const sea::TimeUs memory_us = foam ? foam_memory_us(*course.first()) : 0;
    std::vector<std::uint32_t> epochs;
    for (const sea::TimeUs time_us : times_us)
        for (const EpochWindow& window : course.windows(time_us - memory_us, time_us + 1))
            epochs.push_back(window.epoch);
    std::ranges::sort(epochs);
    epochs.erase(std::unique(epochs.begin(), epochs.end()), epochs.end());
    return epochs;
}

FetchedSeas::FetchedSeas(const SeaCourse& course, std::span<const sea::TimeUs> times_us,
                         sea::FieldSet fields)
    : course_(course), epochs_(fetched_epochs(course, times_us, fields)) {
    if (epochs_.size() >= seas_kept) // what the first one glides from is made, too
        epochs_ = fetched_epochs(course, times_us, {});
    while (!are_there() && course_.sea_if_held(epochs_[there_])) // mostly all: no slice is needed
        ++there_;
}

void FetchedSeas::make_some() {
    awaits_ = !course_.sea_unless_making(epochs_[there_]);
    if (!awaits_)
        ++there_;
}

bool FetchedSeas::make(std::uint32_t epoch) {
    RunningSeaPtr sea = course_.sea_unless_making(epoch);
    awaits_ = !sea;
    if (sea)
        used_ = {std::move(sea), std::move(used_[0])};
    return !awaits_;
}

} // namespace seaway::server
