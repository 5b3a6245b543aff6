// SPDX-License-Identifier: Apache-2.0
// SkyView: what the air shows an eye at a height, lit by the sun at its full strength: kcd/m2, linear sRGB.
//
// A Dome of 192 columns for half a turn (the other half is its mirror image) by 128 rows. Above the
// horizon it holds the radiance of the sky. Below it holds the source of the air's light on the way to
// the sea: radiance over 1 - transmittance, of each colour, so that
//     light from a point = its radiance T + source (1 - T)
// for every distance, T being what the air lets through (client/view/sky/air_between.h). That is the
// aerial perspective: exact for points of the sea, near it for what stands on it.
//
// Immutable; thread-safe. 42 ms of CPU, which threads share.
#pragma once

#include "client/view/sky/dome.h"
#include "client/view/sky/scattering.h"
#include "shaders/shared/view.h"

namespace seaway::client {

class SkyView {
  public:
    static constexpr int columns = shaders::sky_columns; ///< of the whole turn
    static constexpr int rows = shaders::sky_rows;
    /// Below this height the air's source hardly changes.
    static constexpr double height_min_m = 1;

    SkyView(const AirTables& tables, double height_m, const glm::dvec3& to_sun, ThreadPool& pool);

    double height_m() const { return height_m_; }
    /// The table: columns from the sun's azimuth.
    const Dome& dome() const { return dome_; }

  private:
    double height_m_;
    Dome dome_;
};

/// Heights that views are made for: each 4 % above the last, so that an eye that climbs is served by few
/// tables, and a height by the same one always.
double height_on_ladder_m(double height_m);

} // namespace seaway::client
