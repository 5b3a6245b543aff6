// SPDX-License-Identifier: Apache-2.0
// The sea at an undisplaced point (X, Y): what the exact sum, the sampler and the inverse
// displacement exchange. Displacements are at choppiness 1, as everywhere in maps (sea/basics/field.h).
#pragma once

namespace seaway::sea {

struct LagrangianPoint {
    double height = 0;              ///< eta, m
    double displacement_x = 0;      ///< D_x, m
    double displacement_y = 0;      ///< D_y, m
    double height_rate = 0;         ///< d eta / dt, m/s
    double displacement_x_rate = 0; ///< d D_x / dt, m/s
    double displacement_y_rate = 0; ///< d D_y / dt, m/s
    double slope_x = 0;             ///< d eta / dX
    double slope_y = 0;             ///< d eta / dY
    double strain_xx = 0;           ///< d D_x / dX
    double strain_yy = 0;           ///< d D_y / dY
    double strain_xy = 0;           ///< d D_x / dY = d D_y / dX
};

} // namespace seaway::sea
