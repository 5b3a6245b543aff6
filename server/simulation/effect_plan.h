// SPDX-License-Identifier: Apache-2.0
// Effect plan: what is computed, decided by a pure function from what the scene allows and what
// is demanded at this moment. No demand, no dispatch.
//
// Effects are sets of fields; a field that stands on others (the Jacobian on three strains) brings
// them along. Thread-safe: values and pure functions.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "sea/basics/field.h"
#include "sea/scene/scene.h"
#include "sea/surface/budget/error_budget.h"
#include "server/host/subscriptions.h"

namespace seaway::server {

/// One row an effect: the fields that it stands for.
struct EffectInfo {
    std::string_view name;
    sea::FieldSet fields;
};

/// Names as in /v1/plan and /metrics.
std::span<const EffectInfo> effect_table();

/// Fields that the scene lets anyone have. Time rates of what is displaced always belong to it:
/// keyframes are joined by them.
sea::FieldSet offered_fields(const sea::Effects& effects);

struct CascadePlan {
    sea::FieldSet fields;    ///< union of all demand for every keyframe, within what is offered
    sea::TimeUs interval_us; ///< between keyframes
    int transforms = 0;      ///< 2-D transforms of real fields a keyframe that has all of both
    /// The same for those who take keyframes at most at a rate (rate_rungs_hz, the first of which is nobody's here).
    std::array<sea::FieldSet, rate_rungs_hz.size()> rarer{};

    /// Of keyframes at this rate.
    sea::FieldSet at(std::size_t rate) const { return rate == 0 ? fields : rarer[rate]; }
    sea::FieldSet all() const {
        sea::FieldSet all = fields;
        for (const sea::FieldSet more : rarer)
            all |= more;
        return all;
    }
};

struct EffectPlan {
    std::vector<CascadePlan> cascades;
    bool questioned = false; ///< keyframes are held that were made for a question
    /// Nobody asks for anything.
    bool idle() const;
};

EffectPlan plan_effects(sea::FieldSet offered, const Subscriptions& subscriptions,
                        const sea::ErrorBudget& budget);

/// Real fields that are transformed for a set of fields; the Jacobian and foam need the strains.
sea::FieldSet transformed_for(sea::FieldSet fields);

/// How many: each takes a 2-D transform.
inline int transforms_for(sea::FieldSet fields) {
    return transformed_for(fields).size();
}

} // namespace seaway::server
