// SPDX-License-Identifier: Apache-2.0
// Accuracies by a word: tiles, a budget, and whether keyframes are streamed. `accuracy.preset` of a
// scene takes one, the bench measures them all (docs/accuracy.md), and nothing else lists them.
//
// Constants; thread-safe.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "sea/basics/cascade.h"

namespace seaway::sea {

enum class AccuracyPreset : std::uint8_t { precise, balanced, fast, query_only };

constexpr std::string_view name_of(AccuracyPreset preset) {
    switch (preset) {
    case AccuracyPreset::precise:
        return "precise";
    case AccuracyPreset::balanced:
        return "balanced";
    case AccuracyPreset::fast:
        return "fast";
    case AccuracyPreset::query_only:
        return "query_only";
    }
    return "";
}

/// What a preset stands for.
struct PresetAccuracy {
    std::vector<CascadeSpec> cascades; ///< longest tile first
    double height_error_m;
    bool streams; ///< keyframes are offered; else the server answers questions alone
};

PresetAccuracy accuracy_of(AccuracyPreset preset);

/// All of them, the most accurate first.
std::span<const AccuracyPreset> accuracy_presets();

} // namespace seaway::sea
