// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/fetched_parts.h"

#include <map>
#include <utility>

namespace seaway::server {

FetchedParts::FetchedParts(const SeaCourse& course, const std::vector<sea::TimeUs>& times_us,
                           const Demand& demand, std::shared_ptr<Room> room)
    : course_(course), demand_(demand), room_(std::move(room)) {
    std::map<std::uint32_t, std::vector<sea::TimeUs>> by_epoch;
    for (const sea::TimeUs time_us : times_us)
        by_epoch[course_.window_at(time_us).epoch].push_back(time_us);
    for (auto& [epoch, times] : by_epoch)
        seas_of_times_.push_back(std::move(times));
    if (seas_of_times_.empty()) // of no times nothing, when it is its turn
        seas_of_times_.emplace_back();
    begin();
}

bool FetchedParts::may_work() {
    const bool begins = !job_ || job_->between_parts();
    if (!begins || seas_of_times_[next_].empty() || course_.sea_if_held(epoch()))
        return true;
    seas_.emplace(course_, seas_of_times_[next_], demand_.fields);
    return false;
}

void FetchedParts::begin() {
    job_.reset();
    if (!complete())
        seas_.emplace(course_, seas_of_times_[next_], demand_.fields);
}

void FetchedParts::make_some_sea() {
    if (!lacks_sea())
        return seas_->make_some();
    if (seas_->make(*job_->lacks_sea()))
        job_->go_on();
}

KeyframeJob& FetchedParts::job() {
    if (!job_) {
        job_.emplace(keyframes_around(course_, seas_of_times_[next_], demand_), Walk::questions,
                     room_);
        job_->leave_seas_to_others();
    }
    return *job_;
}

std::vector<sea::KeyframePtr> FetchedParts::take() {
    std::vector<sea::KeyframePtr> part = job_->take();
    seas_->let_go(); // it may wait for room for the next one
    if (job_->complete()) {
        ++next_;
        begin();
    }
    return part;
}

} // namespace seaway::server
