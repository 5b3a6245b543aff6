// SPDX-License-Identifier: Apache-2.0
#include "client/window/spectrum_curve.h"

#include <algorithm>

#include <fmt/format.h>

#include "sea/basics/constants.h"
#include "sea/scene/scene.h"
#include "sea/waves/statistics/moments.h"

namespace seaway::client {

Curve spectrum_curve(const std::string& scene_toml) {
    constexpr int points = 200;
    Curve curve;
    const Result<sea::Scene> scene = sea::parse_scene(scene_toml, "the server's scene");
    if (!scene) {
        curve.caption = scene.error().message;
        return curve;
    }
    std::size_t highest = 0;
    for (int i = 0; i <= points; ++i) {
        const double omega_radps = 2 * sea::pi * frequency_max_hz * i / points;
        const double density = // m2/Hz of m2 s/rad
            2 * sea::pi * sea::requested_frequency_density(scene->sea, omega_radps);
        curve.values.push_back(static_cast<float>(density));
        if (curve.values.back() > curve.values[highest])
            highest = curve.values.size() - 1;
    }
    curve.most = curve.values[highest];
    if (curve.most <= 0) {
        curve.values.clear();
        curve.caption = "waves of this scene have no spectrum";
        return curve;
    }
    curve.caption =
        fmt::format("S(f), requested: most {:.1f} m2/Hz at {:.3f} Hz, to {} Hz", curve.most,
                    frequency_max_hz * static_cast<double>(highest) / points, frequency_max_hz);
    return curve;
}

} // namespace seaway::client
