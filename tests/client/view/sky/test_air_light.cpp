// SPDX-License-Identifier: Apache-2.0
// What the air scatters towards an eye, against integrals that share nothing with the tables.
#include <random>

#include "tests/client/view/sky/air_fixture.h"

namespace seaway::client {
namespace {

/// Single scattering as it stands in books: every sample's light from the sun by an integral of its own.
glm::dvec3 integral_of_single_scattering(const Air& air, double height_m,
                                         const glm::dvec3& direction, const glm::dvec3& to_sun) {
    const Ray ray = ray_from(air, height_m, direction.z);
    const double length = length_m(air, ray), cosine = glm::dot(direction, to_sun);
    constexpr int steps = 3000;
    glm::dvec3 depth(0), sum(0);
    // Steps grow with the cube, or shrink with it towards the sea.
    for (int i = 0; i < steps; ++i) {
        const auto at = [&](double s) {
            return length * (meets_sea(air, ray) ? 1 - std::pow(1 - s, 3) : s * s * s);
        };
        const double from_m = at(static_cast<double>(i) / steps), to_m = at((i + 1.0) / steps);
        const double middle_m = (from_m + to_m) / 2, step_m = to_m - from_m;
        const double here_m = height_after_m(air, ray, middle_m);
        const Medium medium = air.at(here_m);
        const glm::dvec3 place = glm::dvec3(0, 0, ray.radius_m) + middle_m * direction;
        const Ray sun = ray_from(air, here_m, glm::dot(place, to_sun) / glm::length(place));
        const glm::dvec3 seen = glm::exp(-depth - 0.5 * step_m * medium.extinction_per_m);
        depth += step_m * medium.extinction_per_m;
        if (meets_sea(air, sun))
            continue;
        const glm::dvec3 lit = glm::exp(-optical_depth(air, sun, length_m(air, sun), 200));
        sum += step_m * seen * lit *
               (medium.rayleigh_per_m * rayleigh_phase(cosine) +
                medium.aerosol_per_m * aerosol_phase(air.aerosol_asymmetry, cosine));
    }
    return sum;
}

// 28 steps of constant medium instead of 3000: 2 %, as Hillaire 2020 has it for 30.
TEST(AirLight, single_scattering_is_its_integral_in_twenty_random_directions) {
    const AirTables& t = clear_air();
    std::mt19937 random(20);
    std::uniform_real_distribution<double> share(0, 1);
    for (int i = 0; i < 20; ++i) {
        const double height_m = std::pow(10, 4 * share(random));
        const glm::dvec3 to_sun = towards(2 + 85 * share(random));
        const double dip_deg = dip_rad(t.air, height_m) / air_degree;
        const double above_deg = i % 3 == 0 ? -2 - 60 * share(random) : 1 + 80 * share(random);
        const glm::dvec3 direction = towards(above_deg - dip_deg, 360 * share(random));
        const glm::dvec3 truth = integral_of_single_scattering(t.air, height_m, direction, to_sun);
        const glm::dvec3 found =
            single_scattering(t, height_m, direction, to_sun,
                              whole_length_m(t.air, height_m, direction), view_steps)
                .radiance;
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(found[c] / truth[c], 1, 0.02)
                << i << ": from " << height_m << " m, " << above_deg << " deg above the horizon";
    }
}

TEST(AirLight, what_the_air_lets_through_is_beers_law_on_the_way_to_the_sea) {
    const AirTables& t = clear_air();
    for (const double height_m : {2.0, 300.0, 10e3})
        for (const double below_deg : {0.1, 3.0, 30.0, 89.0}) {
            const glm::dvec3 down = towards(-below_deg - dip_rad(t.air, height_m) / air_degree);
            const double length = whole_length_m(t.air, height_m, down);
            const glm::dvec3 truth =
                glm::exp(-optical_depth(t.air, ray_from(t.air, height_m, down.z), length, 3000));
            const AirLight found = air_light(t, height_m, down, towards(40), length);
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(found.transmittance[c], truth[c], 3e-3) << height_m << " " << below_deg;
        }
}

// Halves of a way add up to the way: light from beyond passes what is nearer.
TEST(AirLight, light_of_a_way_is_that_of_its_parts) {
    const AirTables& t = clear_air();
    const glm::dvec3 to_sun = towards(25, 70);
    const glm::dvec3 direction = towards(8, 0);
    const double height_m = 50, half_m = 6e3;
    const AirLight near = air_light(t, height_m, direction, to_sun, half_m, 400);
    const AirLight whole = air_light(t, height_m, direction, to_sun, 2 * half_m, 400);
    // The frame of the second half is turned by what the earth curves: 0.05 degrees.
    const Ray ray = ray_from(t.air, height_m, direction.z);
    const double turn = half_m * direction.x / t.air.planet_radius_m;
    const auto turned = [&](const glm::dvec3& v) {
        return glm::dvec3(std::cos(turn) * v.x - std::sin(turn) * v.z, v.y,
                          std::sin(turn) * v.x + std::cos(turn) * v.z);
    };
    const AirLight far = air_light(t, height_after_m(t.air, ray, half_m), turned(direction),
                                   turned(to_sun), half_m, 400);
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR((near.radiance[c] + near.transmittance[c] * far.radiance[c]) /
                        whole.radiance[c],
                    1, 1e-4);
}

// A low sun: at 2 degrees its light passes 20 times the air. The disc is as red as the table says.
TEST(AirLight, the_sun_reddens_as_it_sinks) {
    const AirTables& t = clear_air();
    double last = 1;
    for (const double elevation_deg : {60.0, 20.0, 10.0, 5.0, 2.0, 0.5}) {
        const double cosine = std::sin(elevation_deg * air_degree);
        const glm::dvec3 left = t.transmittance.to_disc(2, cosine, disc_radius_rad);
        EXPECT_LT(left.b / left.r, last) << elevation_deg;
        last = left.b / left.r;
        const Ray ray = ray_from(t.air, 2, cosine);
        const glm::dvec3 depth = optical_depth(t.air, ray, length_m(t.air, ray), 2000);
        EXPECT_NEAR(last, std::exp(depth.r - depth.b), 0.01 * std::exp(depth.r - depth.b))
            << elevation_deg;
    }
    EXPECT_LT(last, 0.01);
}

// The disc sets behind a line: as much of its light is left as of its height.
TEST(AirLight, a_setting_disc_loses_light_as_it_goes_under) {
    const AirTables& t = clear_air();
    const auto green = [&](double radii, double height_m) {
        return t.transmittance
            .to_disc(height_m, std::sin(radii * disc_radius_rad - dip_rad(t.air, height_m)),
                     disc_radius_rad)
            .g;
    };
    for (const double height_m : {0.0, 30.0, 10e3}) {
        EXPECT_EQ(green(-1.01, height_m), 0);
        EXPECT_GT(green(0, height_m), 0);
        for (const double radii : {-0.9, -0.5, -0.25})
            EXPECT_NEAR(green(radii, height_m) / green(0, height_m), 1 + radii, 2e-3)
                << radii << " from " << height_m;
    }
}

} // namespace
} // namespace seaway::client
