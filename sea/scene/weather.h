// SPDX-License-Identifier: Apache-2.0
// Scenes that follow from scenes: values set in one, and its timetable of such changes ([[weather]] of a scene file).
//
// What may change while a sea runs is the sea itself: its systems, its depth, its choppiness, its water, its foam but
// for the decay. Tiles, effects, accuracy and the loop stay, for they are what keyframes and clients are made for.
// Pure; thread-safe.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/toml_edit.h"
#include "sea/basics/time.h"
#include "sea/scene/scene.h"

namespace seaway::sea {

/// The scene with these values, set in its effective text ("sea.system.0.from_deg"; "systems.0.from_deg" is the same),
/// without the timetable. An error names the value by its path (tables counted from 0 as there), or what may not change, and no line.
Result<Scene> changed(const Scene& scene, std::span<const TomlAssignment> values);

/// Whether a sea can glide from one of these scenes to the other; an error names the first key that stands against it.
Result<void> check_glide(const Scene& from, const Scene& to);

/// The scenes that the timetable leads to, one a row, each from the one before. An error names the row.
Result<std::vector<Scene>> weather_scenes(const Scene& scene);

/// The scene that the rows which have begun by `time_us` lead to, with those to come as its timetable. Errors as weather_scenes().
Result<Scene> weather_by(const Scene& scene, TimeUs time_us);

} // namespace seaway::sea
