// SPDX-License-Identifier: Apache-2.0
#include "sea/scene/accuracy_presets.h"

namespace seaway::sea {

PresetAccuracy accuracy_of(AccuracyPreset preset) {
    // Four small tiles close to each other: each is asked only for waves that its grid shows well.
    const std::vector<CascadeSpec> small{{2111.0, 128}, {650.0, 128}, {150.0, 128}, {40.0, 128}};
    switch (preset) {
    case AccuracyPreset::precise:
        return {{{2111.0, 512}, {317.0, 512}, {53.0, 512}}, 0.001, true};
    case AccuracyPreset::balanced:
        return {{{2111.0, 256}, {317.0, 256}, {53.0, 256}}, 0.01, true};
    case AccuracyPreset::fast:
        return {small, 0.015, true};
    case AccuracyPreset::query_only:
        return {small, 0.015, false};
    }
    return {};
}

std::span<const AccuracyPreset> accuracy_presets() {
    static constexpr AccuracyPreset all[] = {AccuracyPreset::precise, AccuracyPreset::balanced,
                                             AccuracyPreset::fast, AccuracyPreset::query_only};
    return all;
}

} // namespace seaway::sea
