// SPDX-License-Identifier: Apache-2.0
// Text as strokes. Used by Canvas::text.
#pragma once

#include <string_view>
#include <vector>

#include "tools/plot/canvas.h"

namespace seaway::plot {

/// Strokes of a text whose base line starts at (0, 0): x right, y up, in units of a tenth of the
/// capital height.
struct Lettering {
    std::vector<std::vector<Point>> strokes;
    double width = 0;
};

Lettering letter(std::string_view text);

} // namespace seaway::plot
