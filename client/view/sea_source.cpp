// SPDX-License-Identifier: Apache-2.0
#include "client/view/sea_source.h"

#include <fmt/format.h>

#include "client/failure.h"
#include "sea/scene.h"
#include "shaders/shared/view.h"

namespace seaway::client {

namespace {

/// What a spline needs; displacements come with it where the server offers them.
constexpr sea::FieldSet needed_fields{sea::Field::height, sea::Field::height_rate};

} // namespace

Result<SeaFrame> sea_frame_at(Client& client, sea::TimeUs time_us, double timeout_s) {
    if (Result<void> held = client.hold({&time_us, 1}, timeout_s); !held)
        return held.error();
    const SeaStatePtr state = client.sea_state(time_us);
    if (state->cascades.size() > shaders::view_cascades_max)
        return failed(Failure::refused,
                      fmt::format("this sea has {} cascades; up to {} can be drawn",
                                  state->cascades.size(), shaders::view_cascades_max));
    SeaFrame frame;
    frame.time_us = time_us;
    frame.choppiness = {state->choppiness_x, state->choppiness_y};
    if (const Result<sea::Scene> scene = sea::parse_scene(state->scene, "scene of the server", "."))
        frame.foam_threshold = scene->foam.threshold;
    for (std::size_t c = 0; c < state->cascades.size(); ++c) {
        const protocol::CascadeInfo& cascade = state->cascades[c];
        const std::optional<KeyframePair> pair = client.ring().around(
            static_cast<int>(c), state->epoch, time_us, cascade.interval_us, needed_fields);
        if (!pair || !pair->covers)
            return failed(Failure::not_held, fmt::format("no keyframes of cascade {} around {} s",
                                                         c, sea::seconds_from_us(time_us)));
        frame.cascades.push_back({{cascade.length_m, cascade.size},
                                  {cascade.k_lo_radpm, cascade.k_hi_radpm},
                                  {pair->before->spline(), pair->after->spline()}});
    }
    return frame;
}

} // namespace seaway::client
