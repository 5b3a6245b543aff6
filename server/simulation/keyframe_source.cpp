// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/keyframe_source.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include <fmt/format.h>

#include "base/undo.h"
#include "server/host/refusal.h"

namespace seaway::server {

using sea::TimeUs;

namespace {

std::vector<int> cascade_sizes(const RunningSea& sea) {
    std::vector<int> sizes;
    for (const sea::CascadeModes& modes : sea.realization->cascades)
        sizes.push_back(modes.spec.size);
    return sizes;
}

} // namespace

KeyframeSource::KeyframeSource(SeaCoursePtr course, std::unique_ptr<RebuiltSynthesizer> device,
                               const Memory& memory, Readback readback)
    : course_(std::move(course)), readback_(readback),
      device_(course_, std::move(device)), streamed_foam_{{course_->first()->epoch,
                                                           FoamMaps(course_)}},
      started_foam_{FoamMaps(course_)}, asked_foam_{FoamMaps(course_)},
      store_(memory.room(MemoryUse::keyframes)), description_(device_.device().description()),
      costs_(cascade_sizes(*course_->first())) {}

Holding KeyframeSource::holding(const KeyframeRequest& request) const {
    if (store_.splined(request))
        return Holding::spline;
    return holding_of_maps(request);
}

Holding KeyframeSource::holding_of_maps(const KeyframeRequest& request) const {
    const sea::KeyframePtr held = store_.held(request);
    return held && held->fields.contains(request.fields) ? Holding::keyframe : Holding::nothing;
}

KeyframeSource::Report KeyframeSource::report() const {
    const std::scoped_lock lock(mutex_);
    return {description_, synthesis_, store_.counters(), costs_, device_rebuilds_};
}

std::int64_t KeyframeSource::samples(int cascade) const {
    const std::int64_t size =
        course_->first()->realization->cascades[static_cast<std::size_t>(cascade)].spec.size;
    return size * size;
}

template <class T>
Result<T> KeyframeSource::or_fail(Result<T> result) {
    if (result)
        return result;
    if (result.error().is(DeviceError::out_of_memory))
        return Error{Refusal::busy, result.error().message};
    failure_ = Error{Refusal::gone,
                     fmt::format("the device has failed for good: {}", result.error().message)};
    failed_ = true;
    return *failure_;
}

// ---- jobs ----------------------------------------------------------------------------------

std::vector<sea::KeyframePtr> KeyframeJob::take() {
    SEAWAY_CHECK(made(), "a part is taken once it is made");
    open_ = false;
    std::vector<sea::KeyframePtr> part = std::move(found_);
    if (const Room::Place place = std::move(place_))
        for (sea::KeyframePtr& keyframe : part)
            keyframe = with_place(place, std::move(keyframe));
    return part;
}

Result<bool> KeyframeSource::work_on(KeyframeJob& job) {
    if (failure_)
        return *failure_;
    std::int64_t budget = samples_per_slice;
    return or_fail(slice(job, budget));
}

bool KeyframeSource::open_part(KeyframeJob& job) {
    const std::size_t begin = job.end_;
    std::size_t end = begin;
    std::int64_t part = 0;
    bool foam = false;
    std::vector<sea::KeyframePtr> held;
    for (; end < job.wanted_.size(); ++end) {
        const KeyframeRequest& request = job.wanted_[end];
        sea::KeyframePtr one = store_.held(request);
        const sea::FieldSet there = one ? one->fields : sea::FieldSet{};
        const std::int64_t more =
            samples(request.cascade) * with_foam_inputs(request.fields | there).size();
        if (end > begin && part + more > samples_per_slice)
            break;
        part += more;
        held.push_back(std::move(one));
        foam = foam || request.fields.without(there).contains(sea::Field::foam);
    }
    job.part_bytes_ = static_cast<std::size_t>(part) * sizeof(float);
    // First the turn, then room: who holds room never waits for somebody else.
    if (foam && !takes_its_turn(job))
        return false;
    if (job.room_ && !(job.place_ = job.room_->take(job.part_bytes_)))
        return false;
    if (foam && job.walk_ != Walk::stream) // which no change begins before
        foam_of(job.walk_).maps.follow_changes();
    job.open_ = true;
    job.end_ = end;
    look_up(job, begin, std::move(held));
    return true;
}

void KeyframeSource::look_up(KeyframeJob& job, std::size_t begin,
                             std::vector<sea::KeyframePtr> held) {
    job.found_.assign(job.end_ - begin, nullptr);
    for (std::size_t i = 0; i < held.size(); ++i) {
        KeyframeRequest request = job.wanted_[begin + i];
        sea::KeyframePtr& found = job.found_[i];
        found = store_.find(request, job.walk_ == Walk::stream);
        if (!found && held[i] && held[i]->fields.contains(request.fields))
            found = held[i]; // let go of meanwhile
        if (found)
            continue;
        if (held[i])
            request.fields = request.fields.without(held[i]->fields);
        job.missing_.push_back({i, request, std::move(held[i]), foam_time(request)});
    }
}

Result<bool> KeyframeSource::slice(KeyframeJob& job, std::int64_t& budget) {
    job.lacks_sea_.reset();
    if (!job.open_ && !open_part(job))
        return false;
    while (budget > 0 && !job.made()) {
        SEAWAY_TRY_LET(const bool near, walk_to_next(job, budget));
        if (near && are_there(job))
            SEAWAY_TRY(synthesize_some(job, budget));
        if (job.lacks_sea_)
            return false;
    }
    if (job.made() && job.end_ == job.wanted_.size())
        job.turn_ = nullptr;
    return job.made();
}

bool KeyframeSource::takes_its_turn(KeyframeJob& job) {
    if (job.walk_ == Walk::stream || job.turn_ != nullptr)
        return true;
    std::weak_ptr<const void>& turn = foam_of(job.walk_).turn;
    job.awaited_turn_ = turn; // a copy: it is looked at on other threads
    if (!job.awaited_turn_.expired())
        return false;
    job.turn_ = std::make_shared<char>();
    turn = job.turn_;
    return true;
}

bool KeyframeSource::fits(const Together& together, const KeyframeJob& job,
                          const KeyframeJob::Missing& next) {
    if (!next.walks_foam())
        return true;
    const KeyframeRequest& request = next.request;
    const bool alone = together.with_turn.empty() ||
                       (request.epoch == together.foam_epoch &&
                        std::ranges::count(together.with_turn, request.cascade) == 0);
    return alone && foam_maps(job, request.epoch).is_near(request.cascade, next.foam_us);
}

Result<void> KeyframeSource::add_turn(Together& together, const KeyframeJob& job,
                                      const KeyframeJob::Missing& next) {
    KeyframeRequest request = next.request;
    FoamMaps& foam = foam_maps(job, request.epoch);
    const TimeUs time_us = next.foam_us;
    together.with_turn.push_back(request.cascade); // before its step is taken
    together.foam_epoch = request.epoch;
    SEAWAY_TRY_LET(const FoamTurn turn, foam.turn(*this, request.cascade, time_us));
    const FoamTurn* kept = &together.turns.emplace_back(turn);
    const std::size_t place = together.requests.size();
    if (time_us == request.time_us)
        request.foam = kept;
    else
        together.moved.push_back({place, place + 1});
    together.places.push_back(place);
    together.requests.push_back(request);
    if (time_us != request.time_us)
        together.requests.push_back({request.cascade,
                                     time_us,
                                     {sea::Field::foam},
                                     course_->window_at(time_us).epoch,
                                     kept});
    return {};
}

Result<std::vector<NewKeyframePtr>> KeyframeSource::make(const KeyframeJob& job,
                                                         std::int64_t& budget, Together& together) {
    for (const KeyframeJob::Missing& next : job.missing_) {
        const KeyframeRequest& request = next.request;
        if (!together.requests.empty() && (budget <= 0 || !fits(together, job, next)))
            break;
        if (next.walks_foam()) {
            SEAWAY_TRY(add_turn(together, job, next));
        } else {
            together.places.push_back(together.requests.size());
            together.requests.push_back(request);
        }
        budget -= samples(request.cascade) *
                  (next.walks_foam() ? with_foam_inputs(request.fields) : request.fields).size();
    }
    return synthesize(together.requests);
}

Result<void> KeyframeSource::synthesize_some(KeyframeJob& job, std::int64_t& budget) {
    Together together;
    Undo steps([&] { // those of foam whose maps are not made are none
        for (const int cascade : together.with_turn)
            foam_maps(job, together.foam_epoch).restart(cascade);
    });
    const Result<std::vector<NewKeyframePtr>> made = make(job, budget, together);
    if (!made) {
        if (!made.error().is(DeviceError::foam_lost))
            return made.error();
        budget = 0; // the next slice starts anew
        return {};
    }
    steps.keep();
    for (const Together::Foam& moved : together.moved)
        sea::copy_map(*(*made)[moved.of], sea::Field::foam, *(*made)[moved.keyframe]);
    for (const std::size_t place : together.places) {
        const KeyframeJob::Missing& missing = job.missing_.front();
        const NewKeyframePtr& lacking = (*made)[place];
        keep(job, missing.place, missing.held ? joined(*missing.held, *lacking) : lacking);
        job.missing_.pop_front();
    }
    return {};
}

NewKeyframePtr KeyframeSource::joined(const sea::Keyframe& held, const sea::Keyframe& made) const {
    NewKeyframePtr whole = make_keyframe(joined_);
    *whole = {made.epoch, made.cascade,  made.time_us,
              made.size,  made.length_m, held.fields | made.fields};
    whole->stylised = held.stylised || made.stylised;
    whole->values =
        joined_->take(static_cast<std::size_t>(whole->fields.size()) * whole->plane_size());
    for (const sea::Keyframe* part : {&held, &made})
        for (const sea::Field field : part->fields)
            sea::copy_map(*part, field, *whole);
    return whole;
}

bool KeyframeSource::is_there(KeyframeJob& job, std::uint32_t epoch) const {
    if (job.leaves_seas_ && !course_->sea_if_held(epoch))
        job.lacks_sea_ = epoch;
    return !job.lacks_sea_;
}

bool KeyframeSource::are_there(KeyframeJob& job) const {
    return std::ranges::all_of(job.missing_, [&](const KeyframeJob::Missing& one) {
        return is_there(job, one.request.epoch) &&
               (!one.walks_foam() || is_there(job, course_->window_at(one.foam_us).epoch));
    });
}

Result<bool> KeyframeSource::walk_to_next(KeyframeJob& job, std::int64_t& budget) {
    const KeyframeJob::Missing& next = job.missing_.front();
    if (!next.walks_foam())
        return true;
    return walk(foam_maps(job, next.request.epoch), next.request.cascade, next.foam_us,
                next.foam_us - 1, budget, &job);
}

void KeyframeSource::keep(KeyframeJob& job, std::size_t place, sea::KeyframePtr keyframe) {
    const sea::KeyframePtr held = store_.held(request_of(*keyframe));
    if (!held || !held->fields.contains(keyframe->fields)) // made meanwhile, with more
        store_.insert(keyframe, job.walk_ == Walk::stream);
    job.found_[place] = std::move(keyframe);
}

// ---- foam ----------------------------------------------------------------------------------

FoamMaps& KeyframeSource::streamed_foam(std::uint32_t epoch) {
    const auto held = std::ranges::find(streamed_foam_, epoch, &EpochFoam::epoch);
    if (held != streamed_foam_.end())
        return held->maps;
    // Goes on from where the sea before is.
    streamed_foam_.push_back({epoch, streamed_foam_.back().maps});
    if (streamed_foam_.size() > 2)
        streamed_foam_.erase(streamed_foam_.begin());
    return streamed_foam_.back().maps;
}

FoamMaps& KeyframeSource::foam_maps(const KeyframeJob& job, std::uint32_t epoch) {
    return job.walk_ == Walk::stream ? streamed_foam(epoch) : foam_of(job.walk_).maps;
}

TimeUs KeyframeSource::foam_time(const KeyframeRequest& request) const {
    const EpochWindow window = course_->window(request.epoch);
    return std::max(std::min(request.time_us, window.end_us), window.start_us);
}

Result<bool> KeyframeSource::walk(FoamMaps& foam, int cascade, TimeUs time_us, TimeUs until_us,
                                  std::int64_t& budget, KeyframeJob* job) {
    const auto is_there_at = [&](TimeUs at_us) {
        return job == nullptr || is_there(*job, course_->window_at(at_us).epoch);
    };
    const std::int64_t tick = foam_tick_fields * samples(cascade);
    const auto ticks_max = static_cast<int>(std::max<std::int64_t>(budget / tick, 1));
    foam.look_for_changes(cascade);
    const int before = foam.ticks_to(cascade, time_us);
    const Result<bool> there = foam.walk(*this, cascade, time_us, ticks_max, until_us, is_there_at);
    if (!there && there.error().is(DeviceError::foam_lost)) {
        budget = 0; // the next slice starts anew
        return false;
    }
    if (!there)
        return there.error();
    const int left = foam.ticks_to(cascade, time_us);
    SEAWAY_CHECK(*there || left < before || (job != nullptr && job->lacks_sea_),
                 "each slice brings foam nearer to its time");
    budget -= tick * (before - left);
    return *there;
}

int KeyframeSource::foam_ticks_to(int cascade, TimeUs time_us) const {
    return streamed_foam_.back().maps.ticks_to(cascade, time_us);
}

Result<bool> KeyframeSource::walk_streamed_foam(int cascade, TimeUs time_us) {
    if (failure_)
        return *failure_;
    std::int64_t budget = samples_per_slice;
    return or_fail(walk(streamed_foam_.back().maps, cascade, time_us, time_us, budget));
}

void KeyframeSource::share_streamed_foam(int cascade) {
    for (AskedFoam* foam : {&started_foam_, &asked_foam_})
        if (foam->turn.expired()) // else someone is half-way
            foam->maps.take_over(cascade, streamed_foam_.back().maps);
}

// ---- the device, and its accounts ------------------------------------------------------------

Result<FoamMapPtr> KeyframeSource::open_foam(int size, const FoamMap* from) {
    return device_.open_foam(size, from);
}

Result<std::vector<NewKeyframePtr>>
KeyframeSource::synthesize_rounded(std::span<const KeyframeRequest> requests) {
    std::vector<KeyframeRequest> rounded(requests.begin(), requests.end());
    std::vector<std::vector<float>> bounds; // which the requests point to
    bounds.reserve(rounded.size());
    for (KeyframeRequest& request : rounded)
        request.rounding = bounds.emplace_back(rounding_bounds(
            course_->sea(request.epoch)->budget, request.fields, request.cascade, readback_));
    return device_.synthesize(rounded);
}

Result<std::vector<NewKeyframePtr>>
KeyframeSource::synthesize(std::span<const KeyframeRequest> requests) {
    Result<std::vector<NewKeyframePtr>> made =
        readback_ == Readback::exact ? device_.synthesize(requests) : synthesize_rounded(requests);
    const std::scoped_lock lock(mutex_);
    description_ = device_.device().description();
    device_rebuilds_ = device_.device().rebuilds();
    const SynthesisCounters before = std::exchange(synthesis_, device_.device().counters());
    if (made)
        costs_.add(requests, synthesis_ - before);
    return made;
}

} // namespace seaway::server
