// SPDX-License-Identifier: Apache-2.0
#include "client/view/sky/sky.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/check.h"
#include "client/view/sky/air_between.h"

namespace seaway::client {

namespace {

using std::numbers::pi;
/// Illuminance of a star of magnitude 0: 2.54e-6 lx (Allen 1973), as 10.8e4 cd/m2 for magnitude 0 a square arc second.
constexpr double star_klx = 2.54e-9;
/// Beside a zenith of this radiance, kcd/m2, no star is seen.
constexpr double star_zenith = 0.05;

shaders::vec3 narrow(const glm::dvec3& v) {
    return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

double disc_sr() {
    return 2 * pi * (1 - std::cos(disc_radius_rad));
}

/// Below a layer that lets less of the beam through no patches are told apart.
constexpr double least_beam = 1e-3;

/// Of a disc with this share of the sun's light, `radii` above its middle.
glm::dvec3 disc_radiance(const AirTables& air, double strength, double height_m,
                         const glm::dvec3& direction, double radii) {
    const double elevation =
        std::asin(std::clamp(direction.z, -1.0, 1.0)) + radii * disc_radius_rad;
    return sunlight_klx(air.transmittance.to_space(height_m, std::sin(elevation))) *
           (strength / disc_sr());
}

} // namespace

Sky::Sky(const glm::dvec3& to_sun, double eye_height_m) {
    Heavens heavens;
    heavens.to_sun = glm::normalize(to_sun);
    heavens.moon_phase_rad = pi;
    Result<Sky> made = SkyMaker().make({}, heavens, {.height_m = eye_height_m});
    SEAWAY_CHECK(made, "a sky of air alone reads no file");
    *this = std::move(*made);
}

glm::dvec3 Sky::radiance(const glm::dvec3& direction, double blur_rad) const {
    return sea_->sample(direction, blur_rad);
}

glm::dvec3 Sky::radiance(double elevation_rad, double azimuth_from_sun_rad) const {
    const double turn = std::atan2(heavens_.to_sun.y, heavens_.to_sun.x) + azimuth_from_sun_rad;
    const double level = std::cos(elevation_rad);
    return radiance({level * std::cos(turn), level * std::sin(turn), std::sin(elevation_rad)});
}

double Sky::beam_over_mean(const glm::dvec2& local_m) const {
    if (clouds_.sunlit < least_beam || to_light_.z <= 0)
        return 1;
    CloudLayer over_sea = clouds_;
    over_sea.height_m += eye_.height_m;
    return beam_share(over_sea, *noise_, shaders::sky_columns, shaders::sky_rows, local_m) /
           clouds_.sunlit;
}

glm::dvec3 Sky::behind(const glm::dvec3& direction) const {
    const glm::dvec3 clear = eye_dome_->sample(direction);
    // Below clouds the sky reaches a little below the level, and so do they.
    const glm::dvec3 seen_at(direction.x, direction.y,
                             clouds_.height_m > 0 ? std::max(direction.z, 0.0) : direction.z);
    const CloudSeen seen =
        clouds_seen(clouds_, *noise_, shaders::sky_columns, shaders::sky_rows, seen_at);
    if (seen.distance_m == 0)
        return clear;
    const glm::dvec3 left = air_left(air_->air, eye_.height_m, seen.distance_m, seen_at.z);
    return behind_clouds(clouds_, seen, clear, depth_above(*air_, eye_.height_m), left, seen_at.z);
}

glm::dvec3 Sky::air_source(const glm::dvec3& direction) const {
    DomePlace place = eye_dome_->place(direction);
    place.from_horizon = std::min(place.from_horizon, -0.0);
    return eye_dome_->sample(place);
}

glm::dvec3 Sky::through_air(const glm::dvec3& colour, double distance_m,
                            const glm::dvec3& direction) const {
    const glm::dvec3 left = air_left(air_->air, eye_.height_m, distance_m, direction.z);
    return glm::mix(air_source(direction), colour, left);
}

glm::dvec3 Sky::below_clouds(const glm::dvec3& seen, const glm::dvec3& direction) const {
    const CloudSeen clouds =
        clouds_seen(clouds_, *noise_, shaders::sky_columns, shaders::sky_rows, direction);
    if (clouds.distance_m == 0)
        return seen;
    const glm::dvec3 left = air_left(air_->air, eye_.height_m, clouds.distance_m, direction.z);
    return before(clouds, seen, air_source(direction), left);
}

double Sky::white_radiance() const {
    return luminance_of(sky_irradiance_ + light_ * std::max(to_light_.z, 0.0)) / pi;
}

shaders::SkyValues Sky::values() const {
    shaders::SkyValues out{};
    const double height_m = eye_.height_m;
    out.to_sun = narrow(heavens_.to_sun);
    out.to_moon = narrow(heavens_.to_moon);
    out.to_light = narrow(to_light_);
    out.azimuth_rad = static_cast<float>(sea_->sharp().azimuth_rad());
    out.dip_rad = static_cast<float>(dip_rad(air_->air, height_m));
    out.disc_rad = static_cast<float>(disc_radius_rad);
    if (picture_sun_) {
        out.sun_low = out.sun_high = narrow(*picture_sun_ / disc_sr());
    } else {
        out.sun_low = narrow(disc_radiance(*air_, sun_strength_, height_m, heavens_.to_sun, -1));
        out.sun_high = narrow(disc_radiance(*air_, sun_strength_, height_m, heavens_.to_sun, 1));
        const double lit = std::max(0.5 + 0.5 * std::cos(heavens_.moon_phase_rad), 1e-3);
        out.moon =
            narrow(disc_radiance(*air_, moon_strength_, height_m, heavens_.to_moon, 0) / lit);
        const double zenith = luminance_of(eye_dome_->sample(glm::dvec3(0, 0, 1)));
        out.star_klx = static_cast<float>(zenith < star_zenith ? star_klx : 0);
    }
    const glm::dmat3 rows = glm::transpose(heavens_.equatorial_from_local);
    out.star_x = narrow(rows[0]);
    out.star_y = narrow(rows[1]);
    out.star_z = narrow(rows[2]);
    out.rayleigh_per_m = narrow(air_->air.rayleigh_rgb_per_m());
    out.rayleigh_scale_m = static_cast<float>(air_->air.rayleigh_scale_m);
    out.aerosol_per_m = narrow(air_->air.aerosol_rgb_per_m());
    out.aerosol_scale_m = static_cast<float>(air_->air.aerosol_scale_m);
    out.zenith_depth = narrow(depth_above(*air_, height_m));
    out.curvature_per_m = static_cast<float>(0.5 / air_->air.planet_radius_m);
    out.cloud_height_m = static_cast<float>(clouds_.height_m);
    out.cloud_threshold = static_cast<float>(clouds_.threshold);
    out.cloud_depth = static_cast<float>(clouds_.optical_depth);
    out.cloud_origin = {static_cast<float>(clouds_.origin.x), static_cast<float>(clouds_.origin.y)};
    out.cloud_per_m = {static_cast<float>(1 / clouds_.period_m.x),
                       static_cast<float>(1 / clouds_.period_m.y)};
    out.cloud_light = narrow(clouds_.light);
    const bool patchy = clouds_.threshold < 1.5 && clouds_.sunlit >= least_beam && to_light_.z > 0;
    out.cloud_patches = static_cast<float>(patchy ? 1 / clouds_.sunlit : 0);
    out.cloud_sky = narrow(clouds_.sky);
    out.cloud_shaded = narrow(clouds_.shaded);
    out.cloud_sunlit = static_cast<float>(clouds_.sunlit);
    return out;
}

} // namespace seaway::client
