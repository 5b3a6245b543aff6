// SPDX-License-Identifier: Apache-2.0
// Water by its optical type: colours in the order that oceanography knows, and figures of others for the same waters.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "client/view/sky/look.h"
#include "client/view/water_optics.h"

namespace seaway::client {
namespace {

using sea::WaterType;

constexpr double no_floor_m = std::numeric_limits<double>::infinity();

std::array<WaterType, 10> jerlov_types() {
    std::array<WaterType, 10> types{};
    for (std::size_t i = 0; i < types.size(); ++i)
        types[i] = static_cast<WaterType>(i + 1);
    return types;
}

glm::dvec3 deep_colour(WaterType type) {
    return water_look({type}, no_floor_m, 0).reflectance;
}

double at_nm(const WaterSpectrum& spectrum, double nm) {
    const double at = (nm - 400) / 25;
    const auto low = static_cast<std::size_t>(at);
    const double t = at - static_cast<double>(low);
    return (1 - t) * spectrum[low] + t * spectrum[std::min(low + 1, spectrum.size() - 1)];
}

// Three rows of table XXVII typed a second time, so that a slip in the code's table is seen.
TEST(WaterOptics, attenuation_is_jerlovs) {
    const WaterSpectrum clear{0.027, 0.022, 0.019, 0.018, 0.027, 0.043, 0.063,
                              0.089, 0.235, 0.305, 0.36,  0.42,  0.56};
    const WaterSpectrum between{0.185, 0.16,  0.135, 0.116, 0.115, 0.116, 0.12,
                                0.148, 0.295, 0.375, 0.445, 0.52,  0.66};
    const WaterSpectrum turbid{2.4,  1.9, 1.6,  1.23, 0.99, 0.78, 0.63,
                               0.58, 0.6, 0.65, 0.76, 0.92, 1.1};
    EXPECT_EQ(diffuse_attenuation_per_m(WaterType::jerlov_1), clear);
    EXPECT_EQ(diffuse_attenuation_per_m(WaterType::jerlov_3), between);
    EXPECT_EQ(diffuse_attenuation_per_m(WaterType::coastal_9), turbid);
    EXPECT_EQ(diffuse_attenuation_per_m(WaterType::coastal_5)[6], 0.3);
    EXPECT_EQ(diffuse_attenuation_per_m(WaterType::north_sea), between);
}

// The classification is one by light that gets through: at each wavelength a later type takes no less, but for 1C beside
// III, which are an ocean and a coast (a hundredth, in the red).
TEST(WaterOptics, each_type_takes_more_light_than_the_one_before) {
    const auto types = jerlov_types();
    for (std::size_t i = 1; i < types.size(); ++i)
        for (std::size_t band = 0; band < water_bands; ++band)
            EXPECT_GE(diffuse_attenuation_per_m(types[i])[band],
                      diffuse_attenuation_per_m(types[i - 1])[band] - 0.011)
                << i << " at " << water_band_nm(band);
}

TEST(WaterOptics, blue_falls_from_each_type_to_the_next_and_the_clearest_is_the_bluest) {
    const auto types = jerlov_types();
    const auto blueness = [](const glm::dvec3& c) { return c.b / (c.r + c.g + c.b); };
    for (std::size_t i = 1; i < types.size(); ++i) {
        EXPECT_LT(deep_colour(types[i]).b, deep_colour(types[i - 1]).b) << i;
        EXPECT_LT(blueness(deep_colour(types[i])), blueness(deep_colour(types[0]))) << i;
    }
    for (const WaterType type : {WaterType::jerlov_1, WaterType::jerlov_1a, WaterType::jerlov_1b})
        EXPECT_GT(deep_colour(type).b, 2 * deep_colour(type).g);
}

TEST(WaterOptics, coasts_are_green_and_the_most_turbid_one_is_brown) {
    for (const WaterType type :
         {WaterType::coastal_1, WaterType::coastal_3, WaterType::coastal_5, WaterType::coastal_7}) {
        const glm::dvec3 c = deep_colour(type);
        EXPECT_GT(c.g, c.r) << static_cast<int>(type);
        EXPECT_GT(c.g, c.b) << static_cast<int>(type);
    }
    const glm::dvec3 brown = deep_colour(WaterType::coastal_9);
    EXPECT_GT(brown.r, brown.g);
    EXPECT_GT(brown.g, 2 * brown.b);
}

TEST(WaterOptics, no_water_is_black_in_green_or_sends_back_a_fifth) {
    for (const auto& [name, type] : sea::water_types)
        for (const double depth_m : {no_floor_m, 5.0}) {
            const WaterLook look = water_look({type}, depth_m, 1);
            EXPECT_GT(look.reflectance.g, 0) << name;
            for (int c = 0; c < 3; ++c) {
                EXPECT_GE(look.reflectance[c], 0) << name;
                EXPECT_LE(look.reflectance[c], 0.2) << name;
                EXPECT_GT(look.attenuation_per_m[c], 0) << name;
                EXPECT_GE(look.crest[c], 0) << name;
                EXPECT_LE(look.bubbles[c], 1) << name;
            }
        }
}

// Blue over green as satellites see it tells Kd(490): NASA's KD2S (reprocessing of 2009, fitted to measurements in all
// oceans). Beyond 3C the law has no waters. A third is three standard errors of that law.
TEST(WaterOptics, blue_over_green_is_what_satellites_see_over_such_water) {
    for (const WaterType type : jerlov_types()) {
        if (type > WaterType::coastal_3)
            break;
        WaterSpectrum above = reflectance_below(type);
        std::transform(above.begin(), above.end(), above.begin(), reflectance_above);
        const double x = std::log10(at_nm(above, 489) / at_nm(above, 555));
        const double kd =
            std::pow(10, -0.8515 + x * (-1.8263 + x * (1.8714 + x * (-2.4414 - 1.0690 * x)))) +
            0.0166;
        EXPECT_NEAR(kd / at_nm(diffuse_attenuation_per_m(type), 490), 1, 0.34)
            << static_cast<int>(type);
    }
}

// Scattering that Solonenko and Mobley (2015) found for these waters by a fit to whole spectra, at about 550 nm, 1/m, as
// Droske and others (The Path of Water, 2023) give it.
TEST(WaterOptics, particles_scatter_as_others_found_for_coasts) {
    const std::pair<WaterType, double> found[] = {{WaterType::coastal_1, 0.372},
                                                  {WaterType::coastal_3, 1.071},
                                                  {WaterType::coastal_5, 1.382},
                                                  {WaterType::coastal_7, 2.394},
                                                  {WaterType::coastal_9, 3.180}};
    for (const auto& [type, b] : found)
        EXPECT_NEAR(particle_scattering_per_m(pigment_mgpm3(diffuse_attenuation_per_m(type)[6])) /
                        b,
                    1, 0.25)
            << static_cast<int>(type);
}

// Pure sea water of 6S's routine: C = 0, Kw of type I's bands. By hand: bb/Kd = 0.00095/0.063, R = 0.00554.
TEST(WaterOptics, the_clearest_water_has_no_particles) {
    EXPECT_EQ(pigment_mgpm3(diffuse_attenuation_per_m(WaterType::jerlov_1)[6]), 0);
    const double r = reflectance_below(WaterType::jerlov_1)[6];
    const double u = 0.90 * (1 - r) / (1 + 2.25 * r);
    EXPECT_NEAR(r, 0.33 / u * 0.00095 / 0.063, 1e-12);
    EXPECT_NEAR(r, 0.0056, 1e-4);
}

TEST(WaterOptics, white_is_white_and_light_that_went_nowhere_is_whole) {
    WaterSpectrum white{};
    white.fill(1);
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(colour_of(white)[c], 1, 1e-12);
    // Green is hardly blue or red: within sRGB.
    WaterSpectrum one{};
    one[6] = 1;
    EXPECT_GT(colour_of(one).g, 5 * colour_of(one).b);
}

// By colour as by spectrum: after the way it is made for, and near it.
TEST(WaterOptics, attenuation_by_colour_is_that_of_the_spectrum) {
    for (const WaterType type : jerlov_types()) {
        const WaterSpectrum per_m = diffuse_attenuation_per_m(type);
        for (const double path_m : {1.0, 4.0}) {
            const glm::dvec3 k = attenuation_rgb_per_m(type, path_m);
            WaterSpectrum left{};
            for (std::size_t i = 0; i < water_bands; ++i)
                left[i] = std::exp(-per_m[i] * path_m);
            for (int c = 0; c < 3; ++c) // light is interpolated there, attenuation here
                EXPECT_NEAR(std::exp(-k[c] * path_m), colour_of(left)[c], 0.01)
                    << static_cast<int>(type) << " channel " << c << " after " << path_m;
        }
        // Green lies within the range of the spectrum around it.
        const double k = attenuation_rgb_per_m(type, 4).g;
        EXPECT_GT(k, *std::min_element(per_m.begin() + 4, per_m.begin() + 9));
        EXPECT_LT(k, *std::max_element(per_m.begin() + 4, per_m.begin() + 9));
    }
}

// Of light that has lost all but one hue a colour comes to nothing and below; what is said of water then is what it did on a
// shorter way: no leap where the colour goes, and nothing that no wavelength loses.
TEST(WaterOptics, attenuation_by_colour_does_not_jump_with_the_way_and_is_one_of_the_spectrum) {
    for (const WaterType type : jerlov_types()) {
        const WaterSpectrum per_m = diffuse_attenuation_per_m(type);
        const double most = *std::max_element(per_m.begin(), per_m.end());
        glm::dvec3 before = attenuation_rgb_per_m(type, 0.25);
        for (double path_m = 0.25; path_m < 64; path_m *= 1.01) {
            const glm::dvec3 k = attenuation_rgb_per_m(type, path_m);
            for (int c = 0; c < 3; ++c) {
                EXPECT_NEAR(k[c] / before[c], 1, 0.015)
                    << static_cast<int>(type) << " channel " << c << " after " << path_m;
                EXPECT_GT(k[c], 0.009) << "half of the clearest water's least: of blue in type I";
                EXPECT_LT(k[c], most) << static_cast<int>(type) << " channel " << c;
            }
            before = k;
        }
    }
    EXPECT_NEAR(attenuation_rgb_per_m(WaterType::coastal_9, 4).b, 1.9, 0.1);
    EXPECT_NEAR(attenuation_rgb_per_m(WaterType::jerlov_1, 10).r, 0.42, 0.05);
}

TEST(WaterOptics, a_way_in_the_deepest_ocean_has_an_attenuation) {
    for (const WaterType type : jerlov_types())
        for (int c = 0; c < 3; ++c) {
            const double k = attenuation_rgb_per_m(type, 22e3)[c];
            EXPECT_TRUE(k > 0.01 && k < 2.4)
                << static_cast<int>(type) << " channel " << c << ": " << k;
        }
}

// 45 degrees in air are 31.9 in water.
TEST(WaterOptics, coastal_attenuation_is_of_slanting_light_and_oceanic_of_light_from_the_zenith) {
    for (const WaterType type : {WaterType::north_sea, WaterType::jerlov_1, WaterType::jerlov_3})
        EXPECT_EQ(slant_of_attenuation(type), 1);
    for (const WaterType type : {WaterType::coastal_1, WaterType::coastal_9})
        EXPECT_NEAR(slant_of_attenuation(type),
                    1 / std::cos(std::asin(std::sin(std::numbers::pi / 4) / 1.34)), 0.003);
}

// The default is what was drawn before waters had types, to the bit; its crests and bubbles are a rule for others.
TEST(WaterOptics, the_north_sea_stays_as_it_was_and_other_waters_follow_its_rule) {
    const WaterLook look = water_look({}, no_floor_m, 0);
    EXPECT_EQ(look.reflectance, glm::dvec3(0.008, 0.024, 0.026));
    EXPECT_EQ(look.crest, glm::dvec3(0.012, 0.055, 0.048));
    EXPECT_EQ(look.bubbles, glm::dvec3(0.10, 0.32, 0.30));
    const WaterLook like = water_look({WaterType::jerlov_3}, no_floor_m, 0);
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(like.crest[c] / look.crest[c], 1, 0.125) << c;
        EXPECT_NEAR(like.bubbles[c] / look.bubbles[c], 1, 0.125) << c;
    }
    const WaterLook clear = water_look({WaterType::jerlov_1}, no_floor_m, 0);
    const WaterLook stained = water_look({WaterType::coastal_5}, no_floor_m, 0);
    EXPECT_GT(clear.crest.b, clear.crest.g) << "blue crests in clear water";
    EXPECT_GT(stained.crest.g, 2 * stained.crest.b) << "green ones on a coast";
    EXPECT_GT(clear.bubbles.b, clear.bubbles.r);
}

TEST(WaterOptics, a_floor_is_seen_where_light_comes_back_from_it) {
    EXPECT_FALSE(water_look({}, no_floor_m, 5).floor_seen);
    EXPECT_FALSE(water_look({}, 120, 6).floor_seen);
    EXPECT_TRUE(water_look({}, 2, 0.4).floor_seen);
    EXPECT_TRUE(water_look({}, 2, 10).floor_seen) << "waves higher than the water is deep";
    const WaterType clear = WaterType::jerlov_1, turbid = WaterType::coastal_9;
    EXPECT_TRUE(water_look({clear}, 30, 1).floor_seen) << "blue comes back from 30 m in the ocean";
    EXPECT_FALSE(water_look({turbid}, 15, 1).floor_seen);
    EXPECT_FALSE(water_look({clear, {0, 0, 0}}, 2, 0).floor_seen) << "a black floor";
}

// The clearest water leaves exp(-0.018 2 d) of the best of light: 1e-16 from 1000 m, where nothing of any floor is seen,
// even where deep water has a colour without red.
TEST(WaterOptics, no_floor_is_seen_a_kilometre_down_in_any_water) {
    for (const auto& [name, type] : sea::water_types)
        for (const double depth_m : {1000.0, 4000.0, 11000.0})
            EXPECT_FALSE(water_look({type, {1, 1, 1}}, depth_m, 20).floor_seen)
                << name << " at " << depth_m;
}

// And where it adds a thousandth to the brightness of deep water it is: what is left out is less than a ten thousandth.
TEST(WaterOptics, a_floor_that_adds_a_thousandth_is_seen_in_every_water) {
    for (const auto& [name, type] : sea::water_types)
        for (double depth_m = 2; depth_m < 400; depth_m *= 1.2) {
            const WaterLook look = water_look({type}, depth_m, 0);
            const glm::dvec3 added =
                look.floor * glm::exp(-look.floor_attenuation_per_m * 2.0 * depth_m);
            EXPECT_TRUE(look.floor_seen ||
                        luminance_of(added) <= 1e-3 * luminance_of(look.reflectance))
                << name << " at " << depth_m;
        }
}

// Two metres of clear water over sand: turquoise - blue and green far above red, and brighter than the deep.
TEST(WaterOptics, two_metres_over_sand_are_turquoise) {
    for (const WaterType type : {WaterType::jerlov_1b, WaterType::jerlov_2}) {
        const WaterLook look = water_look({type}, 2, 0.3);
        const glm::dvec3 left = glm::exp(-look.floor_attenuation_per_m * 4.0);
        const glm::dvec3 seen = look.reflectance + (look.floor - look.reflectance) * left;
        EXPECT_GT(seen.g, 2 * seen.r) << static_cast<int>(type); // a quarter of red comes back
        EXPECT_GT(seen.b, 2 * seen.r) << static_cast<int>(type);
        EXPECT_NEAR(seen.b / seen.g, 0.9, 0.25) << static_cast<int>(type);
        EXPECT_GT(seen.g, 8 * look.reflectance.g) << static_cast<int>(type);
    }
}

} // namespace
} // namespace seaway::client
