// SPDX-License-Identifier: Apache-2.0
#include "server/world_reports.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "base/elapsed.h"
#include "protocol/limits.h"
#include "sea/scene/scene_names.h"
#include "sea/waves/probes.h"
#include "server/host/metrics_text.h"
#include "server/process_metrics.h"

namespace seaway::server {

using nlohmann::ordered_json;

namespace {

protocol::SeaNumbers numbers(const sea::SeaStatistics& statistics) {
    return {statistics.significant_height_m,   statistics.peak_period_s,
            statistics.zero_crossing_period_s, statistics.mean_period_s,
            sea::mean_from_deg(statistics),    statistics.spread_rad * 180.0 / sea::pi,
            statistics.mean_square_slope};
}

ordered_json to_json(const protocol::SeaNumbers& n) {
    return {{"hs_m", n.hs_m},
            {"tp_s", n.tp_s},
            {"tz_s", n.tz_s},
            {"tm01_s", n.tm01_s},
            {"mean_from_deg", n.mean_from_deg},
            {"spread_deg", n.spread_deg},
            {"mss", n.mss}};
}

std::vector<std::string> names(sea::FieldSet fields) {
    std::vector<std::string> all;
    for (const sea::Field field : fields)
        all.emplace_back(sea::info(field).name);
    return all;
}

ordered_json counters_json(const SimulationCounters& c) {
    return {{"dispatches", c.synthesis.dispatches},
            {"transforms", c.synthesis.transforms},
            {"keyframes", c.synthesis.keyframes},
            {"device_seconds", c.synthesis.device_seconds}};
}

/// Both null where the sea is steady.
ordered_json glide_begin_json(const protocol::SeaStateValues& state) {
    return state.glide && state.glide->realised ? to_json(*state.glide->realised)
                                                : ordered_json(nullptr);
}

ordered_json glide_end_json(const RunningSea& sea) {
    if (!sea.glide)
        return nullptr;
    return sea::seconds_from_us(sea.glide->change.end_us());
}

/// Null where the scene names no certificate. `holds`: this is what was measured.
ordered_json certificate_json(const RunningSea& sea) {
    if (!sea.certificate)
        return nullptr;
    const sea::Certificate& c = *sea.certificate;
    return {{"file", sea.scene.accuracy.certificate.name},
            {"says", describe(c)},
            {"height_error_m", c.promised_m},
            {"percentile", c.percentile},
            {"measured_m", c.worst().total_m},
            {"holds", certificate_warnings(c, sea.scene, sea.summary.requested).empty()}};
}

/// One effect of one cascade: what it will cost by the device's measured speed, and its share of what
/// was measured: time is taken a submission at a time and shared out by transforms.
ordered_json effect_json(const EffectCosts& costs, std::size_t cascade, std::size_t effect,
                         sea::FieldSet all, double rate_hz) {
    const EffectCost& cost = costs.cost(cascade, effect);
    const sea::FieldSet fields = fields_of(effect_table()[effect], all);
    const double predicted_us = 1e6 * costs.predicted_seconds(cascade, effect, all);
    const double share_us =
        cost.keyframes ? 1e6 * cost.device_seconds / static_cast<double>(cost.keyframes) : 0.0;
    return {{"effect", effect_table()[effect].name},        {"fields", names(fields)},
            {"predicted_us_per_keyframe", predicted_us},    {"share_us_per_keyframe", share_us},
            {"predicted_us_per_s", predicted_us * rate_hz}, {"keyframes", cost.keyframes}};
}

/// One row an effect of each cascade, as Prometheus counters.
void add_effects(MetricsText& text, const EffectPlan& plan, const EffectCosts& costs) {
    struct Row {
        std::string_view name;
        std::string_view help;
        double (*value)(const EffectCost&);
    };
    static constexpr Row rows[] = {
        {"effect_keyframes_total", "Keyframes that held an effect.",
         [](const EffectCost& cost) { return static_cast<double>(cost.keyframes); }},
        {"effect_dispatches_total", "Its share of kernels started.",
         [](const EffectCost& cost) { return cost.dispatches; }},
        {"effect_transforms_total", "Its share of 2-D transforms of real fields.",
         [](const EffectCost& cost) { return cost.transforms; }},
        {"effect_seconds_total", "Its share of the device's time.",
         [](const EffectCost& cost) { return cost.device_seconds; }}};
    for (const Row& row : rows) {
        text.family(row.name, "counter", row.help);
        for (std::size_t c = 0; c < plan.cascades.size(); ++c)
            for (std::size_t e = 0; e < effect_table().size(); ++e)
                text.value({{"cascade", std::to_string(c)}, {"effect", effect_table()[e].name}},
                           row.value(costs.cost(c, e)));
    }
}

/// What came of a device's memory, on the way to keyframes.
void add_readback(MetricsText& text, const SynthesisCounters& c) {
    text.one("readback_bytes_total", "counter",
             "Bytes of maps that crossed from a device's own memory.", c.readback_bytes);
    text.one("maps_rounded_total", "counter", "Maps that crossed as 16 bits (--readback rounded).",
             c.maps_rounded);
    text.family("maps_too_large_total", "counter", "Maps that 16 bits were too few for.");
    for (const sea::FieldInfo& row : sea::field_table)
        text.value({{"field", row.name}}, c.maps_too_large[static_cast<std::size_t>(row.field)]);
}

} // namespace

protocol::SeaStateValues sea_state_values(const RunningSea& sea, const EpochWindow& window,
                                          const std::vector<std::string>& warnings) {
    protocol::SeaStateValues state;
    state.epoch = sea.epoch;
    // The first one has run for ever; a change may come before time 0.
    state.start_time_us = std::max(window.start_us, -sea::time_us_max);
    for (std::size_t c = 0; c < sea.realization->cascades.size(); ++c) {
        const sea::CascadeModes& modes = sea.realization->cascades[c];
        state.cascades.push_back({modes.spec.length_m, modes.spec.size, modes.longest_radpm(),
                                  modes.band.k_hi_radpm, !modes.carries_spectra,
                                  sea.budget.cascades[c].interval_us,
                                  sea.budget.cascades[c].stylised});
    }
    state.choppiness_x = sea.realization->choppiness.x;
    state.choppiness_y = sea.realization->choppiness.y;
    state.height_error_m = sea.budget.height_error_m;
    state.requested = numbers(sea.summary.requested);
    state.realised = numbers(sea.summary.realised);
    state.interpolation_error_m = sea.budget.interpolation_m;
    state.rms_slope = sea.budget.rms_slope;
    state.curvature_per_m = sea.budget.curvature_per_m;
    state.displacement_reach_m = sea.budget.displacement_reach_m;
    state.rms_strain = sea.budget.rms_strain;
    state.interpolation_displacement_m = sea.budget.interpolation_displacement_m;
    state.interpolation_strain = sea.budget.interpolation_strain;
    for (const sea::CascadeBudget& cascade : sea.budget.cascades)
        state.losses.push_back(cascade.loss);
    state.single_precision_m = sea.budget.single_precision_m;
    state.single_precision_displacement_m = sea.budget.single_precision_displacement_m;
    state.depth_m = sea.scene.sea.depth_m;
    state.water = sea.scene.water;
    state.wave_law = sea.wave_law();
    if (sea.foam_law) {
        state.foam_mean = sea.foam_law->mean_coverage;
        state.foam_threshold = sea.foam_law->threshold;
    }
    const sea::FoamGlide* foam = sea.glide ? sea.glide->foam.get() : nullptr;
    if (foam)
        state.foam_threshold = foam->last_threshold();
    if (sea.glide) {
        state.glide = protocol::GlideValues{.end_us = sea.glide->change.end_us(),
                                            .choppiness_x = sea.glide->choppiness.x,
                                            .choppiness_y = sea.glide->choppiness.y,
                                            .foam_mean = sea.glide->foam_mean,
                                            .foam_threshold = foam ? foam->first_threshold() : 0,
                                            .realised = numbers(sea.glide->realised)};
        for (std::size_t c = 0; c < state.cascades.size(); ++c)
            state.glide->k_lo_radpm.push_back(sea.glide->change.longest_radpm(c));
    }
    state.scene =
        sea::to_toml(sea.foam_law ? sea::with_threshold(sea.scene, *sea.foam_law) : sea.scene);
    state.warnings = warnings;
    if (state.scene.size() > protocol::limits::scene_bytes_max) {
        state.scene.clear();
        state.warnings.push_back(
            fmt::format("the effective scene is longer than {} bytes and is not sent to clients",
                        protocol::limits::scene_bytes_max));
    }
    return state;
}

protocol::SeaStateValues announcement(const RunningSea& sea, const EpochWindow& window,
                                      const std::vector<std::string>& warnings) {
    protocol::SeaStateValues state = sea_state_values(sea, window, warnings);
    state.probe_error_m = sea::probe_error_m;
    if (state.glide) { // by its scene nobody knows where it comes from
        state.glide->leads_to = sea::make_probes(*sea.truth, state.glide->end_us);
        return state;
    }
    const bool is_first = state.start_time_us == -sea::time_us_max;
    state.probes = sea::make_probes(*sea.truth, is_first ? 0 : state.start_time_us);
    return state;
}

std::string state_json(const RunningSea& sea, const std::vector<std::string>& warnings,
                       const std::string& device, const SeaMoment& at,
                       const std::optional<Following>& following,
                       const RefusedChanges::Counts& refused) {
    const protocol::SeaStateValues state = sea_state_values(sea, {sea.epoch, 0, 0}, warnings);
    ordered_json cascades = ordered_json::array();
    for (std::size_t c = 0; c < state.cascades.size(); ++c) {
        const sea::CascadeBudget& budget = sea.budget.cascades[c];
        cascades.push_back({{"length_m", state.cascades[c].length_m},
                            {"size", state.cascades[c].size},
                            {"k_lo_radpm", state.cascades[c].k_lo_radpm},
                            {"k_hi_radpm", state.cascades[c].k_hi_radpm},
                            {"keyframe_interval_s", sea::seconds_from_us(budget.interval_us)},
                            {"time_interpolation_rms_m", budget.loss.height.time_m},
                            {"space_interpolation_rms_m",
                             std::hypot(budget.loss.height.east_m, budget.loss.height.north_m)},
                            {"requested_m2", sea.summary.cascades[c].requested_m2},
                            {"realised_m2", sea.summary.cascades[c].realised_m2}});
    }
    ordered_json json{{"epoch", sea.epoch},
                      {"sea_time_s", sea::seconds_from_us(at.now_us)},
                      {"pace", at.pace_permille / static_cast<double>(sea::pace_unit)},
                      {"epoch_utc", utc_text(at.epoch_utc_us)},
                      {"device", device},
                      {"scene", std::filesystem::path(sea.scene.source).filename().string()},
                      {"requested", to_json(state.requested)},
                      {"realised", to_json(state.realised)},
                      {"realised_before", glide_begin_json(state)},
                      {"cascades", cascades},
                      {"offered_fields", names(sea.streamed())},
                      {"foam_mean", state.foam_mean},
                      {"foam_threshold", state.foam_threshold},
                      {"height_error_m", sea.budget.height_error_m},
                      {"error_budget",
                       {{"level_m", sea::level_error_m(sea.budget, sea.budget.codec_error_m)},
                        {"interpolation_m", sea.budget.interpolation_m},
                        {"codec_m", sea.budget.codec_error_m},
                        {"single_precision_m", sea.budget.single_precision_m},
                        {"inverse_m", sea::inverse_tolerance_m(sea.budget.height_error_m)}}},
                      {"glides_until_s", glide_end_json(sea)},
                      {"certificate", certificate_json(sea)},
                      {"changes_refused", ordered_json(refused)},
                      {"cpu_s", process_cpu_seconds()},
                      {"warnings", warnings}};
    if (following)
        json["journal"] = ordered_json::parse(following->json());
    return json.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

/// Of a cascade, in a steady sea at pace 1.
double keyframes_per_s(const CascadePlan& plan, const sea::CascadeBudget& cascade) {
    double most_hz = 0;
    for (std::size_t rate = 0; rate < rate_rungs_hz.size(); ++rate)
        if (!plan.at(rate).empty())
            most_hz = std::max(most_hz, 1.0 / (sea::every_for(cascade, rate_rungs_hz[rate]) *
                                               sea::seconds_from_us(plan.interval_us)));
    return most_hz;
}

std::string plan_json(const RunningSea& sea, const EffectPlan& plan,
                      const SimulationCounters& counters, const EffectCosts& costs,
                      const std::string& device, const SeaMoment& at) {
    ordered_json cascades = ordered_json::array();
    for (std::size_t c = 0; c < plan.cascades.size(); ++c) {
        const CascadePlan& cascade = plan.cascades[c];
        const double rate_hz =
            keyframes_per_s(cascade, sea.budget.cascades[c]) * at.pace_permille / sea::pace_unit;
        ordered_json effects = ordered_json::array();
        for (std::size_t e = 0; e < effect_table().size(); ++e)
            if (!fields_of(effect_table()[e], cascade.all()).empty())
                effects.push_back(effect_json(costs, c, e, cascade.all(), rate_hz));
        cascades.push_back({{"length_m", sea.realization->cascades[c].spec.length_m},
                            {"size", sea.realization->cascades[c].spec.size},
                            {"effects", effects},
                            {"fields", names(cascade.all())},
                            {"keyframes_per_s", rate_hz},
                            {"transforms_per_keyframe", cascade.transforms}});
    }
    const ordered_json json{{"device", device},
                            {"idle", plan.idle()},
                            {"cascades", cascades},
                            {"done", counters_json(counters)}};
    return json.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

std::string metrics_text(const EffectPlan& plan, const SimulationCounters& counters,
                         const EffectCosts& costs, const SeaMoment& at) {
    MetricsText text;
    add_effects(text, plan, costs);
    add_readback(text, counters.synthesis);
    text.one("sea_time_seconds", "gauge", "Sea time.", sea::seconds_from_us(at.now_us));
    text.one("sea_pace_ratio", "gauge", "How fast the sea runs: 1 as clocks do, 0 paused.",
             at.pace_permille / static_cast<double>(sea::pace_unit));
    text.one("sea_clock_behind_seconds", "gauge",
             fmt::format(
                 "How far the sea's clock is behind UTC since the epoch; it is pulled by {} ms a "
                 "second.",
                 1000.0 / SeaClock::pull_parts),
             sea::seconds_from_us(at.behind_us));
    text.one("plan_idle", "gauge", "1 while nobody asks for anything.", plan.idle() ? 1 : 0);
    text.one("dispatches_total", "counter", "Kernels started.", counters.synthesis.dispatches);
    text.one("transforms_total", "counter", "2-D transforms of real fields.",
             counters.synthesis.transforms);
    text.one("stylised_sums_total", "counter",
             "Stylised waves that no transform carries, summed at a point of a map.",
             counters.synthesis.stylised_sums);
    text.one("keyframes_total", "counter", "Keyframes computed.", counters.synthesis.keyframes);
    text.one(
        "keyframes_copied_total", "counter",
        "Keyframes copied out of a device's memory: where it is not read in place, or where as "
        "many are held there as may be.",
        counters.synthesis.copies);
    text.one("foam_ticks_total", "counter",
             "Ticks of foam histories, and steps that were shown and not kept.",
             counters.synthesis.foam_ticks);
    text.one("cascades_taken_total", "counter",
             "Cascades whose waves the device was given, a new sea at a time.",
             counters.synthesis.cascades);
    text.one("device_seconds_total", "counter", "Time on the device.",
             counters.synthesis.device_seconds);
    text.one("keyframes_published_total", "counter", "Keyframes handed to the publisher.",
             counters.keyframes_published);
    text.one("keyframes_skipped_total", "counter", "Keyframes too late to be of use.",
             counters.keyframes_skipped);
    text.one("questions_total", "counter", "Queries and fetches taken.", counters.questions);
    text.one("questions_over_budget_total", "counter",
             "Queries and fetches refused: their session had asked for too much.",
             counters.questions_over_budget);
    text.one("device_rebuilds_total", "counter", "Times a failed device was rebuilt.",
             counters.device_rebuilds);
    text.one("keyframe_store_hits_total", "counter", "Keyframes found in the cache.",
             counters.store.hits);
    text.one("keyframe_store_misses_total", "counter", "Keyframes that had to be computed.",
             counters.store.misses);
    return text.take();
}

} // namespace seaway::server
