// SPDX-License-Identifier: Apache-2.0
// Legend: what a view shows, in the picture: bars of colour with their numbers and units, the view's name, what is set of it,
// the sea's time, and the ends of a flat map's sides. A list of boxes: files have them blended into their bytes, the
// window hands them to its panels. Never part of numbers (EXR).
//
// Plain values; thread-safe.
#pragma once

#include <string>
#include <vector>

#include "client/view/debug/flat.h"
#include "client/view/picture.h"

namespace seaway::client {

struct LegendBox {
    int left, top, width, height; ///< pixels
    glm::dvec3 colour;            ///< sRGB, 0 .. 1
    double opacity = 1;
};

/// A bar, of which colours can be read: from `left` to `left + width` its places run from 0 to 1.
struct LegendBar {
    int left, top, width, height;
    ShownScale scale;
    int channel; ///< 0, 1, 2: of this colour alone; below 0: in the palette's colours
};

/// Words as they stand, of dots so many pixels wide.
struct LegendWords {
    int left, top, dot;
    std::string text;
};

struct Legend {
    std::vector<LegendBox> boxes; ///< later ones lie on top
    std::vector<LegendBar> bars;  ///< among the boxes already, as
    std::vector<LegendWords> words;
};

/// What a legend says.
struct LegendText {
    DebugChoice choice;
    Display display;
    int cascade = -1; ///< that is shown; below 0: all
    int cascades = 0;
    double time_s = 0;              ///< of the sea
    std::vector<std::string> notes; ///< further lines
    /// Of a flat map: where it lies, and its sides.
    bool flat = false;
    FlatArea area{};
    std::string across{}, up{}; ///< what lies at the right edge, and at the upper one
    bool brief = false;         ///< bars and their numbers alone, beside a label
};

inline constexpr int legend_width_min = 200; ///< narrower pictures have none

/// Empty for narrow pictures, for the picture itself and where it is switched off.
Legend make_legend(const LegendText& text, int width, int height);
/// The name and what is set of a view, alone, in the upper left corner: for sheets of many.
Legend make_label(const std::string& text, int width);

void lay_over(ShownPicture& picture, const Legend& legend);

} // namespace seaway::client
