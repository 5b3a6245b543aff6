// SPDX-License-Identifier: Apache-2.0
// Three wavelengths and a matrix stand for the spectrum of light that has come through air.
#include <algorithm>
#include <array>

#include "client/view/sky/eye_curves.h"
#include "tests/client/view/sky/air_fixture.h"

namespace seaway::client {
namespace {

constexpr std::size_t bands = 47;

// Middle of band i: 365 + 10 i nm. Sun outside the air, W/m2/nm (ASTM G-173), and ozone's cross section, m2
// (University of Bremen, 233 K), both as Bruneton 2017 has averaged them.
constexpr std::array<double, bands> sun_of_band{
    1.11776, 1.14259, 1.01249, 1.14716, 1.72765, 1.73054, 1.6887,  1.61253, 1.91198, 2.03474,
    2.02042, 2.02212, 1.93377, 1.95809, 1.91686, 1.8298,  1.8685,  1.8931,  1.85149, 1.8504,
    1.8341,  1.8345,  1.8147,  1.78158, 1.7533,  1.6965,  1.68194, 1.64654, 1.6048,  1.52143,
    1.55622, 1.5113,  1.474,   1.4482,  1.41018, 1.36775, 1.34188, 1.31429, 1.28303, 1.26758,
    1.2367,  1.2082,  1.18737, 1.14683, 1.12362, 1.1058,  1.07124};
constexpr std::array<double, bands> ozone_of_band{
    1.18e-27,  2.182e-28, 2.818e-28, 6.636e-28, 1.527e-27, 2.763e-27, 5.52e-27,  8.451e-27,
    1.582e-26, 2.316e-26, 3.669e-26, 4.924e-26, 7.752e-26, 9.016e-26, 1.48e-25,  1.602e-25,
    2.139e-25, 2.755e-25, 3.091e-25, 3.5e-25,   4.266e-25, 4.672e-25, 4.398e-25, 4.701e-25,
    5.019e-25, 4.305e-25, 3.74e-25,  3.215e-25, 2.662e-25, 2.238e-25, 1.852e-25, 1.473e-25,
    1.209e-25, 9.423e-26, 7.455e-26, 6.566e-26, 5.105e-26, 4.15e-26,  4.228e-26, 3.237e-26,
    2.451e-26, 2.801e-26, 2.534e-26, 1.624e-26, 1.465e-26, 2.078e-26, 1.383e-26};

/// A way through `air` vertical atmospheres of molecules and `ozone` of ozone.
struct Way {
    const char* name;
    double air, ozone;
    int scattered; ///< times by molecules
    double tolerance = 0.04;
};

/// Relative to the sun outside the air, which is white.
glm::dvec3 colour_of(const Way& way) {
    glm::dvec3 sum(0), white(0);
    for (std::size_t i = 0; i < bands; ++i) {
        const double nm = 365 + 10 * static_cast<double>(i);
        const double depth = 1.24062e-6 * std::pow(nm / 1000, -4) * 8000;
        const double ozone = ozone_of_band[i] * 300 * 2.687e20;
        const double left =
            std::exp(-way.air * depth - way.ozone * ozone) * std::pow(depth, way.scattered);
        sum += sun_of_band[i] * eye_curves(nm) * left;
        white += sun_of_band[i] * eye_curves(nm);
    }
    return sum / white;
}

TEST(Colours, three_wavelengths_give_the_colour_of_the_spectrum) {
    const Atmosphere air;
    for (const Way& way : {Way{"sun high", 1, 1, 0}, Way{"sun low", 10, 8, 0, 0.06},
                           Way{"sun at the horizon", 25, 12, 0, 0.1}, Way{"blue sky", 0.5, 0.5, 1},
                           Way{"sky at sunset", 8, 10, 1}, Way{"blue hour", 4, 20, 1}}) {
        const glm::dvec3 depth = air.rayleigh_scattering_per_m * air.rayleigh_scale_m;
        const glm::dvec3 ozone = air.ozone_absorption_per_m * air.ozone_half_width_m;
        const glm::dvec3 left = glm::exp(-way.air * depth - way.ozone * ozone) *
                                glm::pow(depth, glm::dvec3(way.scattered));
        const glm::dvec3 found = sunlight_klx(left) / 128.0, truth = colour_of(way);
        const double brightest = std::max({truth.r, truth.g, truth.b});
        for (int c = 0; c < 3; ++c) // what lies outside of sRGB is cut
            EXPECT_NEAR(found[c], std::max(truth[c], 0.0), way.tolerance * brightest)
                << way.name << " " << c;
    }
}

TEST(Colours, the_sun_outside_the_air_is_white_and_128_klx) {
    const glm::dvec3 white = sunlight_klx(glm::dvec3(1));
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(white[c], 128, 0.02);
}

} // namespace
} // namespace seaway::client
