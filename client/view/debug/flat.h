// SPDX-License-Identifier: Apache-2.0
// Where a flat map or table lies in a picture. Pure.
#pragma once

#include "client/view/debug_views.h"

namespace seaway::client {

/// Pixels; x right, y down.
struct FlatArea {
    int left = 0, top = 0, width = 1, height = 1;
};

/// In the middle, as large as fits, its texels square.
FlatArea flat_area(int columns, int rows, int width, int height);

} // namespace seaway::client
