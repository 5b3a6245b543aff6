// SPDX-License-Identifier: Apache-2.0
// Where sun, moon and stars stand, by place and time.
//
// The low-precision formulas of the Astronomical Almanac (pages C5 and D22): the sun within 0.01
// degrees, the moon within 0.3 degrees in longitude and 0.2 in latitude, 1950 to 2050. Directions are
// geometric: the air does not bend them. The moon is seen from the place, not from the earth's centre.
//
// Local frame: x east, y north, z up. Pure functions.
#pragma once

#include <string>
#include <string_view>

#include <glm/glm.hpp>

#include "base/result.h"

namespace seaway::client {

/// Days since noon of 1 January 2000, universal time.
struct Instant {
    double days_j2000 = 0;
    bool operator==(const Instant&) const = default;
};
inline constexpr int year_min = 1950, year_max = 2050; ///< where the errors above hold

/// "2026-06-21T04:30Z" or with seconds: years 1950 .. 2050.
Result<Instant> parse_instant(std::string_view text);
/// The inverse, to the second.
std::string to_text(Instant when);

struct Equatorial {
    double right_ascension_rad;
    double declination_rad;
    double distance; ///< sun: astronomical units; moon: earth radii
};
Equatorial sun_at(Instant when);
Equatorial moon_at(Instant when); ///< from the earth's centre

/// All that shines from beyond the air.
struct Heavens {
    glm::dvec3 to_sun{0, 0, 1};
    glm::dvec3 to_moon{0, 0, -1};
    double sun_distance_au = 1;
    double moon_phase_rad = 0; ///< angle between sun and eye as the moon sees them; 0: full
    glm::dmat3 equatorial_from_local{1.0};
    bool operator==(const Heavens&) const = default;
};
Heavens heavens_at(Instant when, double latitude_deg, double longitude_deg);

/// The simple sky of --time-of-day: day of equinox at 45 degrees north, solar time. The sun rises in
/// the east at 6 and stands 45 degrees high in the south at 12; a full moon stands opposite to it.
Heavens heavens_at_hour(double time_of_day_h);

/// Light of the moon over that of the full one (Allen 1973; phases up to 150 degrees measured).
double moon_brightness(double phase_rad);

} // namespace seaway::client
