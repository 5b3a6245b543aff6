// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/running_sea.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include <fmt/format.h>

#include "sea/scene/scene_warnings.h"
#include "sea/surface/steepest_sea.h"
#include "sea/waves/realize.h"
#include "server/simulation/effect_plan.h"

namespace seaway::server {

namespace {

double share_at(const SeaGlide& glide, sea::TimeUs time_us) {
    return sea::glide_share(time_us, glide.change.start_us(), glide.change.end_us());
}

/// As a client takes it.
Result<void> check_told(const sea::ErrorBudget& budget, const std::string& source) {
    struct Told {
        const char* what;
        double value, most;
    };
    for (const Told& told :
         {Told{"error between keyframes and grid points, m", budget.interpolation_m,
               sea::told_error_m_max},
          Told{"rms slope", budget.rms_slope, sea::told_slope_max},
          Told{"curvature, 1/m", budget.curvature_per_m, sea::told_curvature_per_m_max},
          Told{"displacement, m", budget.displacement_reach_m, sea::told_sideways_max},
          Told{"rms strain", budget.rms_strain, sea::told_sideways_max},
          Told{"error of displacements, m", budget.interpolation_displacement_m,
               sea::told_sideways_max},
          Told{"error of strains", budget.interpolation_strain, sea::told_sideways_max}})
        if (!(told.value <= told.most))
            return Error{
                fmt::format("{}: its waves are too steep for tiles: {} = {:.3g}, at most {:g}",
                            source, told.what, told.value, told.most)};
    return {};
}

/// The shorter interval of two seas, cascade by cascade.
std::vector<sea::TimeUs> shorter_intervals(const sea::ErrorBudget& a, const sea::ErrorBudget& b) {
    std::vector<sea::TimeUs> intervals_us;
    for (std::size_t c = 0; c < b.cascades.size(); ++c)
        intervals_us.push_back(std::min(a.cascades[c].interval_us, b.cascades[c].interval_us));
    return intervals_us;
}

} // namespace

std::optional<sea::WaveLaw> RunningSea::wave_law() const {
    const auto has_sines = [](const sea::CascadeModes& modes) { return !modes.sines.empty(); };
    if (glide || std::ranges::any_of(realization->cascades, has_sines))
        return std::nullopt;
    return sea::WaveLaw{scene.sea.dispersion(), realization->loop_period_us};
}

sea::Choppiness RunningSea::choppiness_at(sea::TimeUs time_us) const {
    if (!glide)
        return realization->choppiness;
    const double share = share_at(*glide, time_us);
    return {sea::glided(glide->choppiness.x, realization->choppiness.x, share),
            sea::glided(glide->choppiness.y, realization->choppiness.y, share)};
}

double RunningSea::foam_mean_at(sea::TimeUs time_us) const {
    const double mean = foam_law ? foam_law->mean_coverage : 0.0;
    return glide ? sea::glided(glide->foam_mean, mean, share_at(*glide, time_us)) : mean;
}

Result<RunningSeaPtr> make_running_sea(const sea::Scene& scene, std::uint32_t epoch) {
    Result<sea::Realization> realized = sea::realize(scene);
    if (!realized)
        return realized.error();
    SEAWAY_TRY_LET(sea::CertificatePtr certificate, sea::load_certificate(scene));
    RunningSeaPtr sea = make_running_sea(
        scene, epoch, std::make_shared<const sea::Realization>(std::move(realized).value()),
        std::move(certificate));
    SEAWAY_TRY(check_told(sea->budget, scene.source));
    return sea;
}

RunningSeaPtr make_running_sea(const sea::Scene& scene, std::uint32_t epoch,
                               sea::RealizationPtr realization, sea::CertificatePtr certificate) {
    const sea::FieldSet offered = offered_fields(scene.effects);
    return std::make_shared<const RunningSea>(RunningSea{
        epoch, scene, realization, sea::plan_budget(*realization, scene.accuracy.height_error_m),
        offered, sea::summarize(scene.sea, *realization),
        std::make_shared<const sea::DirectSum>(realization), sea::foam_law_of(scene, *realization),
        std::move(certificate)});
}

Result<RunningSeaPtr> make_glide(const RunningSea& from, const RunningSea& to, std::uint32_t epoch,
                                 sea::TimeUs start_us, sea::TimeUs end_us) {
    const sea::RealizationPtr then = from.waves_at(start_us);
    SEAWAY_TRY_LET(sea::SeaTransition change,
                   sea::SeaTransition::create(then, to.realization, start_us, end_us));
    auto glide = std::make_shared<SeaGlide>(
        SeaGlide{std::move(change), from.choppiness_at(start_us),
                 from.glides_at(start_us) ? sea::summarize(from.scene.sea, *then).realised
                                          : from.summary.realised,
                 0.0, 0.0, nullptr});
    const sea::FoamLawPtr foam = from.foam_law_at(start_us);
    if (foam && to.foam_law) {
        glide->foam_mean = from.foam_mean_at(start_us);
        glide->foam_threshold = foam->threshold;
        glide->foam = std::make_shared<const sea::FoamGlide>(glide->change, foam, to.foam_law);
    }
    const sea::RealizationPtr envelope = glide->change.envelope();
    sea::ErrorBudget budget =
        sea::plan_budget(*envelope, to.scene.accuracy.height_error_m,
                         shorter_intervals(from.budget, to.budget), end_us - start_us);
    // What follows from heights does so in water of one depth. A glide that is cut is somewhere between its two.
    const auto deep_as = [](const sea::CascadeModes& a, const sea::CascadeModes& b) {
        return a.depth_m == b.depth_m;
    };
    budget.displacement_follows =
        budget.displacement_follows &&
        std::ranges::equal(then->cascades, to.realization->cascades, deep_as);
    SEAWAY_TRY(check_told(budget, to.scene.source));
    return std::make_shared<const RunningSea>(
        RunningSea{epoch, to.scene, glide->change.after(), std::move(budget), to.offered,
                   to.summary, to.truth, to.foam_law, to.certificate, std::move(glide)});
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
