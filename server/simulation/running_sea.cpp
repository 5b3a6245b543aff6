// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/running_sea.h"

#include "sea/waves/realize.h"
#include "server/simulation/effect_plan.h"

namespace seaway::server {

Result<RunningSeaPtr> make_running_sea(const sea::Scene& scene, std::uint32_t epoch) {
    Result<sea::Realization> realized = sea::realize(scene);
    if (!realized)
        return realized.error();
    auto realization = std::make_shared<const sea::Realization>(std::move(realized).value());
    const sea::FieldSet offered = offered_fields(scene.effects);
    return std::make_shared<const RunningSea>(RunningSea{
        epoch, scene, realization, sea::plan_budget(*realization, scene.accuracy.height_error_m),
        offered, sea::summarize(scene.sea, *realization), sea::DirectSum(realization),
        offered.contains(sea::Field::foam) ? sea::make_foam_law(scene, *realization) : nullptr});
}

} // namespace seaway::server
