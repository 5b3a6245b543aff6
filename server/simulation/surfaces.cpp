// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/surfaces.h"

#include <algorithm>
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
    if (job.parts_.empty() && (share(job) || !has_sea(job, make) || !look_up(job)))
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
    bool splined = true;
    for (const KeyframeRequest& request : all) {
        const Holding holding = source_.holding(request);
        if (holding == Holding::nothing) {
            job.lacks_keyframes_ = job.awaits_room_ = true;
            return false;
        }
        splined = splined && holding == Holding::spline;
    }
    if (!take_room(job, splined && job.use_ == SurfaceUse::few))
        return false;
    std::vector<SurfaceJob::Part> parts = found(all);
    job.lacks_keyframes_ = std::ranges::any_of(parts, &SurfaceJob::Part::lacks);
    if (job.lacks_keyframes_) // let go meanwhile
        return false;
    job.parts_ = std::move(parts);
    return true;
}

std::vector<SurfaceJob::Part> Surfaces::found(const std::vector<KeyframeRequest>& wanted) {
    std::vector<SurfaceJob::Part> parts;
    for (const KeyframeRequest& request : wanted) {
        KeyframeStore::Found found = source_.store().find_for_points(request);
        parts.push_back({request, std::move(found.maps), std::move(found.spline)});
    }
    return parts;
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
    if (!job.keyframes_) {
        job.found_ = found(wanted(job));
        std::vector<KeyframeRequest> lacking;
        for (const SurfaceJob::Part& part : job.found_)
            if (part.lacks())
                lacking.push_back(part.of);
        job.keyframes_.emplace(std::move(lacking), Walk::questions);
    }
    SEAWAY_TRY_LET(const bool made, source_.work_on(*job.keyframes_));
    if (made)
        for (sea::KeyframePtr& keyframe : job.keyframes_->take())
            std::ranges::find_if(job.found_, &SurfaceJob::Part::lacks)->maps = std::move(keyframe);
    job.lacks_keyframes_ = !job.keyframes_->complete();
    if (!job.lacks_keyframes_)
        job.parts_ = std::move(job.found_);
    return {};
}

bool Surfaces::make_splines(SurfaceJob& job, Make make) {
    KeyframeStore& store = source_.store();
    bool made = make == Make::nothing;
    job.awaits_spline_ = false;
    for (SurfaceJob::Part& part : job.parts_) {
        if (part.spline || (part.spline = store.find_spline(part.of))) { // another made it
            part.maps = nullptr;
            continue;
        }
        if (std::exchange(made, true))
            return false;
        const std::shared_ptr<const void> turn = spline_turn();
        job.awaits_spline_ = turn == nullptr;
        if (job.awaits_spline_)
            return false;
        part.spline = store.find_spline(part.of); // while the turn was another's
        if (!part.spline)
            part.spline =
                store.spline(part.maps, job.use_ == SurfaceUse::batch ? stand_back : nullptr);
        part.maps = nullptr;
    }
    return true;
}

std::shared_ptr<const void> Surfaces::spline_turn() {
    if (splining_.exchange(true))
        return nullptr;
    return {this, [this](const void*) { splining_ = false; }};
}

bool Surfaces::finish(SurfaceJob& job) {
    const std::vector<SurfaceJob::Part> parts = std::exchange(job.parts_, {});
    const EpochWindow window = course_->window(parts.front().of.epoch);
    if (window.end_us <= job.time_us_) { // another took over while this one was made
        job.keyframes_.reset();
        return false;
    }
    const RunningSeaPtr sea = course_->sea(window.epoch);
    const sea::Choppiness choppiness = sea->choppiness_at(job.time_us_);
    TimeUs start_us = std::numeric_limits<TimeUs>::min();
    job.end_us_ = window.end_us;
    std::vector<sea::SplinePair> pairs;
    for (std::size_t i = 0; i < parts.size(); i += 2) {
        pairs.push_back({parts[i].spline, parts[i + 1].spline});
        start_us = std::max(start_us, parts[i].of.time_us);
        job.end_us_ = std::min(job.end_us_, parts[i + 1].of.time_us);
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
