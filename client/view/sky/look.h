// SPDX-License-Identifier: Apache-2.0
// Look: all that makes the light of a picture, but for the sea and the camera. A value.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "client/view/sky/almanac.h"
#include "client/view/sky/atmosphere.h"
#include "sea/basics/water_type.h"

namespace seaway::client {

/// Diffuse reflectance of deep water, red, green, blue: of WaterType::north_sea, and below the horizon of any sky.
inline const glm::dvec3 water_reflectance(0.008, 0.024, 0.026);

inline double luminance_of(const glm::dvec3& colour) {
    return glm::dot(colour, glm::dvec3(0.2126, 0.7152, 0.0722));
}

/// One layer of clouds.
struct Clouds {
    double coverage = 0;        ///< share of the sky, 0 .. 1; at 1 no hole is left
    double base_m = 1500;       ///< height above the sea
    double optical_depth = 12;  ///< where thickest: 4 thin, 12 fair weather, 60 a storm, dark below
    double size_m = 1300;       ///< of the larger ones; their pattern repeats after 12 of it
    glm::dvec2 drift_mps{8, 3}; ///< east, north
    bool operator==(const Clouds&) const = default;
};

/// Where and when, for sun, moon and stars; without it the hour of the simple day counts.
struct PlaceAndTime {
    double latitude_deg = 0;
    double longitude_deg = 0; ///< east is positive
    Instant when;             ///< at sea time 0
    bool operator==(const PlaceAndTime&) const = default;
};

/// What lens and eye scatter of light (client/view/bloom.h).
inline constexpr double bloom_default = 0.04;

/// How bright a picture of a light is.
struct Exposure {
    enum class By {
        meter,          ///< of the picture in files, of the light on the sea in a window
        exposure_value, ///< as a camera is set: EV at ISO 100
        factor,         ///< to kcd/m2; 1 is white
    };
    By by = By::meter;
    double value = 0; ///< not of a meter
    bool operator==(const Exposure&) const = default;
};

struct Look {
    Atmosphere air;
    Clouds clouds;
    double sun_strength = 1; ///< multiplies sun, moon and all that they light
    double hour = 15.5;      ///< of the simple day (heavens_at_hour), without a place
    std::optional<PlaceAndTime> place;
    /// A picture instead of sun, moon, stars, clouds and scattered light (environment.h): an OpenEXR file, read once as
    /// long as the path stays; empty: none. The air still takes light on the way to the sea.
    std::string environment;
    double environment_turn_deg = 0; ///< clockwise
    Exposure exposure;
    double exposure_stops = 0;    ///< so many brighter than exposure says
    double bloom = bloom_default; ///< share of the light that lens and eye scatter
    // In place of what the sea says of itself.
    std::optional<sea::WaterType> water;
    std::optional<std::array<double, 3>> bottom_albedo;
    bool operator==(const Look&) const = default;
};

} // namespace seaway::client
