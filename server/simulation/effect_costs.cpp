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

void EffectCosts::add(std::span<const KeyframeRequest> requests, const SynthesisCounters& growth) {
    double total = 0;
    for (const KeyframeRequest& request : requests)
        total += weight(static_cast<std::size_t>(request.cascade), request.fields);
    if (total <= 0)
        return;
    weight_done_ += total;
    seconds_done_ += growth.device_seconds;
    for (const KeyframeRequest& request : requests) {
        const auto cascade = static_cast<std::size_t>(request.cascade);
        for (std::size_t e = 0; e < effect_table().size(); ++e) {
            const sea::FieldSet fields = fields_of(effect_table()[e], request.fields);
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

void EffectCosts::add_seconds(std::size_t cascade, sea::Field field, double seconds) {
    for (std::size_t e = 0; e < effect_table().size(); ++e)
        if (effect_table()[e].fields.contains(field))
            costs_[cascade * effect_table().size() + e].device_seconds += seconds;
}

double EffectCosts::predicted_seconds(std::size_t cascade, sea::FieldSet fields) const {
    return weight_done_ > 0 ? weight(cascade, fields) * seconds_done_ / weight_done_ : 0.0;
}

} // namespace seaway::server
