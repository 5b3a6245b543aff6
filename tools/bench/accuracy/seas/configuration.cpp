// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/accuracy/seas/configuration.h"

#include <algorithm>
#include <utility>

namespace seaway::bench {

namespace {

/// What most engines do with a map: 16 bits a value, texture filtering, a few steps of the fixed point,
/// new maps every frame.
Configuration as_engines_do(std::vector<sea::CascadeSpec> cascades, std::vector<sea::Band> bands) {
    Configuration engine;
    engine.cascades = std::move(cascades);
    engine.bands = std::move(bands);
    engine.space = SpaceRule::bilinear;
    engine.time = TimeRule::every_frame;
    engine.format = MapFormat::f16;
    engine.codec_error_m = 0.0;
    engine.fixed_point_steps = 3;
    return engine;
}

} // namespace

Configuration balanced(const sea::Scene& scene) {
    Configuration configuration;
    configuration.cascades = scene.cascades;
    configuration.height_error_m = scene.accuracy.height_error_m;
    return configuration;
}

Configuration preset_configuration(sea::AccuracyPreset preset) {
    const sea::PresetAccuracy accuracy = accuracy_of(preset);
    Configuration configuration;
    configuration.cascades = accuracy.cascades;
    configuration.height_error_m = accuracy.height_error_m;
    if (!accuracy.streams)
        configuration.codec_error_m = 0.0;
    return configuration;
}

Configuration clean(const sea::Scene& scene) {
    Configuration configuration = balanced(scene);
    configuration.interval_us = 20'000;
    configuration.codec_error_m = 0.0;
    configuration.tolerance_m = 1e-6;
    return configuration;
}

std::vector<Named> named_configurations(const sea::Scene& scene) {
    std::vector<Named> named;
    for (const sea::AccuracyPreset preset : sea::accuracy_presets())
        named.push_back({std::string(name_of(preset)), preset_configuration(preset), true});
    Configuration all_modes = clean(scene);
    all_modes.evaluator = Evaluator::direct_sum;
    Configuration gerstner = all_modes;
    gerstner.modes_kept = 64;
    gerstner.fixed_point_steps = 3;
    // Split where the next tile holds six waves, or where the one before it ends if that is less.
    const sea::CascadeSpec popular[] = {{250.0, 256}, {17.0, 256}, {5.0, 256}};
    std::vector<sea::Band> bands;
    double start = 0.5 * popular[0].wavenumber_step_radpm();
    for (int c = 0; c < 3; ++c) {
        const double end = sea::band_end_share_of_nyquist * popular[c].nyquist_radpm();
        const double next =
            c < 2 ? sea::band_start_steps * popular[c + 1].wavenumber_step_radpm() : end;
        bands.push_back({start, std::min(end, next)});
        start = bands.back().k_hi_radpm;
    }
    named.push_back({"all modes summed", all_modes, false});
    named.push_back({"64 largest waves", gerstner, false});
    named.push_back({"one tile of 512", as_engines_do({{500.0, 512}}, {}), false});
    named.push_back(
        {"250/17/5 m of 256", as_engines_do({popular[0], popular[1], popular[2]}, bands), false});
    return named;
}

} // namespace seaway::bench
