// SPDX-License-Identifier: Apache-2.0
// The sky of an eye at a height, and the dome that holds it.
#include "client/view/sky/air_between.h"
#include "client/view/sky/sky_view.h"
#include "tests/client/view/sky/air_fixture.h"

namespace seaway::client {
namespace {

/// Illuminance of a level plane by the half of a dome above it, klx.
glm::dvec3 level_irradiance(const Dome& dome) {
    constexpr int steps = 96;
    glm::dvec3 sum(0);
    for (int i = 0; i < steps; ++i)
        for (int j = 0; j < steps; ++j) {
            const double z = (i + 0.5) / steps, level = std::sqrt(1 - z * z);
            const double turn = 2 * air_pi * (j + 0.5) / steps;
            sum += dome.sample(glm::dvec3(level * std::cos(turn), level * std::sin(turn), z)) * z;
        }
    return sum * (2 * air_pi / (steps * steps));
}

SkyView view(double height_m, double sun_deg) {
    return SkyView(clear_air(), height_m, towards(sun_deg, 200), air_pool());
}

TEST(Dome, every_texel_lies_where_its_direction_says) {
    for (const double dip : {0.0, 0.002, 0.056}) {
        Dome dome(32, 20, 0.7, dip);
        for (int y = 0; y < 20; ++y)
            for (int x = 0; x < 32; ++x)
                dome.at(x, y) = glm::vec3(x, y, 1);
        for (int y = 0; y < 20; ++y)
            for (int x = 0; x < 32; ++x) {
                glm::dvec3 direction = dome.direction(x, y);
                direction.z += y < 10 ? -1e-9 : 1e-9; // the horizon's two rows
                const glm::dvec3 found = dome.sample(glm::normalize(direction));
                if (y > 0 && y < 19) { // all columns meet in the zenith
                    EXPECT_NEAR(found.x, x, 1e-3) << x << ", " << y;
                }
                EXPECT_NEAR(found.y, y, 1e-2) << x << ", " << y;
            }
    }
}

TEST(Dome, nothing_is_mixed_across_the_horizon) {
    Dome dome(8, 16, 0, 0.01);
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 8; ++x)
            dome.at(x, y) = glm::vec3(y < 8 ? 0 : 1);
    EXPECT_EQ(dome.sample(glm::dvec3(std::cos(-0.0101), 0, std::sin(-0.0101))).r, 0);
    EXPECT_EQ(dome.sample(glm::dvec3(std::cos(-0.0099), 0, std::sin(-0.0099))).r, 1);
}

// Four heights: above the horizon the table has the sky of that height, below it there is sea.
TEST(SkyView, the_horizon_lies_where_the_sphere_ends) {
    for (const double height_m : {2.0, 50.0, 1000.0, 10e3}) {
        const SkyView v = view(height_m, 40);
        const double dip = std::acos(earth_radius_m / (earth_radius_m + height_m));
        EXPECT_NEAR(v.dome().dip_rad(), dip, 1e-12);
        EXPECT_FALSE(
            meets_sea(clear_air().air, ray_from(clear_air().air, height_m, std::sin(-dip + 1e-5))));
        EXPECT_TRUE(
            meets_sea(clear_air().air, ray_from(clear_air().air, height_m, std::sin(-dip - 1e-5))));
    }
}

// The table is what it interpolates. 1.5 %: rows are 2 degrees apart at 45.
TEST(SkyView, holds_the_light_of_the_air_between_its_nodes) {
    for (const double height_m : {2.0, 3000.0}) {
        const SkyView v = view(height_m, 30);
        for (const double above_deg : {0.2, 1.0, 7.0, 33.0, 80.0})
            for (const double from_sun_deg : {3.0, 47.0, 121.0, -60.0}) {
                const glm::dvec3 d =
                    towards(above_deg - v.dome().dip_rad() / air_degree, 200 + from_sun_deg);
                const glm::dvec3 truth =
                    sunlight_klx(air_light(clear_air(), height_m, d, towards(30, 200),
                                           whole_length_m(clear_air().air, height_m, d))
                                     .radiance);
                const glm::dvec3 found = v.dome().sample(d);
                for (int c = 0; c < 3; ++c)
                    EXPECT_NEAR(found[c] / truth[c], 1, 0.015)
                        << height_m << " m, " << above_deg << ", " << from_sun_deg;
            }
    }
}

// Source and transmittance give the light on the way to the sea back. 3 %: the steps of the view.
TEST(SkyView, air_before_the_sea_sends_its_source_times_what_it_holds_back) {
    const Air& air = clear_air().air;
    for (const double height_m : {20.0, 10e3}) {
        const SkyView v = view(height_m, 50);
        for (const double below_deg : {0.2, 2.0, 20.0, 70.0}) {
            const glm::dvec3 d = towards(-below_deg - v.dome().dip_rad() / air_degree, 200 + 35);
            const double distance_m = whole_length_m(air, height_m, d);
            const glm::dvec3 truth = sunlight_klx(
                air_light(clear_air(), height_m, d, towards(50, 200), distance_m, 200).radiance);
            const glm::dvec3 found =
                v.dome().sample(d) * (1.0 - air_left(air, height_m, distance_m, d.z));
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(found[c] / truth[c], 1, 0.03) << height_m << " " << below_deg;
        }
    }
}

// Few exponentials stand for the integral: 1 % of the light from beyond.
TEST(SkyView, air_on_the_way_to_the_sea_is_beers_law_by_colour) {
    const Air& air = clear_air().air;
    for (const double height_m : {0.3, 12.0, 400.0, 3000.0, 10e3, 20e3})
        for (const double below_deg : {0.01, 0.5, 4.0, 30.0, 89.0}) {
            const glm::dvec3 d = towards(-below_deg - dip_rad(air, height_m) / air_degree);
            const double distance_m = whole_length_m(air, height_m, d);
            double rayleigh_m = 0, aerosol_m = 0; // what of air at the sea the way is worth
            constexpr int steps = 20'000;
            for (int i = 0; i < steps; ++i) {
                const double h = height_after_m(air, ray_from(air, height_m, d.z),
                                                distance_m * (i + 0.5) / steps);
                rayleigh_m += distance_m / steps * std::exp(-h / air.rayleigh_scale_m);
                aerosol_m += distance_m / steps * std::exp(-h / air.aerosol_scale_m);
            }
            const glm::dvec3 truth = glm::exp(-rayleigh_m * air.rayleigh_rgb_per_m() -
                                              aerosol_m * air.aerosol_rgb_per_m());
            const glm::dvec3 found = air_left(air, height_m, distance_m, d.z);
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(found[c], truth[c], 0.01) << height_m << " " << below_deg;
        }
}

// Clear sky, sun 60 degrees high: 10 to 20 % of what falls on the level comes from the sky. IES 1984
// (recommended practice for the calculation of daylight availability) gives 15 klx for a clear sky.
TEST(SkyView, a_seventh_of_noons_light_comes_from_the_sky) {
    const double sine = std::sin(60 * air_degree);
    const glm::dvec3 sky = level_irradiance(view(2, 60).dome());
    const glm::dvec3 sun =
        sunlight_klx(clear_air().transmittance.to_disc(2, sine, disc_radius_rad)) * sine;
    EXPECT_GT(sky.g / (sky.g + sun.g), 0.10);
    EXPECT_LT(sky.g / (sky.g + sun.g), 0.20);
    EXPECT_NEAR(sky.g, 15, 3);
    EXPECT_GT(sky.b, 1.5 * sky.r);
}

// Light on a level plane under a clear sky, by the AMS Glossary of Meteorology ("civil twilight", "astronomical
// twilight"): 585 to 410 lx when the sun's rim goes under (centre at -0.83 degrees, refraction taken out), 3.5 to 2 lx at
// the end of civil twilight (-6), 0.008 at that of nautical (-12). A factor of 2 either way: light that is scattered
// more than once is taken to come from all sides alike.
TEST(SkyView, twilight_fades_as_lux_meters_have_it) {
    const auto expect_lux = [](double sun_deg, double from, double to) {
        const double lux = 1e3 * glm::dot(level_irradiance(view(2, sun_deg).dome()),
                                          glm::dvec3(0.2126, 0.7152, 0.0722));
        EXPECT_GT(lux, from / 2) << sun_deg;
        EXPECT_LT(lux, 2 * to) << sun_deg;
    };
    expect_lux(-0.83, 410, 585);
    expect_lux(-6, 2, 3.5);
    expect_lux(-12, 0.008, 0.008);
}

TEST(SkyView, ozone_keeps_the_zenith_blue_at_sunset) {
    const glm::dvec3 with = view(2, -2).dome().sample(glm::dvec3(0, 0, 1));
    Atmosphere none;
    none.ozone_absorption_per_m = glm::dvec3(0);
    const AirTables tables(none, air_pool());
    const SkyView without(tables, 2, towards(-2, 200), air_pool());
    EXPECT_GT(with.b, 1.2 * with.g);
    const glm::dvec3 bare = without.dome().sample(glm::dvec3(0, 0, 1));
    EXPECT_GT(with.b / with.g, 1.3 * bare.b / bare.g);
}

// From ten kilometres the zenith is dark and the horizon pale: most of the air lies below.
TEST(SkyView, the_sky_darkens_above_a_climbing_eye) {
    double last = 1e9;
    for (const double height_m : {2.0, 1000.0, 5e3, 10e3, 20e3}) {
        const SkyView v = view(height_m, 50);
        const double zenith = v.dome().sample(glm::dvec3(0, 0, 1)).g;
        EXPECT_LT(zenith, last) << height_m;
        last = zenith;
        EXPECT_GT(v.dome().sample(towards(1 - v.dome().dip_rad() / air_degree, 290)).g, zenith);
    }
}

TEST(SkyView, is_a_number_for_every_sun_height_and_haze) {
    for (const double visibility_m : {visibility_min_m, 40e3, visibility_max_m}) {
        Atmosphere air;
        air.visibility_m = visibility_m;
        const AirTables tables(air, air_pool());
        for (const double height_m : {0.0, 20e3})
            for (const double sun_deg : {-90.0, -20.0, -0.1, 0.0, 1.0, 45.0, 90.0}) {
                const SkyView v(tables, height_m, towards(sun_deg, 200), air_pool());
                for (const glm::vec3& texel : v.dome().texels())
                    for (int c = 0; c < 3; ++c)
                        ASSERT_TRUE(std::isfinite(texel[c]) && texel[c] >= 0)
                            << visibility_m << " " << height_m << " " << sun_deg;
            }
    }
}

TEST(SkyView, heights_share_tables_within_four_percent) {
    EXPECT_EQ(height_on_ladder_m(0), SkyView::height_min_m);
    double last = 0;
    int rungs = 0;
    for (double height_m = 1; height_m < 20e3; height_m *= 1.001) {
        const double rung = height_on_ladder_m(height_m);
        EXPECT_NEAR(rung / height_m, 1, 0.021);
        EXPECT_GE(rung, last);
        rungs += rung > last ? 1 : 0;
        last = rung;
    }
    EXPECT_LT(rungs, 256);
    EXPECT_EQ(height_on_ladder_m(height_on_ladder_m(777)), height_on_ladder_m(777));
}

} // namespace
} // namespace seaway::client
