// SPDX-License-Identifier: Apache-2.0
#include "client/view/debug/colours.h"

#include <algorithm>
#include <cmath>

namespace seaway::client {

namespace {

constexpr double least_height_m = 2e-3; ///< a flat sea has a scale, too
constexpr double least_largest = 1e-12;

double factor_of(ScaleOf of, double significant_height_m, double largest) {
    switch (of) {
    case ScaleOf::significant_height:
        return std::max(significant_height_m, least_height_m);
    case ScaleOf::largest:
        return std::max(largest, least_largest);
    case ScaleOf::itself:
        break;
    }
    return 1;
}

} // namespace

ShownScale shown_scale(const Scale& scale, const Colouring& colouring, double significant_height_m,
                       double largest) {
    const double factor = factor_of(scale.of, significant_height_m, largest);
    ShownScale shown{*scale.palette, factor * scale.low, factor * scale.high, scale.spacing,
                     colouring.flip};
    shown.low = shown.low / colouring.gain - colouring.bias;
    shown.high = shown.high / colouring.gain - colouring.bias;
    return shown;
}

double ShownScale::place(double number) const {
    const double share = (number - low) / (high - low);
    double at = share;
    if (spacing == Spacing::logarithmic)
        at = number > 0 ? std::log(number / low) / std::log(high / low) : 0;
    else if (spacing == Spacing::root)
        at = std::sqrt(std::max(share, 0.0));
    else if (spacing == Spacing::repeated)
        at = share - std::floor(share);
    at = std::clamp(at, 0.0, 1.0);
    return flip ? 1 - at : at;
}

double ShownScale::number(double place) const {
    const double at = flip ? 1 - place : place;
    switch (spacing) {
    case Spacing::logarithmic:
        return low * std::pow(high / low, at);
    case Spacing::root:
        return low + (high - low) * at * at;
    case Spacing::linear:
    case Spacing::repeated:
        break;
    }
    return low + (high - low) * at;
}

glm::dvec3 ShownScale::colour(double place) const {
    std::size_t i = 1;
    while (i + 1 < static_cast<std::size_t>(palette.count) && palette.stops[i].place < place)
        ++i;
    const Palette::Stop &before = palette.stops[i - 1], &after = palette.stops[i];
    const double t = std::clamp((place - before.place) / (after.place - before.place), 0.0, 1.0);
    return glm::mix(before.colour, after.colour, t);
}

} // namespace seaway::client
