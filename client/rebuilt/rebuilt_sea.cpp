// SPDX-License-Identifier: Apache-2.0
#include "client/rebuilt/rebuilt_sea.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "base/elapsed.h"
#include "client/link/failure.h"
#include "sea/basics/deviations.h"
#include "sea/scene/scene.h"

namespace seaway::client {
namespace {

/// Half of what the told curvature of a single wave is.
constexpr double one_wave_bends = 0.5 * std::numbers::sqrt2 / sea::bound_sigmas;

/// Smaller Jacobians are counted as this one: nearer to a fold answers are flagged.
constexpr double area_least = 0.1;

Result<void> check_tiles(const protocol::SeaStateValues& state, const sea::Realization& waves) {
    bool same = state.cascades.size() == waves.cascades.size();
    for (std::size_t c = 0; same && c < waves.cascades.size(); ++c)
        same = state.cascades[c].length_m == waves.cascades[c].spec.length_m &&
               state.cascades[c].size == waves.cascades[c].spec.size;
    if (same)
        return {};
    return failed(Failure::not_held, "the scene that was sent has other tiles than its sea");
}

} // namespace

RebuiltSea::RebuiltSea(sea::RealizationPtr waves, const protocol::SeaStateValues& state,
                       const RebuiltError& error, sea::WaveGrowth growth)
    : waves_(std::move(waves)), sum_(waves_, std::move(growth)),
      folds_(sea::fold_search(state.displacement_reach_m, waves_->choppiness, state.rms_strain)),
      error_(error), curvature_per_m_(state.curvature_per_m) {}

double RebuiltSea::answer(std::span<const sea::QueryPoint> points, std::span<sea::Answer> answers,
                          std::span<sea::ErrorTerms> terms, std::uint32_t cascades) const {
    if (points.empty())
        return 0;
    auto [moment, took_s] = laid_out(points[0].time_us, cascades);
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (i > 0 && points[i].time_us != points[i - 1].time_us)
            moment = sum_.at_time(points[i].time_us, cascades);
        answers[i] = answer(points[i], moment, terms.empty() ? nullptr : &terms[i]);
    }
    return took_s;
}

RebuiltSea::LaidOut RebuiltSea::laid_out(sea::TimeUs time_us, std::uint32_t cascades) const {
    const double begun_s = thread_cpu_seconds();
    sea::DirectSum::Moment moment = sum_.at_time(time_us, cascades);
    return {std::move(moment), thread_cpu_seconds() - begun_s};
}

sea::InverseOptions RebuiltSea::options(const sea::QueryPoint& point) const {
    sea::InverseOptions options{waves_->choppiness, sea::exact_tolerance_m(point), folds_};
    constexpr double for_folds = sea::fold_sigmas / sea::bound_sigmas;
    if (error_.strain > 0)
        options.blur = {error_.height_m, for_folds * error_.displacement_m, error_.strain};
    return options;
}

void RebuiltSea::add_error(const sea::QueryPoint& point, double area, sea::Answer& answer,
                           sea::ErrorTerms* terms) const {
    const double sideways = sea::surface_slope(answer) * waves_->choppiness.largest();
    const double inverse_m = answer.error_m + sea::exact_tolerance_m(point);
    // To first order; and to second what the slope itself is off by, and how far the surface bends over that way, which is longer where
    // water is squeezed. Of a single wave, whose errors all agree, nothing else is left for these; of its curvature sqrt(2) of five deviations
    // are all.
    const double moved_m =
        waves_->choppiness.largest() * error_.displacement_m / std::max(area, area_least);
    const double second_m = moved_m * (sea::bound_sigmas / sea::fold_sigmas * error_.strain +
                                       one_wave_bends * curvature_per_m_ * moved_m);
    const double waves_m = std::hypot(error_.height_m, sideways * error_.displacement_m) + second_m;
    answer.error_m = inverse_m + waves_m;
    if (terms != nullptr)
        *terms = answer.flags & sea::answer_invalid
                     ? sea::ErrorTerms{}
                     : sea::ErrorTerms{.codec_m = waves_m, .inverse_m = inverse_m};
}

sea::Answer RebuiltSea::answer(const sea::QueryPoint& point, const sea::DirectSum::Moment& moment,
                               sea::ErrorTerms* terms) const {
    double area = 1;
    sea::Answer answer = sea::surface_at(point, options(point), moment, nullptr, &area);
    add_error(point, area, answer, terms);
    return answer;
}

sea::Answer RebuiltSea::answer(const sea::QueryPoint& point, double z_m,
                               const sea::DirectSum::Moment& moment, sea::WaterBelow& water) const {
    double area = 1;
    sea::Answer answer = sea::water_at(point, z_m, options(point), moment, water, &area);
    add_error(point, area, answer, nullptr);
    return answer;
}

namespace {

const std::vector<sea::Probe>& probes_of(const protocol::SeaStateValues& state) {
    return state.glide ? state.glide->leads_to : state.probes;
}

Result<void> can_be_compared(const protocol::SeaStateValues& state) {
    if (!probes_of(state).empty())
        return {};
    return failed(Failure::not_held,
                  state.glide ? fmt::format("the sea changes until {:g} s, and no probes tell "
                                            "whether one that is made from its scene is the same",
                                            sea::seconds_from_us(state.glide->end_us))
                              : "the server sent no probes to know a rebuilt sea by");
}

} // namespace

Result<void> agrees(const protocol::SeaStateValues& state, const RebuiltSea& sea) {
    SEAWAY_TRY(can_be_compared(state));
    const sea::ProbeDifference off = sea::compare(sea.sum(), probes_of(state));
    constexpr double more = sea::same_sigmas / sea::bound_sigmas;
    const double height_m = more * sea.error().height_m + state.probe_error_m;
    const double displacement_m = more * sea.error().displacement_m + state.probe_error_m;
    if (off.within(height_m, displacement_m))
        return {};
    return failed(Failure::not_held,
                  fmt::format("the rebuilt sea is not the server's: probes differ by {:.3g} m in "
                              "height and {:.3g} m sideways, allowed are {:.3g} and {:.3g} m",
                              off.height_m, off.displacement_m, height_m, displacement_m));
}

Result<RebuiltSeaPtr> rebuild_from_scene(const protocol::SeaStateValues& state,
                                         const sea::Realization* before) {
    SEAWAY_TRY(can_be_compared(state)); // before anything is made
    if (state.scene.empty())
        return failed(Failure::not_held, "the server sent no scene to rebuild its sea from");
    const Result<sea::Scene> scene = sea::parse_scene(state.scene, "the server's scene");
    if (!scene)
        return failed(Failure::not_held, scene.error().message);
    Result<sea::Realization> waves = sea::realize(*scene);
    if (!waves)
        return failed(Failure::not_held, waves.error().message);
    SEAWAY_TRY(check_tiles(state, *waves));
    auto made = std::make_shared<const sea::Realization>(*std::move(waves));
    if (before != nullptr) {
        SEAWAY_TRY_LET(made, sea::continued(*before, *made, state.start_time_us));
    }
    auto rebuilt = std::make_shared<const RebuiltSea>(
        std::move(made), state, RebuiltError{state.probe_error_m, state.probe_error_m});
    SEAWAY_TRY(agrees(state, *rebuilt));
    return rebuilt;
}

} // namespace seaway::client
