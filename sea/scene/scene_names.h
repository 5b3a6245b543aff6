// SPDX-License-Identifier: Apache-2.0
// Words and bearings of scene files: shared by the reader and the writer.
#pragma once

#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include "sea/basics/constants.h"
#include "sea/spectrum/spreading.h"
#include "sea/waves/sine_waves.h"

namespace seaway::sea {

inline constexpr std::array<std::pair<std::string_view, SpreadingKind>, 5> spreading_names{
    {{"cos2", SpreadingKind::cos2},
     {"cos2s", SpreadingKind::cos2s},
     {"mitsuyasu", SpreadingKind::mitsuyasu},
     {"hasselmann", SpreadingKind::hasselmann},
     {"donelan_banner", SpreadingKind::donelan_banner}}};

inline constexpr std::array<std::pair<std::string_view, SineKind>, 3> sine_names{
    {{"sine", SineKind::sine},
     {"gerstner", SineKind::gerstner},
     {"exponential", SineKind::exponential}}};

/// Where waves from this bearing (degrees, clockwise from north) go: rad anticlockwise from east,
/// in (-pi, pi].
inline double towards_from_bearing(double from_deg) {
    const double towards_deg = std::remainder(270.0 - from_deg, 360.0);
    return (towards_deg <= -180.0 ? 180.0 : towards_deg) * (pi / 180.0);
}

/// The bearing in [0, 360) that reads back as exactly this direction.
double bearing_from_towards(double towards_rad);

/// The degrees that read back as exactly this angle.
double degrees_of(double angle_rad);

} // namespace seaway::sea
