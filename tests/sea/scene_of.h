// SPDX-License-Identifier: Apache-2.0
// A scene from its text, and what is said of one that is refused.
#pragma once

#include <string>

#include <gtest/gtest.h>

#include "sea/scene/scene.h"

namespace seaway::testing {

/// The empty scene, and a failure, if `text` is refused.
inline sea::Scene scene_of(const std::string& text) {
    const Result<sea::Scene> scene = sea::parse_scene(text, "s.toml", "");
    EXPECT_TRUE(scene) << (scene ? "" : scene.error().message);
    return scene ? *scene : sea::Scene{};
}

/// "no error" if it is taken.
inline std::string error_of(const std::string& text) {
    const Result<sea::Scene> scene = sea::parse_scene(text, "s.toml", "");
    return scene ? "no error" : scene.error().message;
}

} // namespace seaway::testing
