// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/effect_plan.h"

#include <algorithm>
#include <utility>

#include "sea/foam/foam_law.h"

namespace seaway::server {

using sea::Field;
using sea::FieldSet;

namespace {

constexpr EffectInfo effects[] = {
    {"height", {Field::height, Field::height_rate}},
    {"choppy",
     {Field::displacement_x, Field::displacement_y, Field::displacement_x_rate,
      Field::displacement_y_rate}},
    {"slopes", {Field::slope_x, Field::slope_y}},
    {"gradient", {Field::strain_xx, Field::strain_yy, Field::strain_xy, Field::jacobian}},
    {"foam", {Field::foam}},
};

// A field that no effect has can never be asked for.
static_assert([] {
    FieldSet seen;
    for (const EffectInfo& effect : effects) {
        if (!(seen & effect.fields).empty())
            return false;
        seen |= effect.fields;
    }
    return seen.size() == sea::field_count;
}());

} // namespace

std::span<const EffectInfo> effect_table() {
    return effects;
}

FieldSet offered_fields(const sea::Effects& allowed) {
    FieldSet offered = effects[0].fields;
    if (allowed.choppy)
        offered |= effects[1].fields | effects[3].fields;
    if (sea::has_foam(allowed))
        offered |= effects[4].fields;
    if (allowed.slopes)
        offered |= effects[2].fields;
    return offered;
}

bool EffectPlan::idle() const {
    return !questioned &&
           std::all_of(cascades.begin(), cascades.end(),
                       [](const CascadePlan& cascade) { return cascade.all().empty(); });
}

FieldSet transformed_for(FieldSet fields) {
    if (fields.contains(Field::jacobian) || fields.contains(Field::foam))
        fields |= sea::strain_fields;
    return fields & sea::linear_fields;
}

EffectPlan plan_effects(FieldSet offered, const Subscriptions& subscriptions,
                        const sea::ErrorBudget& budget) {
    EffectPlan plan;
    for (std::size_t c = 0; c < budget.cascades.size(); ++c) {
        CascadePlan cascade{{}, budget.cascades[c].interval_us, 0};
        cascade.rarer = subscriptions.wanted_by_rate(static_cast<int>(c));
        for (FieldSet& fields : cascade.rarer)
            fields &= offered;
        cascade.fields = std::exchange(cascade.rarer[0], {});
        cascade.transforms = transforms_for(cascade.all());
        plan.cascades.push_back(cascade);
    }
    return plan;
}

} // namespace seaway::server
