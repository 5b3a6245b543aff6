// SPDX-License-Identifier: Apache-2.0
#include "client/view/picture.h"

#include <algorithm>
#include <cmath>

#include <glm/glm.hpp>

namespace seaway::client {

namespace {

std::uint8_t byte_of(float value) {
    return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0f, 1.0f) * 255.0f));
}

float srgb(float linear) {
    linear = std::clamp(linear, 0.0f, 1.0f);
    return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1.0f / 2.4f) - 0.055f;
}

/// ACES reference rendering and sRGB output transform, the fit by Stephen Hill (BakingLab, MIT).
glm::vec3 film(const glm::vec3& linear) {
    const glm::mat3 into(0.59719f, 0.07600f, 0.02840f, 0.35458f, 0.90834f, 0.13383f, 0.04823f,
                         0.01566f, 0.83777f);
    const glm::mat3 out(1.60475f, -0.10208f, -0.00327f, -0.53108f, 1.10813f, -0.07276f, -0.07367f,
                        -0.00605f, 1.07602f);
    const glm::vec3 v = into * linear;
    const glm::vec3 curve =
        (v * (v + 0.0245786f) - 0.000090537f) / (v * (0.983729f * v + 0.4329510f) + 0.238081f);
    return out * curve;
}

glm::vec3 height_colour(float height_m, float scale_m) {
    const float t = std::clamp(height_m / scale_m, -1.0f, 1.0f);
    return t < 0 ? glm::mix(glm::vec3(1), glm::vec3(0.05f, 0.2f, 0.7f), -t)
                 : glm::mix(glm::vec3(1), glm::vec3(0.8f, 0.1f, 0.05f), t);
}

} // namespace

double metered_exposure(const Picture& picture, double white_radiance) {
    constexpr double middle_grey = 0.18;
    constexpr double white_sheet = 0.9; ///< a white sheet on the sea becomes this
    constexpr double range = 3;
    constexpr double darkest_white = 1e-4; ///< kcd/m2: below it the eye gives up
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
    const double by_light = white_sheet / std::max(white_radiance, darkest_white);
    return std::clamp(middle_grey / mean, by_light / range, by_light * range);
}

std::vector<std::uint8_t> to_srgb(const Picture& picture, const Display& display) {
    std::vector<std::uint8_t> bytes;
    bytes.reserve(picture.rgba.size() / 4 * 3);
    const ColourMap map = info(display.view).colours;
    const auto exposure = static_cast<float>(display.exposure);
    const auto scale = static_cast<float>(std::max(display.significant_height_m / 2, 1e-3));
    for (std::size_t i = 0; i < picture.rgba.size(); i += 4) {
        glm::vec3 v(picture.rgba[i], picture.rgba[i + 1], picture.rgba[i + 2]);
        switch (map) {
        case ColourMap::film:
            v = film(exposure * v);
            v = {srgb(v.r), srgb(v.g), srgb(v.b)};
            break;
        case ColourMap::height:
            v = height_colour(v.r, scale);
            break;
        case ColourMap::repeat:
            v = glm::fract(v / 10.0f);
            break;
        case ColourMap::signed_1:
            v = v * 0.5f + 0.5f;
            break;
        case ColourMap::unsigned_1:
            break;
        }
        for (int c = 0; c < 3; ++c)
            bytes.push_back(byte_of(v[c]));
    }
    return bytes;
}

} // namespace seaway::client
