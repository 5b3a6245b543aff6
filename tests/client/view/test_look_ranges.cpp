// SPDX-License-Identifier: Apache-2.0
// What a look file may say makes a sky: at the ends of every key's range all light is a number, from 0.
#include <cmath>
#include <map>

#include <gtest/gtest.h>

#include "client/view/look_keys.h"
#include "client/view/sky/scattering.h"
#include "client/view/sky/sky.h"

namespace seaway::client {
namespace {

/// Fog that absorbs nothing: nothing but its own key stands between it and a division by 0.
Look dense_look() {
    Look look;
    look.air.visibility_m = visibility_min_m;
    look.air.aerosol_scale_m = 20e3;
    look.air.aerosol_albedo = 1;
    look.air.ozone_absorption_per_m = glm::dvec3(0);
    return look;
}

/// Calls visit(key, look) with each key of numbers at either end of its range.
template <class Visit>
void at_ends(const Look& base, std::string_view table, const Visit& visit) {
    for (const LookKey& row : look_keys()) {
        if ((row.table == "air") != (table == "air"))
            continue;
        for (const bool high : {false, true}) {
            Look look = base;
            if (const auto* number = std::get_if<LookNumber>(&row.value))
                number->of(look) = (high ? number->range.hi : number->range.lo) * number->unit;
            else if (const auto* triple = std::get_if<LookTriple>(&row.value))
                triple->of(look) = glm::dvec3(high ? triple->range.hi : triple->range.lo);
            else
                continue;
            visit(std::string(row.key) + (high ? " highest" : " lowest"), look);
        }
    }
}

bool light(const glm::dvec3& value) {
    for (int c = 0; c < 3; ++c)
        if (!(std::isfinite(value[c]) && value[c] >= 0))
            return false;
    return true;
}

glm::dvec3 at(double elevation_deg, double azimuth_deg = 0) {
    const double e = glm::radians(elevation_deg), a = glm::radians(azimuth_deg);
    return {std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e)};
}

TEST(LookRanges, the_airs_light_is_a_number_at_the_ends_of_every_key) {
    ThreadPool pool;
    for (const Look& base : {Look{}, dense_look()})
        at_ends(base, "air", [&](const std::string& key, const Look& look) {
            const AirTables tables(look.air, pool);
            for (const double height_m : {0.0, 500.0, 20e3})
                ASSERT_TRUE(light(depth_above(tables, height_m))) << key << ", " << height_m;
            for (double sun_deg = -90; sun_deg <= 90; sun_deg += 7.5)
                for (const double height_m : {0.3, 500.0, 20e3}) {
                    ASSERT_TRUE(
                        light(tables.multiple.at(height_m, std::sin(glm::radians(sun_deg)))))
                        << key << ", sun " << sun_deg;
                    for (const double elevation_deg : {-60.0, -2.0, 0.5, 5.0, 40.0, 90.0}) {
                        const glm::dvec3 d = at(elevation_deg, 25);
                        const AirLight seen =
                            air_light(tables, height_m, d, at(sun_deg),
                                      length_m(tables.air, ray_from(tables.air, height_m, d.z)));
                        ASSERT_TRUE(light(seen.radiance) && light(seen.transmittance))
                            << key << ", sun " << sun_deg << ", " << height_m << " m, "
                            << elevation_deg << " deg";
                    }
                }
        });
}

/// Everything that goes to the device.
void expect_light(const Sky& sky, const std::string& what) {
    for (const float texel : *sky.texels())
        ASSERT_TRUE(std::isfinite(texel)) << what;
    for (const glm::dvec3& value :
         {sky.sun_irradiance(), sky.light_irradiance(), sky.sky_irradiance(), sky.behind(at(5)),
          sky.behind(at(60)), sky.radiance(at(-20)), sky.through_air(glm::dvec3(1), 5000, at(-1))})
        ASSERT_TRUE(light(value)) << what;
}

TEST(LookRanges, whole_skies_are_light_at_the_ends_of_every_key) {
    std::map<double, SkyMaker> of_hour; // each keeps what another look leaves as it is
    const auto make = [&](const std::string& key, const Look& look) {
        for (const double hour : {0.0, 6.1, 12.0})
            expect_light(*of_hour[hour].make(look, heavens_at_hour(hour), {.height_m = 12}), key);
    };
    make("dense", dense_look());
    Look cloudy;
    cloudy.clouds.coverage = 0.5;
    at_ends(cloudy, "all but air", make);
    // Air that takes red away alone leaves colours that no screen has.
    cloudy.air.ozone_absorption_per_m = glm::dvec3(1e-3, 0, 0);
    make("red taken away", cloudy);
}

} // namespace
} // namespace seaway::client
