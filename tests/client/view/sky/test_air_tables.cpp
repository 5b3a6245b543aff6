// SPDX-License-Identifier: Apache-2.0
// The tables that hang on the medium alone: transmittance and multiple scattering.
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
        const Transfer transfer = transfer_at(air, table, height_m, 0.3);
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(transfer.scattered[c] + transfer.passed[c], 1, 1e-9) << height_m;
    }
}

TEST(AirTables, air_that_absorbs_sends_back_less_than_it_is_given) {
    const AirTables& t = clear_air();
    for (const double height_m : {0.0, 500.0, 8000.0, 60e3}) {
        const Transfer transfer = transfer_at(t.air, t.transmittance, height_m, 0.3);
        for (int c = 0; c < 3; ++c)
            EXPECT_LT(transfer.scattered[c] + transfer.passed[c], 1) << height_m;
    }
}

// Of what is scattered a share is scattered once more, and again: all orders together are the sum of that series, term by
// term, where the sun stands overhead.
TEST(AirTables, the_table_holds_light_of_every_order) {
    const AirTables& t = clear_air();
    for (const int row : {0, 7, 16}) { // of the table: heights between them are interpolated
        const double height_m = t.air.thickness_m * (row / 31.0) * (row / 31.0);
        const Transfer transfer = transfer_at(t.air, t.transmittance, height_m, 1.0);
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

} // namespace
} // namespace seaway::client
