// SPDX-License-Identifier: Apache-2.0
// Camera: where the eye is and what it sees. A value; the place is in double precision, directions
// and matrices are relative to the point of the mean sea below it (shaders/shared/view.h).
#pragma once

#include <glm/glm.hpp>

#include "client/view/sky/atmosphere.h"

namespace seaway::client {

// What a camera may be.
inline constexpr double camera_place_max_m = 1e7; ///< |x|, |y|
inline constexpr double camera_height_min_m = -50, camera_height_max_m = 20e3;
inline constexpr double camera_yaw_max_deg = 36000; ///< either way, where one is asked for
inline constexpr double camera_pitch_max_deg = 89;  ///< either way
inline constexpr double camera_view_min_deg = 1, camera_view_max_deg = 150;

struct Camera {
    double x_m = 0;        ///< east
    double y_m = 0;        ///< north
    double z_m = 10;       ///< above the mean sea
    double yaw_deg = 0;    ///< bearing, clockwise from north: 0 north, 90 east
    double pitch_deg = -5; ///< up is positive, -89 .. 89
    double view_deg = 62;  ///< width of the picture
    int width = 960;       ///< pixels
    int height = 540;

    glm::dvec3 forward() const;
    /// Where forward() points, counter-clockwise from east.
    double azimuth_rad() const;
    /// Angle of a pixel in the middle of the picture.
    double pixel_rad() const;
    /// Local direction (not unit length) through a point of the picture, -1 .. 1, y down.
    glm::dvec3 ray(double picture_x, double picture_y) const;
    /// Reversed depth, infinitely far: 0 is at infinity. y points down on the picture.
    glm::dmat4 clip_from_local() const;
};

/// Angle by which the horizon lies below the level, rad: acos(R / (R + z)).
double horizon_dip_rad(double z_m);

} // namespace seaway::client
