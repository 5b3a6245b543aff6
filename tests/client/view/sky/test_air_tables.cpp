// SPDX-License-Identifier: Apache-2.0
// The tables that hang on the medium alone: transmittance and multiple scattering.
#include "client/view/sky/two_stream.h"
#include "tests/client/view/sky/air_fixture.h"

namespace seaway::client {
namespace {

// Of an exponential atmosphere the depth at the zenith is the coefficient times the scale height, and
// ozone's tent times half its width on either side. The top at 100 km cuts 4e-6 of it off.
TEST(AirTables, transmittance_at_the_zenith_is_beers_law_of_an_exponential_atmosphere) {
    for (const double visibility_m : {5e3, 40e3, 200e3}) {
        Atmosphere air;
        air.visibility_m = visibility_m;
        const Air medium(air);
        const TransmittanceTable table(medium, air_pool());
        for (const double height_m : {0.0, 300.0, 2000.0, 9000.0}) {
            const glm::dvec3 depth = air.rayleigh_scattering_per_m * air.rayleigh_scale_m *
                                         std::exp(-height_m / air.rayleigh_scale_m) +
                                     medium.aerosol_extinction_per_m() * air.aerosol_scale_m *
                                         std::exp(-height_m / air.aerosol_scale_m) +
                                     air.ozone_absorption_per_m * air.ozone_half_width_m;
            const glm::dvec3 found = table.to_space(height_m, 1);
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(found[c], std::exp(-depth[c]), 1e-3) << visibility_m << " " << height_m;
        }
    }
}

// Interpolation of depth between 256 x 128 nodes. At the horizon a row of the table is 4 km of air.
TEST(AirTables, transmittance_is_the_direct_integral_in_every_direction) {
    const AirTables& t = clear_air();
    for (const double height_m : {0.5, 12.0, 700.0, 4300.0, 20e3})
        for (const double above_deg : {0.05, 0.3, 1.0, 4.0, 15.0, 50.0}) {
            const double elevation = above_deg * air_degree - dip_rad(t.air, height_m);
            const Ray ray = ray_from(t.air, height_m, std::sin(elevation));
            const glm::dvec3 truth =
                glm::exp(-optical_depth(t.air, ray, length_m(t.air, ray), 2000));
            const glm::dvec3 found = t.transmittance.to_space(height_m, ray.cosine);
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(found[c], truth[c], 2e-3 + 5e-3 * truth[c])
                    << height_m << " m, " << above_deg << " deg above the horizon";
        }
}

// Koschmieder: contrast falls to 2 % within the visibility along the sea, at 550 nm.
TEST(AirTables, two_percent_of_green_light_are_left_after_the_visibility) {
    for (const double visibility_m : {visibility_min_m, 3e3, 40e3, visibility_max_m}) {
        Atmosphere air;
        air.visibility_m = visibility_m;
        EXPECT_NEAR(std::exp(-visibility_m * Air(air).at(0).extinction_per_m.g), 0.02, 1e-9);
    }
}

TEST(AirTables, phase_functions_scatter_all_that_they_are_given) {
    for (const double asymmetry : {0.0, 0.5, 0.8, 0.95}) {
        double rayleigh = 0, aerosol = 0, forward = 0;
        constexpr int steps = 1'000'000;
        for (int i = 0; i < steps; ++i) {
            const double cosine = -1 + 2 * (i + 0.5) / steps, sr = 4 * air_pi / steps;
            rayleigh += sr * rayleigh_phase(cosine);
            aerosol += sr * aerosol_phase(asymmetry, cosine);
            forward += sr * cosine * aerosol_phase(asymmetry, cosine);
        }
        EXPECT_NEAR(rayleigh, 1, 1e-6);
        EXPECT_NEAR(aerosol, 1, 2e-6);
        // Cornette and Shanks 1992, equation 9: a little more than the parameter itself.
        const double g = asymmetry;
        EXPECT_NEAR(forward, g * 3 * (4 + g * g) / (5 * (2 + g * g)), 2e-6);
    }
}

// The furnace: a white world around air that absorbs nothing is white wherever one looks. What comes from
// beyond the air or from a white sea, and what the air itself sends back, is all.
TEST(AirTables, white_light_around_air_that_absorbs_nothing_stays_white) {
    Atmosphere white;
    white.aerosol_albedo = 1;
    white.ozone_absorption_per_m = glm::dvec3(0);
    const Air air(white);
    const TransmittanceTable table(air, air_pool());
    for (const double height_m : {0.0, 500.0, 8000.0, 60e3}) {
        const Transfer transfer = transfers_at(air, table, height_m, {0.3}).front();
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(transfer.scattered[c] + transfer.passed[c], 1, 1e-9) << height_m;
    }
}

TEST(AirTables, air_that_absorbs_sends_back_less_than_it_is_given) {
    const AirTables& t = clear_air();
    for (const double height_m : {0.0, 500.0, 8000.0, 60e3}) {
        const Transfer transfer = transfers_at(t.air, t.transmittance, height_m, {0.3}).front();
        for (int c = 0; c < 3; ++c)
            EXPECT_LT(transfer.scattered[c] + transfer.passed[c], 1) << height_m;
    }
}

/// What a scatterer has from all around, on average over directions, of light that the air scattered once and the sea sent up: in finer steps than the
/// product's, and with the sun's share from the table that the tests above hold.
glm::dvec3 light_from_all_around(const AirTables& t, double height_m, const glm::dvec3& to_sun) {
    constexpr int rings = 60, turns = 48, steps = 400;
    glm::dvec3 sum(0);
    for (int ring = 0; ring < rings; ++ring)
        for (int turn = 0; turn < turns; ++turn) {
            const double z = 1 - 2 * (ring + 0.5) / rings, level = std::sqrt(1 - z * z);
            const double azimuth = 2 * air_pi * (turn + 0.5) / turns;
            const glm::dvec3 direction(level * std::cos(azimuth), level * std::sin(azimuth), z);
            const Ray ray = ray_from(t.air, height_m, z);
            const double length = length_m(t.air, ray);
            const auto sun_at = [&](double at_m) {
                const glm::dvec3 place = glm::dvec3(0, 0, ray.radius_m) + at_m * direction;
                return glm::dot(place, to_sun) / glm::length(place);
            };
            glm::dvec3 depth(0);
            for (int i = 0; i < steps; ++i) {
                // Steps grow with the cube from the scatterer on.
                const double from_m = length * std::pow(static_cast<double>(i) / steps, 3);
                const double step_m = length * std::pow((i + 1.0) / steps, 3) - from_m;
                const double here_m = height_after_m(t.air, ray, from_m + step_m / 2);
                const Medium medium = t.air.at(here_m);
                const glm::dvec3 seen = glm::exp(-depth - 0.5 * step_m * medium.extinction_per_m);
                depth += step_m * medium.extinction_per_m;
                sum += step_m * seen * (medium.rayleigh_per_m + medium.aerosol_per_m) *
                       t.transmittance.to_space(here_m, sun_at(from_m + step_m / 2)) / (4 * air_pi);
            }
            if (meets_sea(t.air, ray)) // a white sheet of its albedo sends 1/pi of what falls on it
                sum += glm::exp(-depth) * t.transmittance.to_space(0, sun_at(length)) *
                       sun_at(length) * t.air.ground_albedo / air_pi;
        }
    return sum / static_cast<double>(rings * turns);
}

// 64 directions of 20 steps (Hillaire 2020) instead of 2880 of 400: up to 8 % off, of what is a quarter of the sky's light.
TEST(AirTables, light_from_all_around_is_its_integral_over_directions) {
    const AirTables& t = clear_air();
    for (const double height_m : {0.0, 500.0, 4000.0})
        for (const double sun_deg : {15.0, 45.0, 90.0}) {
            const glm::dvec3 to_sun = towards(sun_deg);
            const glm::dvec3 truth = light_from_all_around(t, height_m, to_sun);
            const glm::dvec3 found =
                transfers_at(t.air, t.transmittance, height_m, {to_sun.z})[0].lit;
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(found[c] / truth[c], 1, 0.1) << height_m << " m, " << sun_deg;
        }
}

// Of what is scattered a share is scattered once more, and again: all orders together are the sum of that series, term by
// term, where the sun stands overhead.
TEST(AirTables, the_table_holds_light_of_every_order) {
    const AirTables& t = clear_air();
    for (const int row : {0, 7, 16}) { // of the table: heights between them are interpolated
        const double height_m = t.air.thickness_m * (row / 31.0) * (row / 31.0);
        const Transfer transfer = transfers_at(t.air, t.transmittance, height_m, {1.0}).front();
        const glm::dvec3 table = t.multiple.at(height_m, 1.0);
        for (int c = 0; c < 3; ++c) {
            double sum = 0, term = transfer.lit[c];
            for (int order = 2; order < 200; ++order, term *= transfer.scattered[c])
                sum += term;
            EXPECT_NEAR(table[c] / sum, 1, 1e-5) << row; // floats
            EXPECT_GT(sum, 1.01 * transfer.lit[c]) << "else this test sees nothing";
        }
    }
}

// Scattering twice is a quarter of once where the optical depth is some tenths (Bruneton 2017): most for
// blue, and by day everywhere.
TEST(AirTables, light_scattered_again_is_bluest_and_never_negative) {
    const AirTables& t = clear_air();
    for (const double height_m : {0.0, 100.0, 3e3, 20e3, 99e3})
        for (double sun = -1; sun <= 1; sun += 0.0625) {
            const glm::dvec3 again = t.multiple.at(height_m, sun);
            for (int c = 0; c < 3; ++c) {
                EXPECT_GE(again[c], 0);
                EXPECT_LT(again[c], 1 / air_pi);
            }
            if (sun > 0.2 && height_m < 20e3) {
                EXPECT_GT(again.b, again.r);
            }
        }
}

/// Light on the level below a slab of haze, of a sun of illuminance 1: Joseph, Wiscombe and Weinman 1976 (J. Atmos. Sci. 33,
/// 2452), delta-Eddington, closed form.
double light_below_haze(double depth, double albedo, double moment, double ground, double sun) {
    const double f = moment * moment, g = moment / (1 + moment);
    const double w = albedo * (1 - f) / (1 - albedo * f), tau = depth * (1 - albedo * f);
    const double k = std::sqrt(3 * (1 - w) * (1 - w * g));
    const double p = std::sqrt(3 * (1 - w) / (1 - w * g)), sun_radiance = 1 / air_pi;
    const double under = 4 * (1 - k * k * sun * sun);
    const double alpha = 3 * w * sun_radiance * sun * sun * (1 + g * (1 - w)) / under;
    const double beta = 3 * w * sun_radiance * sun * (1 + 3 * g * (1 - w) * sun * sun) / under;
    // No light comes from above: (1 + 2p/3) C1 + (1 - 2p/3) C2 = alpha + 2 beta / 3.
    const double a1 = 1 + 2 * p / 3, a2 = 1 - 2 * p / 3, a = alpha + 2 * beta / 3;
    // Below, the ground's share goes up.
    const double beam = std::exp(-tau / sun);
    const double b1 = (a2 - ground * a1) * std::exp(-k * tau);
    const double b2 = (a1 - ground * a2) * std::exp(k * tau);
    const double b = beam * (alpha - 2 * beta / 3 + ground * (sun * sun_radiance - a));
    const double c1 = (a * b2 - a2 * b) / (a1 * b2 - a2 * b1);
    const double c2 = (a1 * b - a * b1) / (a1 * b2 - a2 * b1);
    return air_pi * (a1 * c1 * std::exp(-k * tau) + a2 * c2 * std::exp(k * tau) - a * beam) +
           sun * beam;
}

double light_on_the_level(const AirTables& t, const glm::dvec3& to_sun) {
    double sum = t.transmittance.to_disc(2, to_sun.z, disc_radius_rad).g * to_sun.z;
    constexpr int n = 24;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            const double z = std::sqrt((i + 0.5) / n); // equal shares of the level's light
            const glm::dvec3 d = towards(std::asin(z) / air_degree, 360 * (j + 0.5) / n);
            sum += air_pi / (n * n) *
                   air_light(t, 2, d, to_sun, whole_length_m(t.air, 2, d)).radiance.g;
        }
    return sum;
}

// Fog is grey by day, not night. Haze alone, two streams and no more: they say themselves that they are right to some 10 %, the
// table's heights and its light from all around are good for a factor of 2.
TEST(AirTables, fog_by_day_is_as_light_as_two_streams_say) {
    for (const double visibility_m : {200.0, 500.0}) {
        Atmosphere fog;
        fog.visibility_m = visibility_m;
        const AirTables tables(fog, air_pool());
        const double depth = tables.air.aerosol_extinction_per_m().g * fog.aerosol_scale_m;
        const double g = fog.aerosol_asymmetry;
        const double moment = g * 3 * (4 + g * g) / (5 * (2 + g * g));
        for (const double sun_deg : {25.0, 45.0, 80.0}) {
            const double truth =
                light_below_haze(depth, fog.aerosol_albedo, moment, fog.ground_albedo,
                                 std::sin(sun_deg * air_degree));
            const double found = light_on_the_level(tables, towards(sun_deg));
            EXPECT_GT(found, truth / 2) << visibility_m << " m, sun " << sun_deg;
            EXPECT_LT(found, truth * 2) << visibility_m << " m, sun " << sun_deg;
        }
    }
}

TEST(AirTables, air_through_which_one_sees_three_kilometres_is_lit_by_the_series_alone) {
    for (const double visibility_m : {3e3, 5e3, 40e3, visibility_max_m}) {
        Atmosphere air;
        air.visibility_m = visibility_m;
        EXPECT_EQ(two_stream_share(depth_of_air(Air(air))), glm::dvec3(0)) << visibility_m;
    }
}

// In range and dense beyond all that is air: no light is not a number, below zero, or more than the sun sends to a sheet that
// scatters all of it on (a slab on a white ground is 5/4 of that within, by two streams, less what rounding and layers add).
TEST(AirTables, air_that_lets_nothing_through_and_absorbs_nothing_has_light_that_is_a_number) {
    for (const double scale_m : {1200.0, 20e3, 100e3})
        for (const double asymmetry : {-0.95, 0.0, 0.8, 0.95}) {
            Atmosphere air;
            air.visibility_m = visibility_min_m;
            air.aerosol_scale_m = scale_m;
            air.aerosol_asymmetry = asymmetry;
            air.aerosol_albedo = 1;
            air.ground_albedo = 1;
            air.ozone_absorption_per_m = glm::dvec3(0);
            const AirTables t(air, air_pool());
            for (const double height_m : {0.0, 100.0, 3e3, 20e3, 99e3})
                for (double sun_deg = -90; sun_deg <= 90; sun_deg += 15) {
                    const glm::dvec3 again =
                        t.multiple.at(height_m, std::sin(sun_deg * air_degree));
                    const glm::dvec3 d = towards(12, 30);
                    const glm::dvec3 seen = air_light(t, height_m, d, towards(sun_deg),
                                                      whole_length_m(t.air, height_m, d))
                                                .radiance;
                    for (int c = 0; c < 3; ++c) {
                        ASSERT_TRUE(again[c] >= 0 && again[c] < 1.3 / air_pi)
                            << again[c] << " " << scale_m << " " << height_m << " " << sun_deg;
                        ASSERT_TRUE(std::isfinite(seen[c]) && seen[c] >= 0) << seen[c];
                    }
                }
        }
}

} // namespace
} // namespace seaway::client
