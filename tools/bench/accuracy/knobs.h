// SPDX-License-Identifier: Apache-2.0
// What is tried: every knob by itself, from a configuration in which nothing else costs much; some knobs
// in combination; presets and baselines.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sea/scene/scene.h"
#include "tools/bench/accuracy/configuration.h"
#include "tools/bench/accuracy/measure.h"

namespace seaway::bench {

enum class Measurement { answers, layout, transform };

struct Trial {
    std::string value; ///< "curve@x" where it is a point of a curve, else a name
    Configuration configuration;
    Measurement measurement = Measurement::answers;
    Extent extent = {};
};

struct Knob {
    std::string_view name;
    std::string_view number; ///< "K8", as in docs/accuracy.md; "" for combinations
    std::vector<Trial> (*trials)(const sea::Scene& scene, const std::string& device);
};

/// In the order in which they run.
std::span<const Knob> knobs();

} // namespace seaway::bench
