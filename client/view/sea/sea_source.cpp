// SPDX-License-Identifier: Apache-2.0
#include "client/view/sea/sea_source.h"

#include <algorithm>

#include <fmt/format.h>

#include "client/link/failure.h"
#include "client/local_surface.h"
#include "shaders/shared/view.h"

namespace seaway::client {

namespace {

/// What a spline needs; displacements come with it where the server offers them.
constexpr sea::FieldSet needed_fields{sea::Field::height, sea::Field::height_rate};

Result<CascadeFrame> cascade_frame(const Client& client, const SeaState& state, std::size_t index,
                                   sea::TimeUs time_us, std::vector<KeyframePair>& pairs) {
    const protocol::CascadeInfo& cascade = state.cascades[index];
    const auto around = [&](sea::FieldSet fields) {
        return client.ring().around(static_cast<int>(index), state.epoch, time_us,
                                    cascade.interval_us, fields);
    };
    const std::optional<KeyframePair> pair = around(needed_fields);
    if (!pair || !pair->covers)
        return failed(Failure::not_held, fmt::format("no keyframes of cascade {} around {} s",
                                                     index, sea::seconds_from_us(time_us)));
    CascadeFrame frame{{cascade.length_m, cascade.size},
                       {cascade.k_lo_radpm, cascade.k_hi_radpm},
                       {pair->before->spline(), pair->after->spline()}};
    if (const auto foam = around(needed_fields | sea::FieldSet{sea::Field::foam});
        foam && foam->covers) {
        frame.foam_before = foam->before->keyframe_ptr();
        frame.foam_after = foam->after->keyframe_ptr();
    }
    pairs.push_back(*pair);
    return frame;
}

/// Six standard deviations; in deep water displacements are as large as heights. For a server that says none.
double reach_of(const SeaState& state) {
    constexpr double sigmas = 6;
    if (state.displacement_reach_m > 0)
        return state.displacement_reach_m;
    return sigmas / 4 * state.highest_hs_m(state.start_time_us) *
           std::max(state.choppiness_x, state.choppiness_y);
}

} // namespace

Result<SeaFrame> sea_frame_at(Client& client, sea::TimeUs time_us, double timeout_s) {
    SEAWAY_TRY(client.hold({&time_us, 1}, timeout_s, drawn_fields));
    return held_sea_frame(client, time_us);
}

Result<SeaFrame> held_sea_frame(const Client& client, sea::TimeUs time_us) {
    const int seas = client.seas();
    const SeaStatePtr state = client.sea_state(time_us);
    if (state->cascades.empty() || state->cascades.size() > shaders::view_cascades_max)
        return failed(Failure::refused,
                      fmt::format("this sea has {} cascades; 1 to {} can be drawn",
                                  state->cascades.size(), shaders::view_cascades_max));
    SeaFrame frame;
    frame.time_us = time_us;
    frame.choppiness = {state->choppiness_x_at(time_us), state->choppiness_y_at(time_us)};
    const protocol::SeaNumbers realised = state->realised_at(time_us);
    frame.significant_height_m = realised.hs_m;
    frame.reach_m = reach_of(*state);
    frame.mean_from_deg = realised.mean_from_deg;
    frame.foam_mean = state->foam_mean_at(time_us);
    frame.foam_threshold = state->foam_threshold_at(time_us);
    if (state->depth_m > 0)
        frame.depth_m = state->depth_m;
    frame.water = state->water;
    std::vector<KeyframePair> pairs;
    for (std::size_t c = 0; c < state->cascades.size(); ++c) {
        Result<CascadeFrame> cascade = cascade_frame(client, *state, c, time_us, pairs);
        if (!cascade)
            return cascade.error();
        frame.cascades.push_back(std::move(*cascade));
    }
    frame.error = local_map_error(*state, pairs);
    if (client.seas() != seas)
        return failed(Failure::not_held, "the sea has become another one");
    return frame;
}

} // namespace seaway::client
