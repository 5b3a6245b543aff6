// SPDX-License-Identifier: Apache-2.0
// Where sun, moon and stars stand, against published positions.
#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "client/view/sky/almanac.h"

namespace seaway::client {
namespace {

constexpr double degree = std::numbers::pi / 180;

Instant instant(const char* text) {
    const Result<Instant> when = parse_instant(text);
    EXPECT_TRUE(when) << when.error().message;
    return *when;
}

double apart_deg(const glm::dvec3& a, const glm::dvec3& b) {
    return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)) / degree;
}

struct Site {
    const char* name;
    double latitude_deg, longitude_deg;
    const char* when;
    double azimuth_deg, elevation_deg;
};

// The first is the worked example of NREL/TP-560-34302 (2008), appendix A.5: geometric elevation, without
// the air's refraction; the others are pvlib's solarposition.spa_python.
constexpr Site sites[] = {
    {"NREL", 39.742476, -105.1786, "2003-10-17T19:30:30Z", 194.340241, 39.872046},
    {"Reykjavik", 64.1466, -21.9426, "2021-06-21T12:00Z", 149.338091, 46.702268},
    {"Berlin", 52.52, 13.405, "2021-06-21T12:00Z", 203.723049, 59.285657},
    {"Berlin, winter", 52.52, 13.405, "2021-12-21T09:30Z", 157.982911, 11.293283},
    {"Davis, night", 38.5449, -121.7405, "2021-12-21T09:30Z", 56.275318, -66.452193},
    {"Delhi", 28.6139, 77.209, "2021-06-21T12:00Z", 285.544832, 22.031291},
    {"Nairobi", -1.2921, 36.8219, "2021-06-21T12:00Z", 307.296059, 46.861904},
    {"Christchurch, night", -43.5321, 172.6362, "2021-12-21T09:30Z", 220.937996, -11.620362},
};

// The almanac's error is 0.01 degrees; nutation, which it leaves out, is 0.005, the sun's parallax 0.0024.
TEST(Almanac, the_sun_stands_where_the_solar_position_algorithm_has_it) {
    for (const Site& site : sites) {
        const Heavens sky = heavens_at(instant(site.when), site.latitude_deg, site.longitude_deg);
        const double level = std::cos(site.elevation_deg * degree);
        const double azimuth = site.azimuth_deg * degree;
        const glm::dvec3 truth(level * std::sin(azimuth), level * std::cos(azimuth),
                               std::sin(site.elevation_deg * degree));
        EXPECT_LT(apart_deg(sky.to_sun, truth), 0.02) << site.name;
    }
}

// Meeus 1998, example 47.a: apparent place on 12 April 1992, 0 h. 0.3 and 0.2 degrees are stated.
TEST(Almanac, the_moon_stands_within_its_stated_error_of_meeus_example) {
    const Equatorial moon = moon_at(instant("1992-04-12T00:00Z"));
    EXPECT_NEAR(moon.right_ascension_rad / degree, 134.688469, 0.3);
    EXPECT_NEAR(moon.declination_rad / degree, 13.768367, 0.2);
    EXPECT_NEAR(moon.distance * 6378.14, 368409.7, 0.003 * 368409.7); // the parallax' last digits
}

// Greatest eclipse of 8 April 2024 (Espenak, NASA): 18:17:13 at 25 17.5 N, 104 07.2 W. Seen from the
// earth's centre the moon would be 0.33 degrees off, so this sees the parallax too.
TEST(Almanac, moon_and_sun_meet_where_and_when_an_eclipse_was) {
    const Instant when = instant("2024-04-08T18:17:13Z");
    const Heavens sky = heavens_at(when, 25.2917, -104.12);
    EXPECT_LT(apart_deg(sky.to_sun, sky.to_moon), 0.3);
    EXPECT_GT(sky.moon_phase_rad / degree, 179);
    EXPECT_LT(moon_brightness(sky.moon_phase_rad), 1e-3);
    const Heavens antipode = heavens_at(when, -25.2917, 75.88);
    EXPECT_GT(apart_deg(antipode.to_sun, antipode.to_moon), 0.6)
        << "from the other side of the earth: twice the parallax of 0.95 degrees, of a sun 70 down";
}

// Allen 1973, third edition, page 143: magnitudes below the full moon's by phase. The formula leaves out the surge of
// the last five degrees, where the table itself has 0.08 a step.
TEST(Almanac, the_moon_wanes_as_it_was_measured_to) {
    constexpr double table[][2] = {{0, 0},      {10, 0.23},  {20, 0.51},  {30, 0.79},
                                   {40, 1.06},  {50, 1.35},  {60, 1.62},  {70, 1.91},
                                   {80, 2.24},  {90, 2.63},  {100, 3.04}, {110, 3.48},
                                   {120, 3.93}, {130, 4.44}, {140, 5.07}, {150, 5.9}};
    EXPECT_EQ(moon_brightness(0), 1);
    for (const auto& [phase_deg, magnitudes] : table)
        for (const double side : {-1.0, 1.0})
            EXPECT_NEAR(-2.5 * std::log10(moon_brightness(side * phase_deg * degree)), magnitudes,
                        0.11) // at 140 degrees; up to 120 it is 0.06
                << phase_deg;
}

// Polaris stands 0.74 degrees from the pole (2000), which is as high as the latitude.
TEST(Almanac, stars_turn_about_a_pole_that_stands_as_high_as_the_latitude) {
    for (const double latitude_deg : {54.0, -12.0}) {
        const Heavens sky = heavens_at(instant("2026-01-15T03:20Z"), latitude_deg, 7.9);
        const glm::dvec3 pole = glm::transpose(sky.equatorial_from_local) * glm::dvec3(0, 0, 1);
        EXPECT_NEAR(pole.x, 0, 1e-12);
        EXPECT_NEAR(std::asin(pole.z) / degree, latitude_deg, 1e-9);
        EXPECT_GT(pole.y, 0);
        EXPECT_NEAR(apart_deg(sky.equatorial_from_local * sky.to_sun, {1, 0, 0}), 65.4, 0.5)
            << "15 January: 65 degrees before the point of spring";
    }
}

TEST(Almanac, the_simple_day_has_the_sun_south_at_noon_and_a_full_moon_at_midnight) {
    EXPECT_NEAR(heavens_at_hour(6).to_sun.x, 1, 1e-12);
    EXPECT_NEAR(heavens_at_hour(12).to_sun.y, -std::sqrt(0.5), 1e-12);
    EXPECT_NEAR(heavens_at_hour(12).to_sun.z, std::sqrt(0.5), 1e-12);
    EXPECT_NEAR(heavens_at_hour(18).to_sun.x, -1, 1e-12);
    const Heavens night = heavens_at_hour(0);
    EXPECT_NEAR(night.to_moon.y, -std::sqrt(0.5), 1e-12);
    EXPECT_NEAR(night.to_moon.z, std::sqrt(0.5), 1e-12);
    EXPECT_EQ(moon_brightness(night.moon_phase_rad), 1);
    EXPECT_NEAR(glm::length(night.equatorial_from_local * night.to_sun - glm::dvec3(1, 0, 0)), 0,
                1e-12);
}

TEST(Almanac, instants_are_read_to_the_second_and_bad_ones_refused) {
    EXPECT_EQ(instant("2000-01-01T12:00Z").days_j2000, 0);
    EXPECT_EQ(instant("2000-03-01T12:00Z").days_j2000, 60) << "2000 was a leap year";
    EXPECT_EQ(instant("1999-12-31T12:00:00Z").days_j2000, -1);
    EXPECT_NEAR(instant("2026-06-21T04:30:36Z").days_j2000, 9667.6879166, 1e-6);
    for (const char* bad :
         {"", "2026-06-21", "2026-06-21T04:30", "2026-06-21T24:00Z", "2026-02-29T04:30Z",
          "2026-13-01T04:30Z", "2026-00-01T04:30Z", "2026-06-21T04:60Z", "2026-06-21 04:30Z",
          "1949-06-21T04:30Z", "2051-06-21T04:30Z", "2026-06-21T04:30:60Z", "2026-06-2lT04:30Z",
          "2026-06-21T04:30:1Z", "+026-06-21T04:30Z", "-026-06-21T04:30Z", "2026-06-21T-0:30Z",
          "2026-06-21T04:-0Z", "2026-06-21T04:30:-0Z"})
        EXPECT_FALSE(parse_instant(bad)) << bad;
}

} // namespace
} // namespace seaway::client
