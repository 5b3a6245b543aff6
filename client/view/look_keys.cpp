// SPDX-License-Identifier: Apache-2.0
#include "client/view/look_keys.h"

#include <fmt/format.h>

namespace seaway::client {

namespace {

constexpr Range lengths_m{1, 100e3};

constexpr std::array keys{
    LookKey{
        "time", "hour", LookWord::hour,
        "of the simple day: equinox at 45 degrees north, solar time; in place of the next three"},
    LookKey{"time", "latitude_deg", LookWord::latitude, "of the place, north is positive"},
    LookKey{"time", "longitude_deg", LookWord::longitude, "east is positive"},
    LookKey{"time", "utc", LookWord::utc,
            "at sea time 0, years 1950 .. 2050: where sun, moon and stars stand there"},
    LookKey{"light", "exposure", LookWord::exposure,
            "auto: metered; as a camera is set, EV at ISO 100; or a factor to kcd/m2"},
    LookKey{"light", "exposure_stops",
            LookNumber{exposure_stops, [](Look& look) -> double& { return look.exposure_stops; }},
            "so many brighter than that; the slider of the window"},
    LookKey{"light", "sun_strength",
            LookNumber{{0, 100}, [](Look& look) -> double& { return look.sun_strength; }},
            "factor to sun, moon and all that they light"},
    LookKey{"light", "bloom", LookNumber{{0, 1}, [](Look& look) -> double& { return look.bloom; }},
            "share that lens and eye scatter, where the quality has it"},
    LookKey{"air", "visibility_km",
            LookNumber{visibilities_km, [](Look& look) -> double& { return look.air.visibility_m; },
                       1000},
            "where 2 % of contrast is left, at the sea: what aerosol there is"},
    LookKey{"air", "aerosol_scale_m",
            LookNumber{lengths_m, [](Look& look) -> double& { return look.air.aerosol_scale_m; }},
            "height in which it falls to 1/e"},
    LookKey{"air", "aerosol_albedo",
            LookNumber{albedos, [](Look& look) -> double& { return look.air.aerosol_albedo; }},
            "share of its extinction that is scattering"},
    LookKey{
        "air", "aerosol_asymmetry",
        LookNumber{{-0.95, 0.95}, [](Look& look) -> double& { return look.air.aerosol_asymmetry; }},
        "how far forward it scatters"},
    LookKey{"air", "aerosol_exponent",
            LookNumber{{-1, 4}, [](Look& look) -> double& { return look.air.aerosol_exponent; }},
            "of wavelength (Angstrom): 0 grey, 2 blue haze"},
    LookKey{
        "air", "rayleigh_per_m",
        LookTriple{{0, 1e-3},
                   [](Look& look) -> glm::dvec3& { return look.air.rayleigh_scattering_per_m; }},
        "scattering of the air itself at the sea, at 610, 550, 445 nm"},
    LookKey{"air", "rayleigh_scale_m",
            LookNumber{lengths_m, [](Look& look) -> double& { return look.air.rayleigh_scale_m; }},
            "height in which it falls to 1/e"},
    LookKey{"air", "ozone_per_m",
            LookTriple{{0, 1e-3},
                       [](Look& look) -> glm::dvec3& { return look.air.ozone_absorption_per_m; }},
            "absorption where it is densest, at the same wavelengths; the default is 300 DU"},
    LookKey{"air", "ozone_centre_m",
            LookNumber{lengths_m, [](Look& look) -> double& { return look.air.ozone_centre_m; }},
            "height of its layer"},
    LookKey{
        "air", "ozone_half_width_m",
        LookNumber{lengths_m, [](Look& look) -> double& { return look.air.ozone_half_width_m; }},
        "of that"},
    LookKey{"air", "ground_albedo",
            LookNumber{albedos, [](Look& look) -> double& { return look.air.ground_albedo; }},
            "of the sea under a mean sky"},
    LookKey{"clouds", "coverage",
            LookNumber{cloud_shares, [](Look& look) -> double& { return look.clouds.coverage; }},
            "share of the sky; at 1 no hole is left"},
    LookKey{"clouds", "base_m",
            LookNumber{{10, 20e3}, [](Look& look) -> double& { return look.clouds.base_m; }},
            "height above the sea"},
    LookKey{"clouds", "optical_depth",
            LookNumber{{0, 1000}, [](Look& look) -> double& { return look.clouds.optical_depth; }},
            "where thickest: 4 thin, 12 fair weather, 60 a storm"},
    LookKey{
        "clouds", "size_m",
        LookNumber{{10, lengths_m.hi}, [](Look& look) -> double& { return look.clouds.size_m; }},
        "of the larger ones"},
    LookKey{"clouds", "drift_east_mps",
            LookNumber{{-200, 200}, [](Look& look) -> double& { return look.clouds.drift_mps.x; }},
            "where the wind up there takes them"},
    LookKey{"clouds", "drift_north_mps",
            LookNumber{{-200, 200}, [](Look& look) -> double& { return look.clouds.drift_mps.y; }},
            "likewise"},
    LookKey{"sky", "environment", LookWord::environment,
            "a picture of the sky in place of a computed one, beside the look"},
    LookKey{
        "sky", "turn_deg",
        LookNumber{{-360, 360}, [](Look& look) -> double& { return look.environment_turn_deg; }},
        "of that picture, clockwise"},
    LookKey{"water", "type", LookWord::water,
            "Jerlov's optical type; left out: what the sea says of itself"},
    LookKey{"water", "bottom_albedo", LookWord::bottom,
            "red, green, blue of the sea floor; left out: likewise"},
};

std::string allowed_word(LookWord word) {
    const auto numbers = [](Range range) {
        return fmt::format("{:g} .. {:g}", range.lo, range.hi);
    };
    switch (word) {
    case LookWord::hour:
        return numbers(hours);
    case LookWord::latitude:
        return numbers(latitudes_deg);
    case LookWord::longitude:
        return numbers(longitudes_deg);
    case LookWord::utc:
        return "as 2026-06-21T18:30:00Z";
    case LookWord::exposure:
        return fmt::format("\"auto\", \"{0}ev\" .. \"{1}ev\", or {2}", exposure_values.lo,
                           exposure_values.hi, numbers(exposure_factors));
    case LookWord::environment:
        return "name of an OpenEXR file";
    case LookWord::bottom:
        return fmt::format("[red, green, blue], each {}", numbers(albedos));
    case LookWord::water:
        break;
    }
    std::string names;
    for (const auto& [name, type] : sea::water_types)
        names += fmt::format("{}\"{}\"", names.empty() ? "" : ", ", name);
    return names;
}

} // namespace

std::span<const LookKey> look_keys() {
    return keys;
}

std::string allowed(const LookKey& key) {
    if (const auto* number = std::get_if<LookNumber>(&key.value))
        return fmt::format("{} .. {}", number->range.lo, number->range.hi);
    if (const auto* triple = std::get_if<LookTriple>(&key.value))
        return fmt::format("[a, b, c], each {} .. {}", triple->range.lo, triple->range.hi);
    return allowed_word(std::get<LookWord>(key.value));
}

} // namespace seaway::client
