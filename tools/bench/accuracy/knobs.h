// SPDX-License-Identifier: Apache-2.0
// What is tried: every knob by itself, from a configuration in which nothing else costs much; some knobs
// in combination; presets and baselines.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sea/scene/scene.h"
#include "tools/bench/accuracy/measure/batches.h"
#include "tools/bench/accuracy/measure/measure.h"
#include "tools/bench/accuracy/seas/configuration.h"

namespace seaway::bench {

enum class Measurement { answers, layout, transform, batch };

struct Trial {
    std::string value; ///< "curve@x" where it is a point of a curve, else a name
    Configuration configuration;
    Measurement measurement = Measurement::answers;
    Extent extent = {};
    Batch batch = {}; ///< of Measurement::batch
};

struct Knob {
    std::string_view name;
    std::string_view number; ///< "K8", as in docs/accuracy.md; "" for combinations
    std::vector<Trial> (*trials)(const sea::Scene& scene, const std::string& device);
    bool fresh_seeds = false; ///< measured on every seed of a run, not on the first alone
};

/// In the order in which they run.
std::span<const Knob> knobs();

} // namespace seaway::bench
