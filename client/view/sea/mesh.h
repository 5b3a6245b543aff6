// SPDX-License-Identifier: Apache-2.0
// The mesh of the sea: a fan of rows and columns over what the camera can see, to beyond the
// horizon. Cells grow with distance so that each is a few pixels wide; shaders/view/mesh.comp
// computes the vertices from rows, columns and apex.
//
// Made of the camera and of what is constant in a sea state, so that nothing swims under a camera that stands
// still. The fan's apex lies behind the camera so far that points which are moved sideways into the
// picture are in it; looking straight down it is the camera's foot, and the fan is closed. Pure; thread-safe.
#pragma once

#include <cstdint>
#include <vector>

#include "client/view/camera.h"
#include "client/view/sea/sea_frame.h"

namespace seaway::client {

struct Mesh {
    glm::dvec2 apex_m{0.0}; ///< local
    double azimuth_rad = 0; ///< of column 0, counter-clockwise from east
    double step_rad = 0;
    int columns = 0;           ///< 0: no sea is in the picture
    std::vector<float> rows_m; ///< distance from the apex, growing

    static constexpr int columns_max = 4096;
    static constexpr int rows_max = 8192;
    static constexpr std::size_t vertices_max =
        4'000'000; ///< cells are larger where there were more
    std::size_t vertices() const { return rows_m.size() * static_cast<std::size_t>(columns); }
};

/// `cell_pixels`: side of a far cell, about; near ones are not smaller than half the finest grid's. under: the eye is under
/// water and sees the surface from below, a few hundred metres of it.
Mesh build_mesh(const Camera& camera, const SeaFrame& sea, double cell_pixels, bool under = false);

/// Triangles of `rows` neighbouring rows of cells, as vertex numbers from the first of them, in blocks of columns: a
/// vertex that is used again is still in the cache.
std::vector<std::uint32_t> strip_indices(int columns, int rows);

struct IndexRange {
    std::uint32_t first, count;
};
/// Where in strip_indices(columns, rows) the first `used` rows of cells stand: rows come first within a block of columns.
std::vector<IndexRange> strip_ranges(int columns, int rows, int used);

} // namespace seaway::client
