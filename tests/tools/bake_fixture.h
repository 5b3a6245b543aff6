// SPDX-License-Identifier: Apache-2.0
// The scene that tests of seaway-bake bake, and the sea that it is.
#pragma once

#include <memory>
#include <string>

#include "sea/scene/scene.h"
#include "sea/waves/realize.h"
#include "sea/waves/reference.h"
#include "tests/support/folder.h"
#include "tests/support/program.h"
#include "tests/tools/exr_file.h"

namespace seaway::tests_of_bake {

inline const std::string scene_text = R"(
[sea]
seed = 5
choppiness = [1.2, 0.8]
[[sea.system]]
type = "wind"
spectrum = "jonswap"
wind_speed_10m_mps = 14.0
from_deg = 200
fetch_m = 80e3
spreading = "hasselmann"
[[cascade]]
length_m = 401.0
size = 256
[[cascade]]
length_m = 83.0
size = 256
[foam]
threshold = 0.7
)";

/// A scene with every cascade at 64.
inline sea::Scene small_scene() {
    sea::Scene scene = sea::parse_scene(scene_text, "bake.toml", ".").value();
    for (sea::CascadeSpec& cascade : scene.cascades)
        cascade.size = 64;
    return scene;
}

inline tests::Output run_bake(const std::string& arguments) {
    const std::string scene = tests::folder().write("bake.toml", scene_text);
    return tests::run_program("seaway-bake", scene + " " + arguments);
}

inline sea::DirectSum small_sea() {
    return sea::DirectSum(
        std::make_shared<const sea::Realization>(sea::realize(small_scene()).value()));
}

} // namespace seaway::tests_of_bake
