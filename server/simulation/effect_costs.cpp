// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/effect_costs.h"

#include <cmath>

namespace seaway::server {

namespace {

constexpr sea::FieldSet foam{sea::Field::foam};

/// Foam pays for strains that its turn looks at.
sea::FieldSet paid(const KeyframeRequest& request) {
    const bool looks = request.foam != nullptr && request.foam->looks(request.fields);
    return looks ? request.fields | foam : request.fields.without(foam);
}

/// Transforms of an effect among those of a set of fields.
double transforms_of(std::size_t effect, sea::FieldSet fields) {
    double transforms = 0;
    for (const sea::Field field : transformed_for(fields_of(effect_table()[effect], fields))) {
        int users = 0;
        for (const EffectInfo& other : effect_table())
            users += transformed_for(fields_of(other, fields)).contains(field);
        transforms += 1.0 / users;
    }
    return transforms;
}

} // namespace

EffectCosts::EffectCosts(std::vector<int> sizes)
    : sizes_(std::move(sizes)), costs_(sizes_.size() * effect_table().size()),
      turns_(sizes_.size()), looks_(sizes_.size()) {}

double EffectCosts::points(std::size_t cascade) const {
    const double n = sizes_[cascade];
    return n * n;
}

double EffectCosts::weight(std::size_t cascade) const {
    return points(cascade) * std::log2(sizes_[cascade]);
}

void EffectCosts::add(std::span<const KeyframeRequest> requests, const SynthesisCounters& growth) {
    add_foam_seconds(requests, growth.foam_seconds);
    double transforms = 0, weights = 0;
    for (const KeyframeRequest& request : requests) {
        const double own = transforms_for(paid(request));
        transforms += own;
        weights += own * weight(static_cast<std::size_t>(request.cascade));
    }
    transforms_.work += weights;
    transforms_.seconds += transforms > 0 ? growth.device_seconds : 0.0;
    for (const KeyframeRequest& request : requests)
        for (std::size_t e = 0; e < effect_table().size(); ++e) {
            EffectCost& cost = cost_of(request, e);
            const sea::FieldSet held = fields_of(effect_table()[e], request.fields);
            // At a seam the plane of foam waits for a request of its own, which has the turn.
            const bool waits = held == sea::FieldSet{sea::Field::foam} && request.foam == nullptr;
            cost.keyframes += !held.empty() && !waits;
            const double own = transforms_of(e, paid(request));
            if (own == 0)
                continue;
            cost.dispatches += own / transforms * static_cast<double>(growth.dispatches);
            cost.transforms += own / transforms * static_cast<double>(growth.transforms);
            cost.device_seconds += own * weight(static_cast<std::size_t>(request.cascade)) /
                                   weights * growth.device_seconds;
        }
}

void EffectCosts::add_foam_seconds(std::span<const KeyframeRequest> requests, double seconds) {
    double total = 0;
    for (const KeyframeRequest& request : requests)
        if (request.foam != nullptr) {
            const auto cascade = static_cast<std::size_t>(request.cascade);
            total += points(cascade);
            ++turns_[cascade];
            looks_[cascade] += request.foam->looks(request.fields);
        }
    foam_.work += total;
    foam_.seconds += total > 0 ? seconds : 0.0;
    for (const KeyframeRequest& request : requests)
        for (std::size_t e = 0; e < effect_table().size() && request.foam != nullptr; ++e)
            if (effect_table()[e].fields.contains(foam))
                cost_of(request, e).device_seconds +=
                    seconds * points(static_cast<std::size_t>(request.cascade)) / total;
}

double EffectCosts::predicted_seconds(std::size_t cascade, std::size_t effect,
                                      sea::FieldSet all) const {
    const bool calm = turns_[cascade] > 0 && looks_[cascade] == 0;
    const double own = transforms_of(effect, calm ? all.without(foam) : all);
    const bool steps = fields_of(effect_table()[effect], all).contains(foam);
    return transforms_.of(own * weight(cascade)) + (steps ? foam_.of(points(cascade)) : 0.0);
}

} // namespace seaway::server
