// SPDX-License-Identifier: Apache-2.0
// Dome: values by direction, as tables of the sky and the shader (shaders/view/sky.glsl) hold them.
//
// Columns go around, counter-clockwise from an azimuth of its own (the sun's). Rows run from the nadir
// to the zenith and are dense at the horizon: the root of the angle from the horizon, of its whole range
// above and below (Hillaire 2020, section 5.3). The horizon is an edge: the middle two rows are the last
// of the sea and the first of the sky, and nothing is mixed across it.
//
// A value. Shader and C++ share this mapping.
#pragma once

#include <vector>

#include <glm/glm.hpp>

namespace seaway::client {

/// Where a direction lies in a dome.
struct DomePlace {
    double around;       ///< 0 .. 1, periodic
    double from_horizon; ///< root of the share of the range: -1 nadir .. 0 horizon .. 1 zenith
};

class Dome {
  public:
    Dome() = default;
    /// rows even. dip: of the horizon below the level.
    Dome(int columns, int rows, double azimuth_rad, double dip_rad);

    int columns() const { return columns_; }
    int rows() const { return rows_; }
    double azimuth_rad() const { return azimuth_rad_; }
    double dip_rad() const { return dip_rad_; }
    std::vector<glm::vec3>& texels() { return texels_; } ///< [row][column]
    const std::vector<glm::vec3>& texels() const { return texels_; }
    glm::vec3& at(int column, int row) {
        return texels_[static_cast<std::size_t>(row * columns_ + column)];
    }

    /// Unit direction of the middle of a texel.
    glm::dvec3 direction(int column, int row) const;
    /// Of a place on the picture, 0 .. 1 each: what lies between the middle rows is the horizon.
    glm::dvec3 direction_at(double across, double up) const;
    DomePlace place(const glm::dvec3& direction) const;
    /// Linear between texels.
    glm::dvec3 sample(const glm::dvec3& direction) const;
    glm::dvec3 sample(const DomePlace& place) const;

  private:
    int columns_ = 0, rows_ = 0;
    double azimuth_rad_ = 0, dip_rad_ = 0;
    std::vector<glm::vec3> texels_;
};

} // namespace seaway::client
