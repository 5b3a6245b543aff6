// SPDX-License-Identifier: Apache-2.0
// The views of the sea that --debug can show: one table row each.
#pragma once

#include <array>
#include <string_view>

#include "base/result.h"
#include "shaders/shared/view.h"

namespace seaway::client {

enum class DebugView : int {
    final = shaders::view_final,
    height = shaders::view_height,
    place = shaders::view_place,
    normal = shaders::view_normal,
    slope = shaders::view_slope,
    jacobian = shaders::view_jacobian,
    roughness = shaders::view_roughness,
    foam = shaders::view_foam,
    cascade = shaders::view_cascade,
    grid = shaders::view_grid
};

/// How a view's numbers become colours in a PNG; an EXR holds the numbers themselves.
enum class ColourMap : int {
    film = shaders::view_colours_film,             ///< exposure and film curve
    height = shaders::view_colours_height,         ///< blue, white, red: -Hs/2 .. Hs/2
    repeat = shaders::view_colours_repeat,         ///< fraction of 10 m, each channel
    signed_1 = shaders::view_colours_signed_1,     ///< -1 .. 1 to 0 .. 1, each channel
    unsigned_1 = shaders::view_colours_unsigned_1, ///< as it is, 0 .. 1
    jacobian = shaders::view_colours_jacobian,     ///< 0 .. 2 in grey; below 0, where it folds, red
    roughness = shaders::view_colours_roughness    ///< black, orange, white: 0 .. 0.4
};

struct DebugViewInfo {
    DebugView view;
    std::string_view name;
    ColourMap colours;
    std::string_view meaning; ///< channels and units of the numbers
};

inline constexpr std::array<DebugViewInfo, 10> debug_view_table{{
    {DebugView::final, "final", ColourMap::film, "the picture; EXR: radiance, kcd/m2"},
    {DebugView::height, "height", ColourMap::height, "height above the mean sea, m"},
    {DebugView::place, "place", ColourMap::repeat,
     "undisplaced place, m east and north of the camera; height above the mean sea, m"},
    {DebugView::normal, "normal", ColourMap::signed_1, "unit normal, filtered over the pixel"},
    {DebugView::slope, "slope", ColourMap::signed_1, "slope of the surface, east and north"},
    {DebugView::jacobian, "jacobian", ColourMap::jacobian,
     "determinant of the summed gradients; below 0 the surface folds"},
    {DebugView::roughness, "roughness", ColourMap::roughness,
     "rms slope of the waves that the pixel does not resolve"},
    {DebugView::foam, "foam", ColourMap::unsigned_1, "share of the pixel that is white"},
    {DebugView::cascade, "cascade", ColourMap::signed_1,
     "slopes of one cascade alone: cascade:0 is the longest tile"},
    {DebugView::grid, "grid", ColourMap::unsigned_1, "every 16th row and column of the mesh"},
}};

inline constexpr const DebugViewInfo& info(DebugView view) {
    return debug_view_table[static_cast<std::size_t>(view)];
}

struct DebugChoice {
    DebugView view = DebugView::final;
    int cascade = 0;
};

/// "normal", "cascade:2". The error lists the names.
Result<DebugChoice> parse_debug_view(std::string_view text);

} // namespace seaway::client
