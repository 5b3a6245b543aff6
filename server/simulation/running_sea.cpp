// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/running_sea.h"

#include <cmath>

#include <fmt/format.h>

#include "sea/waves/realize.h"
#include "server/refusal.h"
#include "server/simulation/effect_plan.h"

namespace seaway::server {

Result<void> check_time(sea::TimeUs time_us) {
    if (sea::in_time_range(time_us))
        return {};
    return Error{Refusal::bad_value, fmt::format("time_us is {}, allowed are {} to {}", time_us,
                                                 -sea::time_us_max, sea::time_us_max)};
}

Result<void> check_point(const sea::QueryPoint& point) {
    for (const auto& [name, value] : {std::pair("x_m", point.x_m), std::pair("y_m", point.y_m)})
        if (std::isfinite(value) && std::abs(value) > sea::position_max_m)
            return Error{Refusal::bad_value,
                         fmt::format("{} is {}, allowed are {} to {}", name, value,
                                     -sea::position_max_m, sea::position_max_m)};
    return check_time(point.time_us);
}

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
