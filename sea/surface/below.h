// SPDX-License-Identifier: Apache-2.0
// The water below the surface: velocity and dynamic pressure at a world point, by linear theory.
//
// The water at a world point (x, y, z) is taken to be that which lies below the surface's own water there: (X, Y) are those
// of the surface at (x, y), and the depth is stretched as Wheeler does,
//     z' = (z - eta) d / (d + eta),      z - eta in deep water,
// so that z' = 0 at the surface, where the motion is that of the surface's answer, and z' = -d at the sea floor, where water
// moves along it alone. (Wheeler 1970, "Method for calculating forces produced by irregular waves", J. Petroleum Technology.)
//
// Valid for a sea of waves that do not break, from the surface to the floor: the sum is of first order in steepness, what it
// leaves out is of second (with a k = 0.1 a tenth of a wave's velocity, less below). No bound is stated. Currents and the
// drift of second order are not in it. Stylised waves (sea/waves/sine_waves.h) have no water below them:
// what they move and press is missing, and the answer is flagged answer_vertical_velocity.
//
// Thread-safe. Cost: an exact answer and DirectSum::Moment::motion().
#pragma once

#include <optional>

#include "sea/surface/inverse.h"

namespace seaway::sea {

/// Wheeler's z'; nothing where there is no water: above the surface or below the floor. `depth_m` may be infinite.
std::optional<double> still_z_m(double z_m, double surface_m, double depth_m);

/// The surface above a point, as surface_at() has it, and the water at `z_m`, up from still water. Where there is none it
/// is still and the answer is flagged answer_dry. What is not finite makes answer and water NaN, answer_invalid. `area`: as there.
Answer water_at(const QueryPoint& point, double z_m, const InverseOptions& options,
                const DirectSum::Moment& moment, WaterBelow& water, double* area = nullptr);

} // namespace seaway::sea
