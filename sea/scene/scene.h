// SPDX-License-Identifier: Apache-2.0
// A scene: the sea, the tiles that carry it, what may be computed and how well. Read from TOML
// (docs/scenes.md lists every key, its unit and range).
//
// The reader is strict: an unknown key, a value of the wrong type or out of range, a missing file
// is an error with file, line, key, value and what is allowed. Degrees and "from" bearings exist
// only here; everything behind it is SI, radians and "towards". Pure functions; thread-safe.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "base/toml_edit.h"
#include "sea/basics/cascade.h"
#include "sea/basics/water_type.h"
#include "sea/scene/accuracy_presets.h"
#include "sea/waves/realize.h"
#include "sea/waves/sea_state.h"

namespace seaway::sea {

/// What the scene allows; demand decides what runs.
struct Effects {
    bool choppy = true; ///< horizontal displacement
    bool slopes = true;
    bool foam = true;
};

struct FoamModel {
    /// Jacobian below which a crest breaks, -1 .. 1. None: coverage = "observed", the threshold that
    /// whitens as much of this sea as whitecaps do at its wind (sea/foam/foam_law.h solves for it).
    std::optional<double> threshold = {};
    double decay_s = 4.0;    ///< 0 .. 1e6
    double gain_per_s = 3.0; ///< 0 .. 1000
    double bias = 0.0;       ///< 0 .. 1; what breaking at all adds to the shortfall
};

/// What was measured of a scene's accuracy, as the scene names it (sea/certificate/certificate.h).
struct CertificateFile {
    std::string name; ///< as it stands in the scene; empty: there is none
    std::string path; ///< beside the scene
};

struct Accuracy {
    double height_error_m = 0.01; ///< 1e-5 .. 1; shared by codec, keyframe interval and queries
    std::optional<AccuracyPreset> preset = {};
    CertificateFile certificate = {};

    /// Keyframes are offered to those who subscribe or fetch; else only answers.
    bool streams() const { return !preset || accuracy_of(*preset).streams; }
};

/// A row of the timetable: from `at_s` of sea time on, for `over_s`, the sea glides to the one with these values
/// (sea/scene/weather.h).
struct WeatherChange {
    double at_s = 0;    ///< -1e10 .. 1e10; not before the end of the row before
    double over_s = 60; ///< glide_us_min .. glide_us_max (sea/basics/glide.h), s
    std::vector<TomlAssignment> set;
    unsigned line = 0; ///< where that stands in the text it was read from; 0: in none
};

/// The folder of a text that came from somebody else, as to_toml() wrote it: it may name no file of a system.
inline constexpr std::string_view no_files = "/dev/null/";

struct Scene {
    std::string source; ///< path or name that errors and logs quote
    SeaState sea;
    std::vector<CascadeSpec> cascades; ///< longest tile first; 1 .. 8
    Effects effects;
    FoamModel foam;
    Water water; ///< for those who draw it; waves do not hang on it
    Accuracy accuracy;
    std::vector<WeatherChange> weather = {}; ///< in order of time
    std::string folder{no_files}; ///< where files that its timetable names are looked for
};

inline constexpr int scene_systems_max = 16;
inline constexpr int scene_cascades_max = 8;
inline constexpr int scene_weather_max = 64;
/// Of a scene file, of a table, and of the effective scene with its tables in it.
inline constexpr std::size_t scene_text_bytes_max = 1u << 20;

/// Reads a scene file; files that it names are relative to its folder.
Result<Scene> read_scene(const std::string& path);

/// `name` is quoted in errors; `base_dir` is where files that the text names are looked for. Who does not say where gets a text
/// that may name none.
Result<Scene> parse_scene(std::string_view text, const std::string& name,
                          const std::string& base_dir = std::string(no_files));

/// The effective scene as TOML, every value written out; parsing it gives the same sea, bit for
/// bit.
std::string to_toml(const Scene& scene);

/// realize() of the scene's sea on the scene's cascades; without choppiness where the scene allows
/// no horizontal displacement. An error names the scene.
Result<Realization> realize(const Scene& scene);
/// Its tiles, frequencies and phases alone.
Result<Realization> realize_clocks(const Scene& scene);

} // namespace seaway::sea
