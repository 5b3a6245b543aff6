// SPDX-License-Identifier: Apache-2.0
#include "local/local_sea.h"

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "sea/scene/scene_names.h"
#include "server/simulation/schedule.h"
#include "shaders/shared/view.h"

namespace seaway::local {

namespace {

using client::CascadeFrame;
using client::StandingKeyframePtr;

/// What the renderer reads of a sea.
sea::FieldSet drawn_of(const server::RunningSea& sea) {
    return client::drawn_fields & sea.offered;
}

/// What of a scene a server alone can do; empty: nothing.
std::string needs_a_server(const sea::Scene& scene, const sea::Realization& waves) {
    if (!scene.accuracy.streams())
        return "its accuracy is for questions alone, and has no maps to draw";
    if (!scene.weather.empty())
        return "it has a timetable ([[weather]]): seas that change are a server's";
    if (waves.cascades.size() > shaders::view_cascades_max)
        return fmt::format("it has {} cascades; up to {} can be drawn", waves.cascades.size(),
                           shaders::view_cascades_max);
    if (std::ranges::any_of(waves.cascades, [](const auto& c) { return !c.sines.empty(); }))
        return "stylised sines are added by the processor, point by point: they are a server's";
    return "";
}

/// Bytes that the maps of one size may take: those of two frames that the renderer has, of the one that a window is about,
/// and of the next; and the strains that the foam of one keyframe is made of meanwhile.
std::size_t map_bytes(const server::RunningSea& sea) {
    constexpr std::size_t frames = 4, keyframes = 2;
    const auto maps = static_cast<std::size_t>(drawn_of(sea).size());
    const auto strains = static_cast<std::size_t>(sea::foam_inputs.size());
    std::map<int, std::size_t> cascades;
    for (const sea::CascadeModes& cascade : sea.realization->cascades)
        ++cascades[cascade.spec.size];
    std::size_t most = 0;
    for (const auto& [size, count] : cascades)
        most = std::max(most, (count * frames * keyframes * maps + strains) * sizeof(float) *
                                  static_cast<std::size_t>(size) * static_cast<std::size_t>(size));
    return most;
}

/// What a server would say of this sea, as far as it is shown.
client::SeaStatePtr state_of(const server::RunningSea& sea) {
    auto state = std::make_shared<client::SeaState>();
    state->epoch = sea.epoch;
    const auto numbers = [](const sea::SeaStatistics& of) {
        return protocol::SeaNumbers{of.significant_height_m,   of.peak_period_s,
                                    of.zero_crossing_period_s, of.mean_period_s,
                                    sea::mean_from_deg(of),    of.spread_rad * 180 / sea::pi,
                                    of.mean_square_slope};
    };
    state->requested = numbers(sea.summary.requested);
    state->realised = numbers(sea.summary.realised);
    state->height_error_m = sea.budget.height_error_m;
    for (std::size_t c = 0; c < sea.realization->cascades.size(); ++c) {
        const sea::CascadeModes& modes = sea.realization->cascades[c];
        state->cascades.push_back({modes.spec.length_m, modes.spec.size, modes.longest_radpm(),
                                   modes.band.k_hi_radpm, !modes.carries_spectra,
                                   sea.budget.cascades[c].interval_us});
    }
    state->displacement_reach_m = sea.budget.displacement_reach_m;
    state->rms_strain = sea.budget.rms_strain;
    state->scene =
        sea::to_toml(sea.foam_law ? sea::with_threshold(sea.scene, *sea.foam_law) : sea.scene);
    state->warnings = server::warnings_of(sea);
    return state;
}

StandingKeyframePtr standing(const server::StandingKeyframe& made) {
    return std::make_shared<const client::StandingKeyframe>(client::StandingKeyframe{
        made.time_us, made.size, made.fields, made.maps, made.first_texel, made.keeper});
}

} // namespace

Result<server::RunningSeaPtr> read_local_scene(const std::string& path) {
    SEAWAY_TRY_LET(const sea::Scene scene, sea::read_scene(path));
    SEAWAY_TRY_LET(server::RunningSeaPtr sea, server::make_running_sea(scene, 1));
    if (const std::string why = needs_a_server(scene, *sea->realization); !why.empty())
        return Error{fmt::format("--scene {}: {}", path, why)};
    return sea;
}

Result<std::unique_ptr<LocalSea>> LocalSea::create(server::RunningSeaPtr sea,
                                                   std::shared_ptr<gpu::Device> device) {
    SEAWAY_TRY_LET(
        std::unique_ptr<server::VulkanSynthesizer> synthesizer,
        server::make_vulkan_synthesizer(std::move(device), {.tuning = server::usual_tuning(),
                                                            .held_map_bytes = map_bytes(*sea),
                                                            .maps_stay = true}));
    SEAWAY_TRY(synthesizer->set_sea(sea->realization, sea->epoch));
    return std::unique_ptr<LocalSea>(new LocalSea(std::move(sea), std::move(synthesizer)));
}

LocalSea::LocalSea(server::RunningSeaPtr sea, std::unique_ptr<server::VulkanSynthesizer> device)
    : sea_(std::move(sea)), state_(state_of(*sea_)),
      waves_(std::make_shared<const client::RebuiltSea>(sea_->realization, *state_,
                                                        client::RebuiltError{})),
      device_(std::move(device)), fields_(drawn_of(*sea_)), foam_(server::steady_course(sea_)),
      held_(sea_->realization->cascades.size()) {}

Result<void> LocalSea::make(const std::vector<Wanted>& wanted) {
    std::vector<server::FoamTurn> turns(wanted.size());
    std::vector<server::KeyframeRequest> requests;
    const auto made = [&]() -> Result<std::vector<server::StandingKeyframe>> {
        for (std::size_t i = 0; i < wanted.size(); ++i) {
            const auto cascade = static_cast<int>(wanted[i].cascade);
            requests.push_back({cascade, wanted[i].time_us, fields_});
            if (!fields_.contains(sea::Field::foam))
                continue;
            SEAWAY_TRY(foam_.walk_near(*device_, cascade, wanted[i].time_us,
                                       std::numeric_limits<int>::max()));
            SEAWAY_TRY_LET(turns[i], foam_.turn(*device_, cascade, wanted[i].time_us));
            requests.back().foam = &turns[i];
        }
        return device_->synthesize_there(requests);
    }();
    if (!made) {
        for (const server::KeyframeRequest& request : requests)
            if (request.foam != nullptr)
                foam_.restart(request.cascade);
        return made.error();
    }
    for (std::size_t i = 0; i < wanted.size(); ++i)
        *wanted[i].to = standing((*made)[i]);
    return {};
}

Result<client::SeaFrame> LocalSea::at(sea::TimeUs time_us) {
    std::vector<CascadeFrame::Standing> around(held_.size());
    std::vector<Wanted> before, after;
    for (std::size_t c = 0; c < held_.size(); ++c) {
        const sea::TimeUs interval_us = sea_->budget.cascades[c].interval_us;
        const sea::TimeUs before_us = server::interval_start(time_us, interval_us);
        const auto want = [&](sea::TimeUs keyframe_us, StandingKeyframePtr& to,
                              std::vector<Wanted>& missing) {
            for (const StandingKeyframePtr& held : {held_[c].before, held_[c].after})
                if (held && held->time_us == keyframe_us)
                    to = held;
            if (!to)
                missing.push_back({c, keyframe_us, &to});
        };
        want(before_us, around[c].before, before);
        want(before_us + interval_us, around[c].after, after);
    }
    held_.assign(held_.size(), {});                             // what is not needed makes room
    for (const std::vector<Wanted>* wanted : {&before, &after}) // foam goes on in time
        if (!wanted->empty())
            SEAWAY_TRY(make(*wanted));
    held_ = around;

    client::SeaFrame frame;
    frame.time_us = time_us;
    frame.choppiness = sea_->realization->choppiness;
    frame.significant_height_m = state_->realised.hs_m;
    frame.mean_from_deg = state_->realised.mean_from_deg;
    frame.reach_m = state_->displacement_reach_m;
    if (sea_->foam_law) {
        frame.foam_threshold = sea_->foam_law->threshold;
        frame.foam_mean = sea_->foam_law->mean_coverage;
    }
    frame.depth_m = sea_->scene.sea.depth_m;
    frame.water = sea_->scene.water;
    frame.error = sea::map_error(sea_->budget, 0);
    frame.water_m = [waves = waves_, time_us](double x_m, double y_m) {
        const sea::QueryPoint point{x_m, y_m, time_us};
        sea::Answer answer;
        waves->answer({&point, 1}, {&answer, 1}, {});
        return answer.height_m;
    };
    for (std::size_t c = 0; c < held_.size(); ++c) {
        const sea::CascadeModes& modes = sea_->realization->cascades[c];
        CascadeFrame cascade{.spec = modes.spec,
                             .band = {modes.longest_radpm(), modes.band.k_hi_radpm}};
        cascade.standing = held_[c];
        frame.cascades.push_back(std::move(cascade));
    }
    return frame;
}

} // namespace seaway::local
