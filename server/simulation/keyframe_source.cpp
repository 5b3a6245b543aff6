// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/keyframe_source.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include <fmt/format.h>

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
                               const Memory& memory)
    : course_(std::move(course)),
      device_(course_, std::move(device)), streamed_foam_{{course_->first()->epoch,
                                                           FoamMaps(course_)}},
      started_foam_{FoamMaps(course_)}, asked_foam_{FoamMaps(course_)},
      store_(memory.room(MemoryUse::keyframes)), description_(device_.device().description()),
      costs_(cascade_sizes(*course_->first())) {}

Holding KeyframeSource::holding(const KeyframeRequest& request) const {
    const sea::KeyframePtr held = store_.held(request);
    if (!held || !held->fields.contains(request.fields))
        return Holding::nothing;
    return store_.splined(request) ? Holding::spline : Holding::keyframe;
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

template <class Work>
auto KeyframeSource::timed(int cascade, const Work& work) {
    using Clock = std::chrono::steady_clock;
    const Clock::time_point start = Clock::now();
    const double synthesis_before_s = synthesis_s_;
    auto result = work();
    const std::chrono::duration<double> spent = Clock::now() - start;
    const std::scoped_lock lock(mutex_);
    costs_.add_seconds(static_cast<std::size_t>(cascade), sea::Field::foam,
                       spent.count() - (synthesis_s_ - synthesis_before_s));
    return result;
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

KeyframeRequest KeyframeSource::with_held_fields(KeyframeRequest request) const {
    if (const sea::KeyframePtr held = store_.held(request))
        request.fields |= held->fields;
    return request;
}

bool KeyframeSource::walks_foam(const KeyframeRequest& request) const {
    if (!request.fields.contains(sea::Field::foam))
        return false;
    const sea::KeyframePtr held = store_.held(request);
    return !held || !held->fields.contains(sea::Field::foam);
}

bool KeyframeSource::open_part(KeyframeJob& job) {
    const std::size_t begin = job.end_;
    std::size_t end = begin;
    std::int64_t part = 0;
    bool foam = false;
    for (; end < job.wanted_.size(); ++end) {
        const KeyframeRequest request = with_held_fields(job.wanted_[end]);
        const std::int64_t more =
            samples(request.cascade) * with_foam_inputs(request.fields).size();
        if (end > begin && part + more > samples_per_slice)
            break;
        part += more;
        foam = foam || walks_foam(request);
    }
    job.part_bytes_ = static_cast<std::size_t>(part) * sizeof(float);
    // First the turn, then room: who holds room never waits for somebody else.
    if (foam && !takes_its_turn(job))
        return false;
    if (job.room_ && !(job.place_ = job.room_->take(job.part_bytes_)))
        return false;
    job.open_ = true;
    job.end_ = end;
    look_up(job, begin);
    return true;
}

void KeyframeSource::look_up(KeyframeJob& job, std::size_t begin) {
    job.found_.assign(job.end_ - begin, nullptr);
    for (std::size_t i = begin; i < job.end_; ++i) {
        const KeyframeRequest& request = job.wanted_[i];
        sea::KeyframePtr& found = job.found_[i - begin];
        found = store_.find(request);
        if (found)
            continue;
        sea::KeyframePtr held = store_.held(request);
        if (held && !held->fields.contains(sea::Field::foam))
            held = nullptr;
        job.missing_.push_back({i - begin, with_held_fields(request), std::move(held)});
    }
}

Result<bool> KeyframeSource::slice(KeyframeJob& job, std::int64_t& budget) {
    if (!job.open_ && !open_part(job))
        return false;
    while (budget > 0 && !job.made()) {
        if (job.without_foam_.empty())
            SEAWAY_TRY(synthesize_some(job, budget));
        else
            SEAWAY_TRY(add_foam(job, budget));
    }
    if (job.made() && job.end_ == job.wanted_.size())
        job.turn_ = nullptr;
    return job.made();
}

bool KeyframeSource::takes_its_turn(KeyframeJob& job) {
    if (job.walk_ == Walk::stream || job.turn_ != nullptr)
        return true;
    std::weak_ptr<const void>& turn = foam_of(job.walk_).turn;
    job.awaited_turn_ = turn.expired() ? nullptr : &turn;
    if (job.awaited_turn_)
        return false;
    job.turn_ = std::make_shared<char>();
    turn = job.turn_;
    return true;
}

Result<void> KeyframeSource::synthesize_some(KeyframeJob& job, std::int64_t& budget) {
    std::vector<KeyframeRequest> asked;
    std::vector<KeyframeRequest> synthesized;
    while (asked.size() < job.missing_.size() && (budget > 0 || asked.empty())) {
        const KeyframeJob::Missing& next = job.missing_[asked.size()];
        asked.push_back(next.request);
        if (next.foam_of)
            asked.back().fields = without_foam(next.request.fields);
        KeyframeRequest& request = synthesized.emplace_back(next.request);
        if (next.walks_foam())
            request.fields = with_foam_inputs(request.fields);
        budget -= samples(request.cascade) * request.fields.size();
    }
    SEAWAY_TRY_LET(const std::vector<NewKeyframePtr> made, synthesize(synthesized, asked));
    for (const NewKeyframePtr& keyframe : made) {
        const KeyframeJob::Missing& request = job.missing_.front();
        if (request.walks_foam()) {
            job.without_foam_.push_back({request.place, keyframe});
        } else {
            if (request.foam_of)
                std::ranges::copy(std::as_const(*request.foam_of).plane(sea::Field::foam),
                                  keyframe->plane(sea::Field::foam).begin());
            keep(job, request.place, keyframe);
        }
        job.missing_.pop_front();
    }
    return {};
}

Result<void> KeyframeSource::add_foam(KeyframeJob& job, std::int64_t& budget) {
    const std::size_t place = job.without_foam_.front().place;
    const NewKeyframePtr keyframe = job.without_foam_.front().keyframe;
    FoamMaps& foam =
        job.walk_ == Walk::stream ? streamed_foam(keyframe->epoch) : foam_of(job.walk_).maps;
    const TimeUs time_us = foam_time(*keyframe);
    const auto strains_at = [&](TimeUs t_us) -> Result<sea::KeyframePtr> {
        return t_us == keyframe->time_us ? Result<sea::KeyframePtr>(keyframe)
                                         : strains(keyframe->cascade, t_us);
    };
    return timed(keyframe->cascade, [&]() -> Result<void> {
        SEAWAY_TRY_LET(const bool there,
                       walk(foam, keyframe->cascade, time_us, budget, strains_at));
        if (!there)
            return {};
        SEAWAY_TRY(foam.fill(keyframe, time_us, strains_at));
        keep(job, place, keyframe);
        job.without_foam_.pop_front();
        return {};
    });
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

TimeUs KeyframeSource::foam_time(const sea::Keyframe& keyframe) const {
    const EpochWindow window = course_->window(keyframe.epoch);
    return std::max(std::min(keyframe.time_us, window.end_us), window.start_us);
}

Result<bool> KeyframeSource::walk(FoamMaps& foam, int cascade, TimeUs time_us, std::int64_t& budget,
                                  const sea::FoamHistory::StrainsAt& strains_at) {
    const std::int64_t tick = foam_tick_fields * samples(cascade);
    const auto ticks_max = static_cast<int>(std::max<std::int64_t>(budget / tick, 1));
    const int before = foam.ticks_to(cascade, time_us);
    SEAWAY_TRY_LET(const bool there, foam.walk_towards(cascade, time_us, ticks_max, strains_at));
    const int left = foam.ticks_to(cascade, time_us);
    SEAWAY_CHECK(there ? left == 0 : left < before, "each slice brings foam nearer to its time");
    budget -= tick * std::max(before - left, 1);
    return there;
}

int KeyframeSource::foam_ticks_to(int cascade, TimeUs time_us) const {
    return streamed_foam_.back().maps.ticks_to(cascade, time_us);
}

Result<bool> KeyframeSource::walk_streamed_foam(int cascade, TimeUs time_us) {
    if (failure_)
        return *failure_;
    std::int64_t budget = samples_per_slice;
    return or_fail(timed(cascade, [&] {
        return walk(streamed_foam_.back().maps, cascade, time_us, budget,
                    [&](TimeUs t_us) { return strains(cascade, t_us); });
    }));
}

void KeyframeSource::share_streamed_foam(int cascade) {
    for (AskedFoam* foam : {&started_foam_, &asked_foam_})
        if (foam->turn.expired()) // else someone is half-way
            foam->maps.take_over(cascade, streamed_foam_.back().maps);
}

Result<sea::KeyframePtr> KeyframeSource::strains(int cascade, TimeUs time_us) {
    const std::uint32_t epoch = course_->window_at(time_us).epoch;
    const KeyframeRequest past{cascade, time_us, sea::foam_inputs, epoch};
    const KeyframeRequest asked{cascade, time_us, {sea::Field::foam}, epoch};
    SEAWAY_TRY_LET(const std::vector<NewKeyframePtr> one, synthesize({&past, 1}, {&asked, 1}));
    return sea::KeyframePtr(one.front());
}

Result<std::vector<NewKeyframePtr>>
KeyframeSource::synthesize(std::span<const KeyframeRequest> requests,
                           std::span<const KeyframeRequest> asked) {
    const auto start = std::chrono::steady_clock::now();
    Result<std::vector<NewKeyframePtr>> made = device_.synthesize(requests);
    synthesis_s_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const std::scoped_lock lock(mutex_);
    description_ = device_.device().description();
    device_rebuilds_ = device_.device().rebuilds();
    const SynthesisCounters before = std::exchange(synthesis_, device_.device().counters());
    if (made)
        costs_.add(asked, synthesis_ - before);
    return made;
}

} // namespace seaway::server
