// SPDX-License-Identifier: Apache-2.0
// How a view's numbers become colours: a palette, stretched between two numbers. The shader that colours pictures
// (shaders/view/numbers.frag) is given the same stops, so that a legend's bar and the picture agree.
//
// Plain values; thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include <glm/glm.hpp>

#include "shaders/shared/view.h"

namespace seaway::client {

/// Colours along a bar, sRGB 0 .. 1, from place 0 to place 1.
struct Palette {
    struct Stop {
        double place;
        glm::dvec3 colour;
    };
    int count = 0;
    std::array<Stop, shaders::view_stops> stops{};
};

inline const Palette grey_palette{2, {{{0, {0, 0, 0}}, {1, {1, 1, 1}}}}};
/// Blue, white, red.
inline const Palette signed_palette{
    3, {{{0, {0.05, 0.2, 0.7}}, {0.5, {1, 1, 1}}, {1, {0.8, 0.1, 0.05}}}}};
/// Black, red, orange, yellow, white.
inline const Palette heat_palette{6,
                                  {{{0, {0, 0, 0}},
                                    {0.2, {0.6, 0, 0}},
                                    {1.0 / 3, {1, 0.2, 0}},
                                    {0.5, {1, 0.45, 0}},
                                    {0.8667, {1, 1, 0.3667}},
                                    {1, {1, 1, 1}}}}};
/// Dark violet, blue, green, yellow: as bright as the number is large (after viridis, van der Walt and Smith 2015).
inline const Palette even_palette{5,
                                  {{{0, {0.267, 0.005, 0.329}},
                                    {0.25, {0.229, 0.322, 0.545}},
                                    {0.5, {0.128, 0.567, 0.551}},
                                    {0.75, {0.369, 0.789, 0.383}},
                                    {1, {0.993, 0.906, 0.144}}}}};
/// Of angles: ends as it begins.
inline const Palette cyclic_palette{7,
                                    {{{0, {0.9, 0.1, 0.1}},
                                      {1.0 / 6, {0.9, 0.9, 0.1}},
                                      {2.0 / 6, {0.1, 0.8, 0.1}},
                                      {3.0 / 6, {0.1, 0.8, 0.8}},
                                      {4.0 / 6, {0.15, 0.25, 0.9}},
                                      {5.0 / 6, {0.8, 0.1, 0.8}},
                                      {1, {0.9, 0.1, 0.1}}}}};

/// What folds, whatever its number; and where there is no number: sky in a view of the sea, the rim of a map.
inline const glm::dvec3 fold_colour(0.9, 0.05, 0.1);
inline const glm::dvec3 empty_colour(0.13, 0.14, 0.17);

/// How numbers lie along a bar.
enum class Spacing : int {
    linear = shaders::view_spacing_linear,
    logarithmic = shaders::view_spacing_logarithmic,
    root = shaders::view_spacing_root,        ///< the square root of the share: as eyes see light
    repeated = shaders::view_spacing_repeated ///< the bar over and over again
};

/// What a scale's ends are multiplied by.
enum class ScaleOf : int {
    itself,
    significant_height, ///< of the sea, m
    largest             ///< of what is shown, as who makes the numbers says
};

/// Numbers from one end of a bar to the other.
struct Scale {
    const Palette* palette = &grey_palette;
    double low = 0, high = 1;
    Spacing spacing = Spacing::linear;
    ScaleOf of = ScaleOf::itself;
};

/// What the user changes of a view's colours.
struct Colouring {
    static constexpr int all_channels =
        -1; ///< as the view shows them: one, or three as red, green, blue
    int channel = all_channels;
    double gain = 1;   ///< a number is shown as gain * (number + bias)
    double bias = 0;   ///< in the number's unit; not of logarithmic scales
    bool flip = false; ///< the bar the other way round
    bool operator==(const Colouring&) const = default;

    static constexpr double gain_min = 1e-6, gain_max = 1e6, bias_max = 1e6;
};

/// A scale with its ends worked out.
struct ShownScale {
    Palette palette;
    double low = 0, high = 1;
    Spacing spacing = Spacing::linear;
    bool flip = false;

    /// Place on the bar, 0 .. 1.
    double place(double number) const;
    /// The number at a place.
    double number(double place) const;
    /// sRGB, 0 .. 1.
    glm::dvec3 colour(double place) const;
};

ShownScale shown_scale(const Scale& scale, const Colouring& colouring, double significant_height_m,
                       double largest);

} // namespace seaway::client
