// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include <gtest/gtest.h>

#include "client/view/sky.h"
#include "sea/basics/constants.h"

namespace seaway::client {
namespace {

using sea::pi;

TEST(Sky, the_sun_rises_in_the_east_and_stands_45_degrees_high_in_the_south_at_noon) {
    EXPECT_NEAR(sun_direction(6).x, 1, 1e-12);
    EXPECT_NEAR(sun_direction(12).y, -std::sqrt(0.5), 1e-12);
    EXPECT_NEAR(sun_direction(12).z, std::sqrt(0.5), 1e-12);
    EXPECT_NEAR(sun_direction(18).x, -1, 1e-12);
    EXPECT_LT(sun_direction(0).z, 0);
}

TEST(Sky, noon_is_blue_above_pale_at_the_horizon_and_as_bright_as_daylight_is) {
    const Sky sky(sun_direction(12));
    const glm::dvec3 zenith = sky.radiance(pi / 2, 0);
    const glm::dvec3 horizon = sky.radiance(0, pi);
    EXPECT_GT(zenith.b, 2 * zenith.r);
    EXPECT_LT(horizon.b / horizon.r, zenith.b / zenith.r / 2);
    EXPECT_GT(horizon.g, zenith.g);
    // IES: clear sky, sun 45 degrees high: 60 to 85 klx on the ground, 10 to 20 of them from the
    // sky.
    const double sun = sky.sun_irradiance().g * sky.sun_direction().z;
    EXPECT_GT(sun + sky.sky_irradiance().g, 60);
    EXPECT_LT(sun + sky.sky_irradiance().g, 95);
    EXPECT_GT(sky.sky_irradiance().g, 6);
    EXPECT_LT(sky.sky_irradiance().g, 20);
}

TEST(Sky, a_low_sun_is_red_and_its_side_of_the_sky_is_the_bright_one) {
    const Sky sky(sun_direction(17.6));
    EXPECT_GT(sky.sun_irradiance().r, 2 * sky.sun_irradiance().b);
    EXPECT_GT(sky.radiance(0.1, 0).g, 2 * sky.radiance(0.1, pi / 2).g);
}

// The disk sets behind a line: as much of its light is left as of its height. The air that the light
// passes is that of the horizon until all of it is gone.
TEST(Sky, a_setting_sun_loses_light_as_its_disk_goes_under) {
    const auto green = [](double radii) {
        const double elevation = radii * Sky::sun_radius_rad;
        return Sky({std::cos(elevation), 0, std::sin(elevation)}).sun_irradiance().g;
    };
    EXPECT_EQ(green(-1), 0);
    EXPECT_EQ(green(-3), 0);
    EXPECT_GT(green(0), 0);
    for (const double radii : {-0.9, -0.5, -0.25})
        EXPECT_NEAR(green(radii) / green(0), 1 + radii, 1e-6) << radii;
}

TEST(Sky, is_smooth_where_view_and_sun_are_equally_high) {
    const Sky sky(sun_direction(15));
    const double elevation = std::asin(sky.sun_direction().z);
    const double at = sky.radiance(elevation, 1.0).g;
    // The formula is 0/0 there; its slope is below 2 of its value a radian.
    for (const double step : {-1e-3, -1e-5, 1e-5, 1e-3})
        EXPECT_NEAR(sky.radiance(elevation + step, 1.0).g / at, 1, 2 * std::abs(step) + 1e-6);
}

TEST(Sky, darkens_through_twilight_and_never_turns_black) {
    double last = 1e9;
    for (const double hour : {17.0, 18.0, 18.3, 18.8, 20.0}) {
        const double white = Sky(sun_direction(hour)).white_radiance();
        EXPECT_LT(white, last) << hour;
        EXPECT_GT(white, 0) << hour;
        last = white;
    }
}

// A white sheet on the sea sends pi times less than falls on it: of a low sun's beam the sine of its
// height, 0.25 at 17 h (15 degrees above the plane that is tilted by 45).
TEST(Sky, a_white_sheet_is_lit_by_the_sky_and_by_the_share_of_the_beam_that_falls_on_it) {
    const Sky sky(sun_direction(17));
    const double sine = std::sin(pi / 12) * std::sqrt(0.5);
    ASSERT_NEAR(sky.sun_direction().z, sine, 1e-12);
    const auto luminance = [](const glm::dvec3& c) {
        return 0.2126 * c.r + 0.7152 * c.g + 0.0722 * c.b;
    };
    EXPECT_NEAR(sky.white_radiance(),
                (luminance(sky.sky_irradiance()) + sine * luminance(sky.sun_irradiance())) / pi,
                1e-9);
}

TEST(Sky, the_map_holds_the_radiance_and_its_mips_the_means) {
    const Sky sky(sun_direction(15));
    const std::vector<float> map = sky.map();
    constexpr int n = Sky::map_width;
    const int x = 40, y = 90;
    const double root = static_cast<double>(y) / (n - 1);
    const glm::dvec3 truth = sky.radiance(root * root * pi / 2, x * pi / (n - 1));
    for (int c = 0; c < 3; ++c)
        EXPECT_FLOAT_EQ(map[static_cast<std::size_t>(4 * (y * n + x) + c)],
                        static_cast<float>(truth[c]));
    double sum = 0;
    for (std::size_t i = 1; i < 4u * n * n; i += 4)
        sum += static_cast<double>(map[i]);
    EXPECT_NEAR(static_cast<double>(map[map.size() - 3]) / (sum / (n * n)), 1, 1e-4)
        << "the last texel is the mean of all; float sums";
}

} // namespace
} // namespace seaway::client
