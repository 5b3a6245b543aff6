// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/course_synthesis.h"

#include <algorithm>
#include <utility>

namespace seaway::server {

using sea::FieldSet;

CourseSynthesis::Held CourseSynthesis::sea_of(const KeyframeRequest& request) const {
    const RunningSeaPtr sea = course_->sea(request.epoch);
    if (!sea->glide)
        return {request.epoch};
    // Before its start a glide is one sea, and after its end another.
    const sea::SeaTransition& change = sea->glide->change;
    return {request.epoch, std::clamp(request.time_us, change.start_us(), change.end_us()),
            Part::waves, 1u << request.cascade};
}

sea::RealizationPtr CourseSynthesis::waves_of(const Held& held) const {
    const RunningSeaPtr sea = course_->sea(held.epoch);
    if (!held.time_us)
        return sea->realization;
    const sea::SeaTransition& change = sea->glide->change;
    switch (held.part) {
    case Part::waves:
        return change.gliding(*held.time_us, held.cascades);
    case Part::growth:
        return change.growth(*held.time_us, held.cascades);
    case Part::displacement_growth:
        return change.displacement_growth(*held.time_us, held.cascades);
    }
    SEAWAY_CHECK(false, "a part of a glide");
    return nullptr;
}

Result<void> CourseSynthesis::hold(const Held& wanted) {
    if (held_ && held_->serves(wanted))
        return {};
    held_.reset();
    SEAWAY_TRY(device_->set_sea(waves_of(wanted), wanted.epoch));
    held_ = wanted;
    return {};
}

Result<std::vector<NewKeyframePtr>>
CourseSynthesis::synthesize(std::span<const KeyframeRequest> requests) {
    std::vector<NewKeyframePtr> keyframes(requests.size());
    std::vector<Held> seas; // each is looked at once: one that nobody holds is made for that
    for (const KeyframeRequest& request : requests)
        seas.push_back(sea_of(request));
    for (std::size_t i = 0; i < requests.size(); ++i) {
        if (keyframes[i])
            continue;
        Held sea = seas[i];
        std::vector<std::size_t> places;
        std::vector<KeyframeRequest> alike;
        for (std::size_t j = i; j < requests.size(); ++j) {
            if (keyframes[j])
                continue;
            if (!seas[j].is_alike(sea))
                continue;
            sea.cascades |= seas[j].cascades;
            places.push_back(j);
            alike.push_back(requests[j]);
        }
        SEAWAY_TRY_LET(const std::vector<NewKeyframePtr> made, of_one_sea(sea, alike));
        for (std::size_t k = 0; k < places.size(); ++k)
            keyframes[places[k]] = made[k];
    }
    return keyframes;
}

Result<std::vector<NewKeyframePtr>>
CourseSynthesis::of_one_sea(const Held& sea, std::span<const KeyframeRequest> requests) {
    SEAWAY_TRY(hold(sea));
    SEAWAY_TRY_LET(std::vector<NewKeyframePtr> made, device_->synthesize(requests));
    if (sea.time_us && course_->sea(sea.epoch)->glides_at(*sea.time_us))
        SEAWAY_TRY(add_growth(sea, requests, made));
    return made;
}

Result<void> CourseSynthesis::add_growth(const Held& sea, std::span<const KeyframeRequest> requests,
                                         std::span<const NewKeyframePtr> keyframes) {
    const RunningSeaPtr glide = course_->sea(sea.epoch);
    const sea::SeaTransition& change = glide->glide->change;
    const Held growth{sea.epoch, sea.time_us, Part::growth, sea.cascades};
    SEAWAY_TRY(add_growth_of(change.grown(), growth, requests, keyframes));
    const Held further{sea.epoch, sea.time_us, Part::displacement_growth, sea.cascades};
    return add_growth_of(change.grown_otherwise(), further, requests, keyframes);
}

Result<void> CourseSynthesis::add_growth_of(FieldSet maps, const Held& growth,
                                            std::span<const KeyframeRequest> requests,
                                            std::span<const NewKeyframePtr> keyframes) {
    std::vector<KeyframeRequest> grown;
    std::vector<NewKeyframePtr> onto;
    for (std::size_t i = 0; i < requests.size(); ++i)
        if (const FieldSet values = sea::values_of_rates(requests[i].fields) & maps;
            !values.empty()) {
            grown.push_back(requests[i]);
            grown.back().fields = values;
            grown.back().foam = nullptr;
            grown.back().rounding = {};
            onto.push_back(keyframes[i]);
        }
    if (grown.empty())
        return {};
    SEAWAY_TRY(hold(growth));
    SEAWAY_TRY_LET(const std::vector<NewKeyframePtr> made, device_->synthesize(grown));
    const RunningSeaPtr glide = course_->sea(growth.epoch);
    for (std::size_t i = 0; i < grown.size(); ++i)
        for (const auto& [value, rate] : sea::rate_table) {
            if (!grown[i].fields.contains(value))
                continue;
            onto[i]->forget_steps({rate});
            glide->glide->change.add_growth(onto[i]->plane(rate),
                                            std::as_const(*made[i]).plane(value), *growth.time_us);
        }
    return {};
}

} // namespace seaway::server
