// SPDX-License-Identifier: Apache-2.0
#include "client/view/picture.h"

#include <algorithm>
#include <cmath>

namespace seaway::client {

namespace {

/// How bright a white sheet looks, of full daylight: eyes adapt to anything down to twilight, below that in
/// part, so that a moonlit night is a third of the day and a starlit one still tells sea from sky.
double adapted(double white_radiance) {
    constexpr double twilight = 1e-3; ///< kcd/m2
    constexpr double power = 0.4;
    return std::pow(std::min(white_radiance / twilight, 1.0), power);
}

double at_least_dark(double white_radiance) {
    return std::max(white_radiance, 1e-9);
}

} // namespace

ShownChannel shown_channel(const Display& display) {
    const DebugViewInfo& row = info(display.view);
    const int channel = std::max(display.colouring.channel, 0);
    const bool together = row.together && display.colouring.channel < 0;
    return {together ? -1 : channel,
            shown_scale(row.channels[static_cast<std::size_t>(channel)].scale, display.colouring,
                        display.significant_height_m, display.largest)};
}

double exposure_by_light(double white_radiance) {
    constexpr double white_sheet = 0.9;
    const double white = at_least_dark(white_radiance);
    return white_sheet * adapted(white) / white;
}

double metered_exposure(const Picture& picture, double white_radiance) {
    constexpr double middle_grey = 0.18;
    constexpr double range = 3;
    double logarithms = 0;
    std::size_t count = 0;
    for (std::size_t i = 0; i < picture.rgba.size(); i += 4) {
        const double luminance = 0.2126 * static_cast<double>(picture.rgba[i]) +
                                 0.7152 * static_cast<double>(picture.rgba[i + 1]) +
                                 0.0722 * static_cast<double>(picture.rgba[i + 2]);
        logarithms += std::log(std::clamp(luminance, 1e-9, std::max(white_radiance, 1e-9)));
        ++count;
    }
    const double mean = std::exp(logarithms / static_cast<double>(std::max<std::size_t>(count, 1)));
    const double by_light = exposure_by_light(white_radiance);
    return std::clamp(middle_grey * adapted(at_least_dark(white_radiance)) / mean, by_light / range,
                      by_light * range);
}

} // namespace seaway::client
