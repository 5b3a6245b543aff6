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

/// What a client takes of a sea at most.
struct Told {
    const char* what;
    double sea::ErrorBudget::*value;
    double most;
};
constexpr Told all_told[] = {
    {"error between keyframes and grid points, m", &sea::ErrorBudget::interpolation_m,
     sea::told_error_m_max},
    {"rms slope", &sea::ErrorBudget::rms_slope, sea::told_slope_max},
    {"curvature, 1/m", &sea::ErrorBudget::curvature_per_m, sea::told_curvature_per_m_max},
    {"displacement, m", &sea::ErrorBudget::displacement_reach_m, sea::told_sideways_max},
    {"rms strain", &sea::ErrorBudget::rms_strain, sea::told_sideways_max},
    {"error of displacements, m", &sea::ErrorBudget::interpolation_displacement_m,
     sea::told_sideways_max},
    {"error of strains", &sea::ErrorBudget::interpolation_strain, sea::told_sideways_max}};

/// On these grids and coarser ones no wind or swell that a scene can ask for is refused: sixteen systems of 40 m, ten times as
/// high as they are, have slopes of 1.3e5 where all of it is at the shortest waves.
constexpr double spacing_of_no_doubt_m = 0.01;

Result<void> check_told(const sea::ErrorBudget& budget) {
    for (const Told& told : all_told)
        if (const double most = sea::steady_share_of_told * told.most;
            !(budget.*told.value <= most))
            return Error{fmt::format("its waves are too steep for tiles: {} = {:.3g}, at most {:g}",
                                     told.what, budget.*told.value, most)};
    return {};
}

/// A log may hold seas that this version refuses: told as steep as can be, they run.
sea::ErrorBudget as_told(sea::ErrorBudget budget) {
    for (const Told& told : all_told)
        if (!(budget.*told.value <= told.most))
            budget.*told.value = told.most;
    return budget;
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
    return glide ? std::nullopt : sea::wave_law(scene.sea, *realization);
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
    if (const Result<void> fine = check_told(sea->budget); !fine)
        return Error{fmt::format("{}: {}", scene.source, fine.error().message)};
    return sea;
}

Result<void> check_tellable(const sea::Scene& scene) {
    const auto by_parameters = [](const sea::WaveSystem& system) {
        return std::holds_alternative<sea::WindSea>(system) ||
               std::holds_alternative<sea::Swell>(system);
    };
    const auto coarse = [](const sea::CascadeSpec& tile) {
        return tile.spacing_m() >= spacing_of_no_doubt_m;
    };
    if (std::ranges::all_of(scene.sea.systems, by_parameters) &&
        std::ranges::all_of(scene.cascades, coarse))
        return {};
    SEAWAY_TRY_LET(const sea::Realization waves, sea::realize(scene));
    return check_told(sea::plan_budget(waves, scene.accuracy.height_error_m));
}

RunningSeaPtr make_running_sea(const sea::Scene& scene, std::uint32_t epoch,
                               sea::RealizationPtr realization, sea::CertificatePtr certificate) {
    const sea::FieldSet offered = offered_fields(scene.effects);
    return std::make_shared<const RunningSea>(
        RunningSea{epoch, scene, realization,
                   as_told(sea::plan_budget(*realization, scene.accuracy.height_error_m)), offered,
                   sea::summarize(scene.sea, *realization),
                   std::make_shared<const sea::DirectSum>(realization),
                   sea::foam_law_of(scene, *realization), std::move(certificate)});
}

namespace {

/// All cascades lie over one sea floor.
double depth_of(const sea::Realization& waves) {
    return waves.cascades.empty() ? 0.0 : waves.cascades.front().depth_m;
}

} // namespace

Result<RunningSeaPtr> make_glide(const RunningSea& from, const RunningSea& to, std::uint32_t epoch,
                                 sea::TimeUs start_us, sea::TimeUs end_us) {
    const sea::RealizationPtr then = from.waves_at(start_us);
    SEAWAY_TRY_LET(sea::SeaTransition change,
                   sea::SeaTransition::create(then, to.realization, start_us, end_us));
    auto glide = std::make_shared<SeaGlide>(
        SeaGlide{std::move(change), from.choppiness_at(start_us),
                 from.glides_at(start_us) ? sea::summarize(from.scene.sea, *then).realised
                                          : from.summary.realised,
                 0.0, nullptr});
    const sea::FoamLawPtr foam = from.foam_law_at(start_us);
    if (foam && to.foam_law) {
        glide->foam_mean = from.foam_mean_at(start_us);
        glide->foam = std::make_shared<const sea::FoamGlide>(glide->change, foam, to.foam_law);
    }
    const sea::RealizationPtr envelope = glide->change.envelope();
    sea::ErrorBudget budget = sea::plan_budget(
        *envelope, to.scene.accuracy.height_error_m, shorter_intervals(from.budget, to.budget),
        {end_us - start_us, depth_of(*then), depth_of(*to.realization)});
    // What follows from heights does so in water of one depth. A glide that is cut is somewhere between its two.
    const auto deep_as = [](const sea::CascadeModes& a, const sea::CascadeModes& b) {
        return a.depth_m == b.depth_m;
    };
    budget.displacement_follows =
        budget.displacement_follows &&
        std::ranges::equal(then->cascades, to.realization->cascades, deep_as);
    return std::make_shared<const RunningSea>(
        RunningSea{epoch, to.scene, glide->change.after(), as_told(std::move(budget)), to.offered,
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
