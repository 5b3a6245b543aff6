// SPDX-License-Identifier: Apache-2.0
// The light of a moment: sun, moon, sky and their strength; what is kept from moment to moment.
#include <algorithm>

#include "client/view/sky/sky.h"
#include "tests/client/view/sky/air_fixture.h"

namespace seaway::client {
namespace {

Sky sky_of(SkyMaker& maker, const Look& look, double hour, const Eye& eye = {}) {
    Result<Sky> made = maker.make(look, heavens_at_hour(hour), eye);
    EXPECT_TRUE(made) << made.error().message;
    return *made;
}

TEST(Sky, noon_is_blue_above_pale_at_the_horizon_and_as_bright_as_daylight_is) {
    const Sky sky(sun_direction(12));
    const glm::dvec3 zenith = sky.radiance(air_pi / 2, 0);
    const glm::dvec3 horizon = sky.radiance(0.001, air_pi);
    EXPECT_GT(zenith.b, 2 * zenith.r);
    EXPECT_LT(horizon.b / horizon.r, zenith.b / zenith.r / 1.5);
    EXPECT_GT(horizon.g, zenith.g);
    // IES 1984: clear sky, sun 45 degrees high: 60 to 85 klx on the ground, 10 to 20 of them from the sky.
    const double sun = sky.sun_irradiance().g * sky.sun_direction().z;
    EXPECT_GT(sun + sky.sky_irradiance().g, 60);
    EXPECT_LT(sun + sky.sky_irradiance().g, 95);
    EXPECT_GT(sky.sky_irradiance().g, 6);
    EXPECT_LT(sky.sky_irradiance().g, 20);
}

// Twilight is blue: with red at 680 nm, which ozone lets pass, it was purple.
TEST(Sky, the_zenith_of_twilight_is_blue_and_the_suns_side_of_the_horizon_red) {
    for (const double hour : {18.0, 18.3, 18.6}) {
        const Sky sky(sun_direction(hour));
        const glm::dvec3 zenith = sky.radiance(air_pi / 2, 0);
        EXPECT_GT(zenith.g, zenith.r) << hour;
        EXPECT_GT(zenith.b, zenith.g) << hour;
        double reddest = 0; // haze in the shadow lies before the last degree
        for (const double elevation : {0.02, 0.04, 0.06, 0.09}) {
            const glm::dvec3 low = sky.radiance(elevation, 0);
            reddest = std::max(reddest, low.r / low.b);
        }
        EXPECT_GT(reddest, 1.5) << hour;
    }
}

TEST(Sky, a_low_sun_is_red_and_its_side_of_the_sky_is_the_bright_one) {
    const Sky sky(sun_direction(17.6));
    EXPECT_GT(sky.sun_irradiance().r, 2 * sky.sun_irradiance().b);
    EXPECT_GT(sky.radiance(0.1, 0).g, 2 * sky.radiance(0.1, air_pi / 2).g);
}

TEST(Sky, darkens_through_twilight_and_never_turns_black) {
    double last = 1e9;
    for (const double hour : {17.0, 18.0, 18.3, 18.8, 20.0, 24.0}) {
        const double white = Sky(sun_direction(hour)).white_radiance();
        EXPECT_LE(white, last) << hour;
        EXPECT_GT(white, 0) << hour;
        last = white;
    }
}

// Full moon 45 degrees high: 0.2 lx on the level; without it a dark sky's half a millilux.
TEST(Sky, night_is_lit_by_the_moon_and_without_it_by_the_airs_own_glow) {
    SkyMaker maker;
    const double day = sky_of(maker, {}, 12).white_radiance();
    const Sky moonlit = sky_of(maker, {}, 24);
    EXPECT_LT(moonlit.white_radiance(), 1e-5 * day);
    EXPECT_NEAR(luminance_of(moonlit.light_irradiance()), 0.25e-3, 0.1e-3);
    EXPECT_NEAR(moonlit.light_direction().z, std::sqrt(0.5), 1e-12);
    EXPECT_EQ(moonlit.sun_irradiance(), glm::dvec3(0));
    // The moonlit sky is blue as the day's, and brightest around the moon.
    const glm::dvec3 zenith = moonlit.behind({0, 0, 1});
    EXPECT_GT(zenith.b, 1.5 * zenith.r);
    EXPECT_GT(moonlit.behind(glm::normalize(glm::dvec3(0, -1, 0.9))).g, 2 * zenith.g);
    Heavens moonless = heavens_at_hour(24);
    moonless.moon_phase_rad = air_pi;
    const Result<Sky> dark = maker.make({}, moonless, {});
    // 22 magnitudes a square arc second are 1.7e-4 cd/m2 (Falchi 2016); 0.1 magnitudes.
    EXPECT_NEAR(luminance_of(dark->behind({0, 0, 1})) / 1.7e-7, 1, 0.1);
    const double lux = 1e3 * air_pi * dark->white_radiance();
    EXPECT_GT(lux, 2e-4);
    EXPECT_LT(lux, 2e-3);
    EXPECT_LT(dark->white_radiance(), 1e-5 * day);
}

// At the end of astronomical twilight scattered sunlight gives 0.0006 lx, less than what is above the air (AMS Glossary of
// Meteorology): from then on night does not darken.
TEST(Sky, night_is_reached_when_the_sun_is_eighteen_degrees_down) {
    SkyMaker maker;
    const auto lux = [&](double sun_deg) {
        Heavens night;
        night.to_sun = towards(sun_deg);
        night.to_moon = {0, 0, -1};
        night.moon_phase_rad = air_pi;
        return 1e3 * luminance_of(maker.make({}, night, {})->sky_irradiance());
    };
    const double dark = lux(-40);
    EXPECT_LT(lux(-18), 2 * dark);
    EXPECT_GT(lux(-12), 5 * dark);
    EXPECT_NEAR(std::log10(dark), std::log10(6e-4), 0.3);
}

// A full moon has magnitude -12.73 (Allen 1973), 0.31 lx above the air; 0.2 to 0.3 are measured of it high in a clear
// sky (Kyba 2017, Astronomy and Geophysics 58: 0.32 at the most, in the tropics at its nearest).
TEST(Sky, a_high_full_moon_gives_a_quarter_of_a_lux) {
    SkyMaker maker;
    Heavens night;
    night.to_sun = towards(-80);
    night.to_moon = towards(80);
    const Result<Sky> full = maker.make({}, night, {});
    ASSERT_TRUE(full) << full.error().message;
    EXPECT_NEAR(1e3 * luminance_of(full->light_irradiance()), 0.25, 0.05);
    night.moon_phase_rad = air_pi / 2;
    const Result<Sky> half = maker.make({}, night, {});
    EXPECT_NEAR(luminance_of(half->light_irradiance()) / luminance_of(full->light_irradiance()),
                std::pow(10, -0.4 * 2.63), 0.005);
}

// What is strong of the sun is multiplied last: doubling it doubles every number, to the last bit.
TEST(Sky, light_is_exactly_linear_in_the_strength_of_the_sun) {
    SkyMaker maker;
    Look twice;
    twice.sun_strength = 2;
    twice.clouds.coverage = 0.5;
    Look once = twice;
    once.sun_strength = 1;
    for (const double hour : {9.0, 17.9}) {
        const Sky one = sky_of(maker, once, hour), two = sky_of(maker, twice, hour);
        EXPECT_EQ(two.sun_irradiance(), 2.0 * one.sun_irradiance());
        for (const double elevation : {0.05, 0.6}) {
            const glm::dvec3 a = one.radiance(elevation, 1), b = two.radiance(elevation, 1);
            for (int c = 0; c < 3; ++c) // the airglow is not the sun's: 1e-7 kcd/m2
                EXPECT_NEAR(b[c], 2 * a[c], 5e-7);
        }
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(two.sky_irradiance()[c], 2 * one.sky_irradiance()[c], 2e-6);
    }
}

// A white sheet on the sea sends pi times less than falls on it: of a low sun's beam the sine of its height.
TEST(Sky, a_white_sheet_is_lit_by_the_sky_and_by_the_share_of_the_beam_that_falls_on_it) {
    const Sky sky(sun_direction(17));
    const double sine = std::sin(air_pi / 12) * std::sqrt(0.5);
    ASSERT_NEAR(sky.sun_direction().z, sine, 1e-12);
    EXPECT_NEAR(sky.white_radiance(),
                (luminance_of(sky.sky_irradiance()) + sine * luminance_of(sky.sun_irradiance())) /
                    air_pi,
                1e-9);
}

// What the sea shows below the horizon is darker than the sky that it mirrors, and never its mirror image:
// four fifths of light from straight above enter the water, and little comes back.
TEST(Sky, below_the_horizon_is_the_sea_and_not_the_sky_again) {
    const Sky sky(sun_direction(12));
    for (const double below : {0.05, 0.3, 1.0, 1.5})
        for (const double azimuth : {0.4, 2.0}) {
            const double up = luminance_of(sky.radiance(below, azimuth));
            const double down = luminance_of(sky.radiance(-below, azimuth));
            EXPECT_LT(down, 0.75 * up) << below;
            EXPECT_GT(down, 0.005 * up) << below;
        }
}

TEST(Sky, blur_keeps_the_light_and_a_white_world_stays_white) {
    Dome dome(shaders::sky_columns, shaders::sky_rows, 1.1, 0);
    for (glm::vec3& texel : dome.texels())
        texel = glm::vec3(0.7f);
    const BlurredDome white(dome, air_pool());
    for (int m = 0; m < BlurredDome::levels; ++m)
        for (const glm::vec3& texel : white.level(m))
            ASSERT_NEAR(texel.g, 0.7f, 1e-5f) << m;
    // A lamp of the size of a lobe: its light spreads, and its sum over the sphere stays.
    for (int y = 0; y < dome.rows(); ++y)
        for (int x = 0; x < dome.columns(); ++x)
            dome.at(x, y) =
                glm::vec3(glm::dot(dome.direction(x, y), towards(35, 10)) > 0.99 ? 1 : 0);
    const BlurredDome lamp(dome, air_pool());
    const auto sum = [&](double blur) {
        double light = 0;
        constexpr int steps = 240;
        for (int i = 0; i < steps; ++i)
            for (int j = 0; j < 2 * steps; ++j) {
                const double z = -1 + 2 * (i + 0.5) / steps, level = std::sqrt(1 - z * z);
                const double turn = air_pi * (j + 0.5) / steps;
                light += lamp.sample({level * std::cos(turn), level * std::sin(turn), z}, blur).g;
            }
        return light / (2 * steps * steps);
    };
    for (const double blur : {0.04, 0.1, 0.2})
        EXPECT_NEAR(sum(blur) / sum(0), 1, 0.05) << blur;
    // The widest lobes have a dozen texels around: enough for a sky, not for a lamp.
    EXPECT_NEAR(sum(0.64) / sum(0), 1, 0.15);
    // Blurred by s, a lamp of radius a has about a^2 / (2 s^2) of its radiance left in the middle.
    EXPECT_NEAR(lamp.sample(towards(35, 10), 0.32).g, 0.02 / (2 * 0.32 * 0.32), 0.025);
}

TEST(Sky, tables_are_made_once_for_a_hundred_frames_of_one_sun) {
    SkyMaker maker;
    const Look look;
    const Sky first = sky_of(maker, look, 14, {.height_m = 12});
    const SkyMaker::Counts once{1, 1, 1, 1};
    EXPECT_EQ(maker.counts(), once);
    for (int frame = 0; frame < 100; ++frame) {
        // A camera that bobs by centimetres and moves along the sea.
        const Sky next = sky_of(maker, look, 14,
                                {.height_m = 12 + 0.03 * std::sin(frame), .east_m = 3.0 * frame});
        EXPECT_EQ(next.texels(), first.texels());
    }
    EXPECT_EQ(maker.counts(), once);
    Look stronger = look;
    stronger.sun_strength *= 2;
    EXPECT_NE(sky_of(maker, stronger, 14, {.height_m = 12}).texels(), first.texels());
    EXPECT_EQ(maker.counts(), (SkyMaker::Counts{1, 1, 1, 2}))
        << "it comes last, and is in no table";
    sky_of(maker, look, 14, {.height_m = 300});
    EXPECT_EQ(maker.counts(), (SkyMaker::Counts{1, 1, 2, 3})) << "another height: the eye's alone";
    sky_of(maker, look, 14.1, {.height_m = 300});
    EXPECT_EQ(maker.counts(), (SkyMaker::Counts{1, 2, 3, 4})) << "another sun: not the medium's";
    Look hazy = look;
    hazy.air.visibility_m = 8e3;
    sky_of(maker, hazy, 14.1, {.height_m = 300});
    EXPECT_EQ(maker.counts(), (SkyMaker::Counts{2, 3, 4, 5}));
}

TEST(Sky, what_a_maker_kept_changes_nothing) {
    SkyMaker kept;
    Look look;
    for (const double hour : {9.0, 9.5, 19.0}) {
        look.clouds.coverage = hour < 9.2 ? 0.7 : 0.2;
        const Eye eye{.height_m = 40 * hour, .east_m = 1000};
        SkyMaker fresh;
        EXPECT_EQ(*sky_of(kept, look, hour, eye).texels(),
                  *sky_of(fresh, look, hour, eye).texels());
    }
}

} // namespace
} // namespace seaway::client
