// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/surfaces.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <utility>

#include "base/stand_back.h"
#include "server/simulation/memory_needs.h"
#include "server/simulation/schedule.h"

namespace seaway::server {

using sea::TimeUs;

namespace {

/// What is lost of cascades that are not there is not lost.
sea::MapError of_some(sea::MapError error, std::uint32_t cascades) {
    decltype(error.cascades) some;
    for (std::size_t c = 0; c < error.cascades.size(); ++c)
        if (cascades >> c & 1u)
            some.push_back(error.cascades[c]);
    error.cascades = some;
    return error;
}

} // namespace

Surfaces::Surfaces(SeaCoursePtr course, KeyframeSource& source, const Memory& memory)
    : course_(std::move(course)), source_(source), bytes_(surface_bytes(*course_->first())),
      batches_(memory.room(MemoryUse::surfaces)), prompt_(memory.room(MemoryUse::prompt_surfaces)) {
}

std::vector<KeyframeRequest> Surfaces::wanted(const SurfaceJob& job) const {
    return keyframes_around(*course_, {&job.time_us_, 1},
                            {job.cascades_, course_->first()->sampler_fields()});
}

bool Surfaces::work_on(SurfaceJob& job, Make make) {
    if (job.held_.empty() && (share(job) || !has_sea(job, make) || !look_up(job)))
        return job.surface_ != nullptr;
    return make_splines(job, make) && finish(job);
}

/// Left to the course, which keeps a few: who waits must not fill the memory with them.
bool Surfaces::has_sea(SurfaceJob& job, Make make) {
    const std::uint32_t epoch = course_->window_at(job.time_us_).epoch;
    if (make == Make::nothing)
        return course_->sea_if_held(epoch) != nullptr;
    job.awaits_sea_ = !course_->sea_unless_making(epoch);
    return !job.awaits_sea_;
}

bool Surfaces::share(SurfaceJob& job) {
    const std::uint32_t epoch = course_->window_at(job.time_us_).epoch;
    const std::scoped_lock lock(mutex_);
    for (const Used& used : used_) {
        if (used.epoch != epoch || used.cascades != job.cascades_ || job.time_us_ < used.start_us ||
            job.time_us_ >= used.end_us)
            continue;
        if (SurfacePtr surface = used.surface.lock()) {
            job.surface_ = std::move(surface);
            job.end_us_ = used.end_us;
            return true;
        }
    }
    return false;
}

bool Surfaces::look_up(SurfaceJob& job) {
    const std::vector<KeyframeRequest> all = wanted(job);
    KeyframeStore& store = source_.store();
    bool splined = true;
    for (const KeyframeRequest& request : all) {
        const sea::KeyframePtr held = store.held(request);
        if (!held || !held->fields.contains(request.fields)) {
            job.lacks_keyframes_ = job.awaits_room_ = true;
            return false;
        }
        splined = splined && store.splined(request);
    }
    if (!take_room(job, splined && job.use_ == SurfaceUse::few))
        return false;
    for (const KeyframeRequest& request : all) {
        job.held_.push_back(store.find(request));
        if (job.held_.back())
            continue;
        job.held_.clear(); // let go meanwhile
        job.lacks_keyframes_ = true;
        return false;
    }
    return true;
}

bool Surfaces::take_room(SurfaceJob& job, bool anyway) {
    if (!job.place_)
        job.place_ = anyway || job.use_ == SurfaceUse::ahead ? room_of(job).take_anyway(bytes_)
                                                             : room_of(job).take(bytes_);
    job.awaits_room_ = !job.place_;
    return !job.awaits_room_;
}

Result<void> Surfaces::make_keyframes(SurfaceJob& job) {
    if (!take_room(job, false))
        return {};
    if (!job.keyframes_)
        job.keyframes_.emplace(wanted(job), Walk::questions);
    SEAWAY_TRY_LET(const bool made, source_.work_on(*job.keyframes_));
    if (made)
        std::ranges::move(job.keyframes_->take(), std::back_inserter(job.held_));
    job.lacks_keyframes_ = !job.keyframes_->complete();
    return {};
}

bool Surfaces::make_splines(SurfaceJob& job, Make make) {
    KeyframeStore& store = source_.store();
    bool made = make == Make::nothing;
    while (job.splines_.size() < job.held_.size()) {
        const sea::KeyframePtr& next = job.held_[job.splines_.size()];
        std::shared_ptr<const void> turn;
        if (!store.splined(request_of(*next))) {
            if (std::exchange(made, true))
                return false;
            turn = spline_turn();
            job.awaits_spline_ = turn == nullptr;
            if (job.awaits_spline_)
                return false;
        }
        job.splines_.push_back(
            store.spline(next, job.use_ == SurfaceUse::batch ? stand_back : nullptr));
    }
    return true;
}

std::shared_ptr<const void> Surfaces::spline_turn() {
    if (splining_.exchange(true))
        return nullptr;
    return {this, [this](const void*) { splining_ = false; }};
}

bool Surfaces::finish(SurfaceJob& job) {
    const EpochWindow window = course_->window(job.held_.front()->epoch);
    if (window.end_us <= job.time_us_) { // another took over while this one was made
        job.keyframes_.reset();
        job.held_.clear();
        job.splines_.clear();
        return false;
    }
    const RunningSeaPtr sea = course_->sea(window.epoch);
    const sea::Choppiness choppiness = sea->choppiness_at(job.time_us_);
    TimeUs start_us = std::numeric_limits<TimeUs>::min();
    job.end_us_ = window.end_us;
    std::vector<sea::SplinePair> pairs;
    for (std::size_t i = 0; i < job.held_.size(); i += 2) {
        pairs.push_back({job.splines_[i], job.splines_[i + 1]});
        start_us = std::max(start_us, job.held_[i]->time_us);
        job.end_us_ = std::min(job.end_us_, job.held_[i + 1]->time_us);
    }
    if (sea->glide && !(choppiness == sea->choppiness_at(job.time_us_ + 1))) {
        start_us = job.time_us_; // the surface of this moment alone
        job.end_us_ = job.time_us_ + 1;
    }
    job.surface_ = with_place(
        std::exchange(job.place_, nullptr),
        std::make_shared<const sea::Surface>(
            std::move(pairs), choppiness, fold_search(sea->budget),
            of_some(map_error(sea->budget, rounding_error_m(sea->budget, source_.readback())),
                    job.cascades_),
            sea::inverse_tolerance_m(sea->budget.height_error_m)));
    const std::scoped_lock lock(mutex_);
    std::erase_if(used_, [](const Used& used) { return used.surface.expired(); });
    used_.push_back({sea->epoch, job.cascades_, start_us, job.end_us_, job.surface_});
    return true;
}

} // namespace seaway::server
