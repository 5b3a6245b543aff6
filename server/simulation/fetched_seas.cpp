// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/fetched_seas.h"

#include <algorithm>

#include "sea/foam/foam_ticks.h"

namespace seaway::server {

FetchedSeas::FetchedSeas(const SeaCourse& course, std::span<const sea::TimeUs> times_us,
                         sea::FieldSet fields)
    : course_(course) {
    const double memory_s = course.first()->foam_law && fields.contains(sea::Field::foam)
                                ? sea::foam_memory_decays * course.first()->scene.foam.decay_s
                                : 0;
    for (const sea::TimeUs time_us : times_us)
        for (const EpochWindow& window :
             course.windows(time_us - sea::us_from_seconds(memory_s), time_us + 1))
            epochs_.push_back(window.epoch);
    std::ranges::sort(epochs_);
    epochs_.erase(std::unique(epochs_.begin(), epochs_.end()), epochs_.end());
    while (!are_there() && course_.sea_if_held(epochs_[there_])) // mostly all: no slice is needed
        ++there_;
}

bool FetchedSeas::make_some() {
    awaits_ = !course_.sea_unless_making(epochs_[there_]);
    if (!awaits_)
        ++there_;
    return false;
}

} // namespace seaway::server
