// SPDX-License-Identifier: Apache-2.0
// One way to compute a sea: a point in the space of all knobs. A plain value. What no knob says is what
// Seaway does; the other values are what engines do instead, or what the choice costs.
//
// Knobs K1 .. K14 are those of docs/accuracy.md.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "sea/basics/cascade.h"
#include "sea/basics/time.h"
#include "sea/scene/scene.h"

namespace seaway::bench {

enum class SpaceRule { spline, bilinear };
enum class TimeRule { hermite, linear, hold, every_frame };
enum class MapFormat { f32, f16, snorm16 };
/// How a client takes maps (docs/protocol.md): as differences to what follows from earlier ones, which all of ours do, on the
/// smallest grids that carry their waves, or whole.
enum class Tiles { predicted, compact, whole };
enum class Evaluator { maps, direct_sum };
enum class PhaseRule { fixed_point, float64, float32 };

/// How often an engine that knows no keyframes makes its maps (TimeRule::every_frame).
inline constexpr double frames_per_s = 60.0;

struct Configuration {
    std::vector<sea::CascadeSpec> cascades; ///< K1 .. K4, longest tile first
    std::vector<sea::Band> bands;           ///< empty: assign_bands()
    double k_max_radpm =
        std::numeric_limits<double>::infinity(); ///< K1: shorter waves are left out
    int oversampling = 1;                        ///< K2: grid points for each that `cascades` says
    std::optional<double> choppiness;            ///< K13; none: the scene's
    double height_error_m = 0.01;                ///< the budget
    std::optional<sea::TimeUs> interval_us;      ///< K8; none: the budget's, cascade by cascade
    SpaceRule space = SpaceRule::spline;         ///< K2
    TimeRule time = TimeRule::hermite;           ///< K8
    MapFormat format = MapFormat::f32;           ///< K5
    std::optional<double> codec_error_m;  ///< K9; none: the budget's share; 0: maps are not coded
    Tiles tiles = Tiles::predicted;       ///< K9
    std::optional<int> fixed_point_steps; ///< K10; none: damped Newton and all sheets
    double tolerance_m = 1e-4;            ///< K10, of Newton
    PhaseRule phase = PhaseRule::fixed_point; ///< K7; other rules are summed, never mapped
    Evaluator evaluator = Evaluator::maps;    ///< K11
    int modes_kept = 0;                       ///< K11: the largest; 0: all
    double latency_s = 0.0;                   ///< K14: answers are of this long ago
    std::string device = "native";            ///< as --device
    bool any_device_kernels = false;          ///< design W of a Vulkan device
};

/// What the scene says, streamed as tiles. Of sea_states.h: the balanced preset.
Configuration balanced(const sea::Scene& scene);

/// As the server would run it.
Configuration preset_configuration(sea::AccuracyPreset preset);

/// The same cascades with every other source of error turned down: what one knob costs by itself is
/// measured from here.
Configuration clean(const sea::Scene& scene);

/// Named points of the work-precision plot: presets of ours and what else is done.
struct Named {
    std::string name;
    Configuration configuration;
    bool preset; ///< ours; else a baseline
};
std::vector<Named> named_configurations(const sea::Scene& scene);

} // namespace seaway::bench
