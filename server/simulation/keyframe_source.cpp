// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/keyframe_source.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "server/host/refusal.h"
#include "server/simulation/schedule.h"

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

KeyframeSource::KeyframeSource(RunningSeaPtr sea, std::unique_ptr<RebuiltSynthesizer> device)
    : sea_(std::move(sea)), device_(std::move(device)), streamed_foam_(*sea_), asked_foam_(*sea_),
      description_(device_->description()), costs_(cascade_sizes(*sea_)) {}

KeyframeSource::Report KeyframeSource::report() const {
    const std::scoped_lock lock(mutex_);
    return {description_, synthesis_, store_.counters(), costs_, device_rebuilds_};
}

std::int64_t KeyframeSource::samples(int cascade) const {
    const std::int64_t size =
        sea_->realization->cascades[static_cast<std::size_t>(cascade)].spec.size;
    return size * size;
}

template <class T>
Result<T> KeyframeSource::or_fail(Result<T> result) {
    if (result)
        return result;
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

Result<bool> KeyframeSource::work_on(KeyframeJob& job) {
    if (failure_)
        return *failure_;
    return or_fail(slice(job));
}

Result<std::vector<sea::KeyframePtr>>
KeyframeSource::keyframes(std::vector<KeyframeRequest> wanted) {
    KeyframeJob job(std::move(wanted), Walk::questions);
    for (bool made = false; !made;) {
        SEAWAY_TRY_LET(made, work_on(job));
        SEAWAY_CHECK(made || job.without_foam_.empty(), "foam is walked for in slices");
    }
    return job.take();
}

void KeyframeSource::look_up(KeyframeJob& job) {
    job.begun_ = true;
    for (std::size_t i = 0; i < job.wanted_.size(); ++i) {
        KeyframeRequest request = job.wanted_[i];
        job.found_[i] = store_.find(request.cascade, request.time_us, request.fields);
        if (job.found_[i])
            continue;
        sea::KeyframePtr held = store_.held(request.cascade, request.time_us);
        if (held)
            request.fields |= held->fields;
        if (held && !held->fields.contains(sea::Field::foam))
            held = nullptr;
        job.missing_.push_back({i, request, std::move(held)});
    }
}

Result<bool> KeyframeSource::slice(KeyframeJob& job) {
    if (!job.begun_)
        look_up(job);
    std::int64_t budget = samples_per_slice;
    while (budget > 0 && !(job.missing_.empty() && job.without_foam_.empty())) {
        if (job.without_foam_.empty())
            SEAWAY_TRY(synthesize_some(job, budget));
        else if (takes_its_turn(job))
            SEAWAY_TRY(add_foam(job, budget));
        else
            return false;
    }
    const bool made = job.missing_.empty() && job.without_foam_.empty();
    if (made)
        job.turn_ = nullptr;
    return made;
}

bool KeyframeSource::takes_its_turn(KeyframeJob& job) {
    if (job.walk_ == Walk::questions && job.turn_ == nullptr) {
        if (!asked_foam_turn_.expired())
            return false;
        job.turn_ = std::make_shared<char>();
        asked_foam_turn_ = job.turn_;
    }
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
    FoamMaps& foam = job.walk_ == Walk::stream ? streamed_foam_ : asked_foam_;
    const auto strains_at = [&](TimeUs t_us) -> Result<sea::KeyframePtr> {
        return t_us == keyframe->time_us ? Result<sea::KeyframePtr>(keyframe)
                                         : strains(keyframe->cascade, t_us);
    };
    return timed(keyframe->cascade, [&]() -> Result<void> {
        SEAWAY_TRY_LET(const bool there,
                       walk(foam, keyframe->cascade, keyframe->time_us, budget, strains_at));
        if (!there)
            return {};
        SEAWAY_TRY(foam.fill(keyframe, strains_at));
        keep(job, place, keyframe);
        job.without_foam_.pop_front();
        return {};
    });
}

void KeyframeSource::keep(KeyframeJob& job, std::size_t place, sea::KeyframePtr keyframe) {
    const sea::KeyframePtr held = store_.held(keyframe->cascade, keyframe->time_us);
    if (!held || !held->fields.contains(keyframe->fields)) // made meanwhile, with more
        store_.insert(keyframe);
    job.found_[place] = std::move(keyframe);
}

// ---- foam ----------------------------------------------------------------------------------

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
    return streamed_foam_.ticks_to(cascade, time_us);
}

Result<bool> KeyframeSource::walk_streamed_foam(int cascade, TimeUs time_us) {
    if (failure_)
        return *failure_;
    std::int64_t budget = samples_per_slice;
    return or_fail(timed(cascade, [&] {
        return walk(streamed_foam_, cascade, time_us, budget,
                    [&](TimeUs t_us) { return strains(cascade, t_us); });
    }));
}

void KeyframeSource::share_streamed_foam(int cascade) {
    if (asked_foam_turn_.expired()) // else someone is half-way
        asked_foam_.take_over(cascade, streamed_foam_);
}

Result<sea::KeyframePtr> KeyframeSource::strains(int cascade, TimeUs time_us) {
    const KeyframeRequest past{cascade, time_us, sea::foam_inputs};
    const KeyframeRequest asked{cascade, time_us, {sea::Field::foam}};
    SEAWAY_TRY_LET(const std::vector<NewKeyframePtr> one, synthesize({&past, 1}, {&asked, 1}));
    return sea::KeyframePtr(one.front());
}

Result<std::vector<NewKeyframePtr>>
KeyframeSource::synthesize(std::span<const KeyframeRequest> requests,
                           std::span<const KeyframeRequest> asked) {
    const auto start = std::chrono::steady_clock::now();
    Result<std::vector<NewKeyframePtr>> made = device_->synthesize(requests);
    synthesis_s_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const std::scoped_lock lock(mutex_);
    description_ = device_->description();
    device_rebuilds_ = device_->rebuilds();
    const SynthesisCounters before = std::exchange(synthesis_, device_->counters());
    if (made)
        costs_.add(asked, synthesis_ - before);
    return made;
}

Result<KeyframeSource::SurfaceSpan> KeyframeSource::surface_around(TimeUs time_us) {
    SEAWAY_TRY_LET(
        const std::vector<sea::KeyframePtr> held,
        keyframes(keyframes_around(sea_->budget, {&time_us, 1}, {~0u, sea_->sampler_fields()})));
    std::vector<sea::SplinePair> pairs;
    TimeUs end_us = std::numeric_limits<TimeUs>::max();
    for (std::size_t i = 0; i < held.size(); i += 2) {
        pairs.push_back({store_.spline(held[i]), store_.spline(held[i + 1])});
        end_us = std::min(end_us, held[i + 1]->time_us);
    }
    return SurfaceSpan{std::make_shared<const sea::Surface>(
                           std::move(pairs), sea_->realization->choppiness,
                           fold_search(sea_->budget), map_error(sea_->budget, 0.0),
                           sea::inverse_tolerance_m(sea_->budget.height_error_m)),
                       end_us};
}

} // namespace seaway::server
