// SPDX-License-Identifier: Apache-2.0
// A small windy sea as a server announces it, with scene and probes.
#pragma once

#include <memory>

#include <gtest/gtest.h>

#include "protocol/messages.h"
#include "sea/scene/scene.h"
#include "sea/waves/probes.h"

namespace seaway::tests {

inline sea::Scene announced_scene() {
    constexpr const char* text = R"(
[sea]
seed = 7
depth_m = 30
[[sea.system]]
type = "wind"
spectrum = "jonswap"
wind_speed_10m_mps = 9.0
from_deg = 250
fetch_m = 40e3
spreading = "hasselmann"
[[cascade]]
length_m = 301.0
size = 64
[[cascade]]
length_m = 43.0
size = 64
)";
    const Result<sea::Scene> scene = sea::parse_scene(text, "announced", ".");
    EXPECT_TRUE(scene) << (scene ? "" : scene.error().message);
    return *scene;
}

inline sea::RealizationPtr announced_waves() {
    return std::make_shared<const sea::Realization>(*sea::realize(announced_scene()));
}

inline protocol::SeaStateValues announced() {
    const sea::RealizationPtr waves = announced_waves();
    protocol::SeaStateValues state;
    state.epoch = 1;
    for (const sea::CascadeModes& cascade : waves->cascades)
        state.cascades.push_back({.length_m = cascade.spec.length_m,
                                  .size = cascade.spec.size,
                                  .k_lo_radpm = cascade.band.k_lo_radpm,
                                  .k_hi_radpm = cascade.band.k_hi_radpm,
                                  .interval_us = 250'000});
    state.choppiness_x = waves->choppiness.x;
    state.choppiness_y = waves->choppiness.y;
    state.height_error_m = 0.01;
    state.rms_slope = 0.15;
    state.rms_strain = 0.15;
    state.displacement_reach_m = 10;
    state.depth_m = waves->cascades[0].depth_m;
    state.scene = sea::to_toml(announced_scene());
    state.probes = sea::make_probes(sea::DirectSum(waves), 0);
    state.probe_error_m = sea::probe_error_m;
    return state;
}

} // namespace seaway::tests
