// SPDX-License-Identifier: Apache-2.0
// The mesh of the sea: a fan of rows and columns over what the camera can see, to beyond the
// horizon. Cells grow with distance so that each is a few pixels wide; the shader computes the
// vertices from rows, columns and apex (shaders/view/sea.vert).
//
// The fan's apex lies behind the camera so far that points which are moved sideways into the
// picture are in it. Pure; thread-safe.
#pragma once

#include <vector>

#include "client/view/camera.h"
#include "client/view/sea_maps.h"

namespace seaway::client {

struct Mesh {
    glm::dvec2 apex_m{0.0}; ///< local
    double azimuth_rad = 0; ///< of column 0, counter-clockwise from east
    double step_rad = 0;
    int columns = 0;
    std::vector<float> rows_m; ///< distance from the apex, growing

    static constexpr int columns_max = 4096;
    static constexpr int rows_max = 8192;
};

/// `cell_pixels`: side of a far cell, about; near ones are `finest_m` at least.
Mesh build_mesh(const Camera& camera, const SeaStatistics& sea, double finest_m,
                double cell_pixels);

/// Triangles of `rows` neighbouring rows of cells, as vertex numbers from the first of them.
std::vector<std::uint32_t> strip_indices(int columns, int rows);

} // namespace seaway::client
