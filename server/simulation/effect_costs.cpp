// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/effect_costs.h"

#include <cmath>

namespace seaway::server {

EffectCosts::EffectCosts(std::vector<int> sizes)
    : sizes_(std::move(sizes)), costs_(sizes_.size() * effect_table().size()) {}

double EffectCosts::weight(std::size_t cascade, sea::FieldSet fields) const {
    constexpr double strains = 3;
    const double n = sizes_[cascade];
    double transformed = 0;
    for (const sea::Field field : fields)
        transformed += sea::is_linear(field) ? 1.0 : strains;
    return transformed * n * n * std::log2(n);
}

namespace {

/// Foam pays for strains that its turn looks at.
sea::FieldSet paid(const KeyframeRequest& request) {
    const sea::FieldSet foam{sea::Field::foam};
    const bool looks = request.foam != nullptr && request.foam->looks(request.fields);
    return looks ? request.fields | foam : request.fields.without(foam);
}

} // namespace

void EffectCosts::add(std::span<const KeyframeRequest> requests, const SynthesisCounters& growth) {
    add_foam_seconds(requests, growth.foam_seconds);
    double total = 0;
    for (const KeyframeRequest& request : requests)
        total += weight(static_cast<std::size_t>(request.cascade), paid(request));
    if (total <= 0)
        return;
    weight_done_ += total;
    seconds_done_ += growth.device_seconds;
    for (const KeyframeRequest& request : requests) {
        const auto cascade = static_cast<std::size_t>(request.cascade);
        for (std::size_t e = 0; e < effect_table().size(); ++e) {
            const sea::FieldSet fields = fields_of(effect_table()[e], paid(request));
            if (fields.empty())
                continue;
            const double share = weight(cascade, fields) / total;
            EffectCost& cost = costs_[cascade * effect_table().size() + e];
            ++cost.keyframes;
            cost.dispatches += share * static_cast<double>(growth.dispatches);
            cost.transforms += share * static_cast<double>(growth.transforms);
            cost.device_seconds += share * growth.device_seconds;
        }
    }
}

void EffectCosts::add_foam_seconds(std::span<const KeyframeRequest> requests, double seconds) {
    const auto points = [&](const KeyframeRequest& request) {
        return request.foam == nullptr
                   ? 0.0
                   : std::pow(sizes_[static_cast<std::size_t>(request.cascade)], 2);
    };
    double total = 0;
    for (const KeyframeRequest& request : requests)
        total += points(request);
    for (const KeyframeRequest& request : requests)
        for (std::size_t e = 0; e < effect_table().size() && total > 0; ++e)
            if (effect_table()[e].fields.contains(sea::Field::foam))
                costs_[static_cast<std::size_t>(request.cascade) * effect_table().size() + e]
                    .device_seconds += seconds * points(request) / total;
}

double EffectCosts::predicted_seconds(std::size_t cascade, sea::FieldSet fields) const {
    return weight_done_ > 0 ? weight(cascade, fields) * seconds_done_ / weight_done_ : 0.0;
}

} // namespace seaway::server
