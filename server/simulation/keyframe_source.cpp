// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/keyframe_source.h"

#include <algorithm>
#include <chrono>
#include <limits>

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

Result<std::vector<sea::KeyframePtr>>
KeyframeSource::keyframes(std::span<const KeyframeRequest> wanted, Walk walk) {
    if (failure_)
        return *failure_;
    std::vector<sea::KeyframePtr> found(wanted.size());
    std::vector<KeyframeRequest> missing;
    std::vector<std::size_t> place;
    for (std::size_t i = 0; i < wanted.size(); ++i) {
        const auto& [cascade, time_us, fields] = wanted[i];
        found[i] = store_.find(cascade, time_us, fields);
        if (found[i])
            continue;
        missing.push_back({cascade, time_us, fields | store_.held(cascade, time_us)});
        place.push_back(i);
    }
    if (missing.empty())
        return found;
    Result<std::vector<sea::KeyframePtr>> made =
        compute(missing, walk == Walk::stream ? streamed_foam_ : asked_foam_);
    if (!made) {
        failure_ = Error{Refusal::gone,
                         fmt::format("the device has failed for good: {}", made.error().message)};
        failed_ = true;
        return *failure_;
    }
    for (std::size_t i = 0; i < made->size(); ++i) {
        store_.insert((*made)[i]);
        found[place[i]] = std::move((*made)[i]);
    }
    return found;
}

Result<std::vector<sea::KeyframePtr>>
KeyframeSource::compute(std::span<const KeyframeRequest> requests, FoamMaps& foam) {
    std::vector<KeyframeRequest> synthesized(requests.begin(), requests.end());
    for (KeyframeRequest& request : synthesized)
        request.fields = with_foam_inputs(request.fields);
    SEAWAY_TRY_LET(const std::vector<NewKeyframePtr> made, synthesize(synthesized, requests));
    for (const NewKeyframePtr& keyframe : made)
        if (keyframe->fields.contains(sea::Field::foam))
            SEAWAY_TRY(fill_foam(keyframe, foam));
    return std::vector<sea::KeyframePtr>(made.begin(), made.end());
}

Result<std::vector<NewKeyframePtr>>
KeyframeSource::synthesize(std::span<const KeyframeRequest> requests,
                           std::span<const KeyframeRequest> asked) {
    Result<std::vector<NewKeyframePtr>> made = device_->synthesize(requests);
    const std::scoped_lock lock(mutex_);
    description_ = device_->description();
    device_rebuilds_ = device_->rebuilds();
    const SynthesisCounters before = std::exchange(synthesis_, device_->counters());
    if (made)
        costs_.add(asked, synthesis_ - before);
    return made;
}

Result<void> KeyframeSource::fill_foam(const NewKeyframePtr& keyframe, FoamMaps& foam) {
    using Clock = std::chrono::steady_clock;
    const auto cascade = static_cast<std::size_t>(keyframe->cascade);
    const Clock::time_point start = Clock::now();
    Clock::duration synthesizing{};
    const Result<void> filled = foam.fill(keyframe, [&](TimeUs t_us) -> Result<sea::KeyframePtr> {
        const Clock::time_point begin = Clock::now();
        const KeyframeRequest past{keyframe->cascade, t_us, sea::foam_inputs};
        const KeyframeRequest asked{keyframe->cascade, t_us, {sea::Field::foam}};
        const Result<std::vector<NewKeyframePtr>> one = synthesize({&past, 1}, {&asked, 1});
        synthesizing += Clock::now() - begin;
        if (!one)
            return one.error();
        return sea::KeyframePtr(one->front());
    });
    const std::chrono::duration<double> spent = Clock::now() - start - synthesizing;
    const std::scoped_lock lock(mutex_);
    costs_.add_seconds(cascade, sea::Field::foam, spent.count());
    return filled;
}

Result<KeyframeSource::SurfaceSpan> KeyframeSource::surface_around(TimeUs time_us) {
    const std::vector<KeyframeRequest> wanted =
        keyframes_around(sea_->budget, {&time_us, 1}, {~0u, sea_->sampler_fields()});
    SEAWAY_TRY_LET(const std::vector<sea::KeyframePtr> held, keyframes(wanted, Walk::questions));
    std::vector<sea::SplinePair> pairs;
    TimeUs end_us = std::numeric_limits<TimeUs>::max();
    for (std::size_t i = 0; i < held.size(); i += 2) {
        pairs.push_back({store_.spline(held[i]), store_.spline(held[i + 1])});
        end_us = std::min(end_us, held[i + 1]->time_us);
    }
    return SurfaceSpan{std::make_shared<const sea::Surface>(
                           std::move(pairs), sea_->realization->choppiness,
                           fold_search(sea_->budget), map_error(sea_->budget, 0.0)),
                       end_us};
}

} // namespace seaway::server
