// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/running_sea.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "sea/scene/scene_warnings.h"
#include "sea/waves/realize.h"
#include "server/simulation/effect_plan.h"

namespace seaway::server {

Result<RunningSeaPtr> make_running_sea(const sea::Scene& scene, std::uint32_t epoch) {
    Result<sea::Realization> realized = sea::realize(scene);
    if (!realized)
        return realized.error();
    SEAWAY_TRY_LET(sea::CertificatePtr certificate, sea::load_certificate(scene));
    auto realization = std::make_shared<const sea::Realization>(std::move(realized).value());
    const sea::FieldSet offered = offered_fields(scene.effects);
    return std::make_shared<const RunningSea>(RunningSea{
        epoch, scene, realization, sea::plan_budget(*realization, scene.accuracy.height_error_m),
        offered, sea::summarize(scene.sea, *realization), sea::DirectSum(realization),
        sea::foam_law_of(scene, *realization), std::move(certificate)});
}

std::vector<std::string> warnings_of(const RunningSea& sea) {
    std::vector<std::string> warnings =
        sea::scene_warnings(sea.scene, *sea.realization, sea.summary, sea.budget);
    const auto add = [&warnings](std::vector<std::string> more) {
        std::ranges::move(more, std::back_inserter(warnings));
    };
    add(sea::foam_warnings(sea.foam_law));
    if (sea.certificate)
        add(sea::certificate_warnings(*sea.certificate, sea.scene, sea.summary.requested));
    return warnings;
}

} // namespace seaway::server
