// SPDX-License-Identifier: Apache-2.0
// Discs and stars as they are drawn, held against what is measured of the sun, the moon and the sky at night.
#include <algorithm>
#include <vector>

#include "client/view/view_sky.h"
#include "tests/client/view/renderer_fixture.h"

namespace seaway::client {
namespace {

class NightTest : public RendererTest {
  protected:
    /// A moonless night.
    static Heavens stars_at(const char* when, double latitude_deg = 54) {
        Heavens heavens = heavens_at(*parse_instant(when), latitude_deg, 7.9);
        EXPECT_LT(heavens.to_sun.z, -0.5) << "it is to be night";
        heavens.to_moon = {0, 0, -1};
        heavens.moon_phase_rad = pi;
        return heavens;
    }
    Sky sky_of(const Heavens& heavens) {
        Result<Sky> made = maker_.make({}, heavens, {.height_m = camera_.z_m});
        EXPECT_TRUE(made) << made.error().message;
        return *made;
    }
    void look_at(const glm::dvec3& direction, double view_deg, int side) {
        camera_.yaw_deg = 90 - std::atan2(direction.y, direction.x) * 180 / pi;
        camera_.pitch_deg = std::asin(direction.z) * 180 / pi;
        camera_.view_deg = view_deg;
        camera_.width = camera_.height = side;
    }
    /// Solid angle of a pixel.
    double pixel_sr(int x, int y) const {
        const double side = 2 * std::tan(camera_.view_deg * pi / 360) / camera_.width;
        const double cosine =
            glm::dot(ray(x, y), camera_.ray(0, 0)) / glm::length(camera_.ray(0, 0));
        return side * side * std::pow(cosine, 3);
    }
    struct Star {
        glm::dvec3 direction; ///< local
        double klx;
    };
    /// Of all that stand out of the sky by more than half of the faintest star.
    std::vector<Star> stars_in(const Picture& picture, const Sky& sky, double faintest_klx) const {
        const auto above = [&](int x, int y) {
            return luminance(picture.pixel(x, y)) - luminance_of(sky.behind(ray(x, y)));
        };
        std::vector<Star> stars;
        for (int y = 3; y < picture.height - 3; ++y)
            for (int x = 3; x < picture.width - 3; ++x) {
                const double here = above(x, y);
                if (here * pixel_sr(x, y) <
                    0.1 * faintest_klx) // a star's middle pixel has a fifth and more
                    continue;
                bool highest = true;
                double sum = 0;
                glm::dvec3 middle(0);
                for (int dy = -2; dy <= 2; ++dy)
                    for (int dx = -2; dx <= 2; ++dx) {
                        const double there = above(x + dx, y + dy);
                        if (std::abs(dx) < 2 && std::abs(dy) < 2 && (dx != 0 || dy != 0))
                            highest =
                                highest && (there < here ||
                                            (there == here && (dy > 0 || (dy == 0 && dx > 0))));
                        sum += there * pixel_sr(x + dx, y + dy);
                        middle += std::max(there, 0.0) * ray(x + dx, y + dy);
                    }
                if (highest && sum > 0.5 * faintest_klx)
                    stars.push_back({glm::normalize(middle), sum});
            }
        return stars;
    }
    SkyMaker maker_;
};

// The sun of a place moves on by half a minute at a time, so that 60 seconds of frames ask for three skies at the most; it
// is never further from where it stands than half of that, 0.0625 degrees.
TEST(HeavensOfFrames, a_clock_that_goes_on_asks_for_a_new_sun_each_half_minute) {
    Look look;
    look.place = PlaceAndTime{54, 7.9, *parse_instant("2026-06-21T18:30Z")};
    std::vector<Heavens> seen;
    for (int frame = 0; frame < 60 * 30; ++frame) {
        const sea::TimeUs time_us = 1'000'000'000 + frame * sea::TimeUs{33'333};
        const Heavens now = heavens_of(look, time_us);
        if (seen.empty() || !(seen.back() == now))
            seen.push_back(now);
        const double days = look.place->when.days_j2000 + sea::seconds_from_us(time_us) / 86400;
        const Heavens exact = heavens_at({days}, 54, 7.9);
        ASSERT_LT(glm::length(now.to_sun - exact.to_sun), 0.0626 * pi / 180);
    }
    EXPECT_GE(seen.size(), 2u);
    EXPECT_LE(seen.size(), 3u);
}

constexpr double magnitude_0_klx = 2.54e-9;

// Bright Star Catalogue: 9096 stars to 6.5; Hipparcos: 1600 to 5. Of what is drawn each tenth stands so near to another
// that one of them is not told, and stars lie on a grid of cells: 8 % for all; 190 bright ones vary by chance.
TEST_F(NightTest, stars_are_as_many_as_are_counted) {
    const Sky sky = sky_of(stars_at("2026-01-15T00:00Z"));
    const double left = std::exp(-static_cast<double>(sky.values().zenith_depth.y));
    int faint = 0, bright = 0;
    double sr = 0;
    for (const double yaw_deg : {20.0, 140.0, 260.0}) {
        look_at({0, 0.3, std::sqrt(0.91)}, 60, 480);
        camera_.yaw_deg = yaw_deg;
        const Picture picture = render(flat_sea(), sky);
        for (const Star& star :
             stars_in(picture, sky, magnitude_0_klx * std::pow(10, -2.6) * left)) {
            const double above_air = star.klx / std::pow(left, 1 / star.direction.z);
            faint += above_air > 0.9 * magnitude_0_klx * std::pow(10, -2.6) ? 1 : 0;
            bright += above_air > magnitude_0_klx * std::pow(10, -2.0) ? 1 : 0;
        }
        for (int y = 3; y < picture.height - 3; ++y)
            for (int x = 3; x < picture.width - 3; ++x)
                sr += pixel_sr(x, y);
    }
    EXPECT_NEAR(faint * 4 * pi / sr / 9096, 1, 0.08);
    EXPECT_NEAR(bright * 4 * pi / sr / 1600, 1, 0.25);
}

// Three hours turn the stars by 45 degrees about the pole; among the stars each stays where it is.
TEST_F(NightTest, stars_turn_with_sidereal_time) {
    const Heavens before = stars_at("2026-01-15T00:00Z"), after = stars_at("2026-01-15T03:00Z");
    const auto brightest = [&](const Heavens& heavens) {
        look_at({0, std::cos(54 * pi / 180), std::sin(54 * pi / 180)}, 40, 400);
        const Sky sky = sky_of(heavens);
        std::vector<Star> stars = stars_in(render(flat_sea(), sky), sky, 1e-11);
        std::erase_if(stars, [&](const Star& star) { // what both pictures hold: a circle
            return glm::dot(star.direction, glm::normalize(camera_.ray(0, 0))) < std::cos(0.3);
        });
        std::sort(stars.begin(), stars.end(),
                  [](const Star& a, const Star& b) { return a.klx > b.klx; });
        stars.resize(std::min<std::size_t>(stars.size(), 12));
        return stars;
    };
    const std::vector<Star> first = brightest(before), then = brightest(after);
    ASSERT_EQ(first.size(), 12u);
    int found = 0, moved = 0;
    for (const Star& star : first) {
        const glm::dvec3 place = before.equatorial_from_local * star.direction;
        found += std::any_of(then.begin(), then.end(), [&](const Star& other) {
            return glm::length(after.equatorial_from_local * other.direction - place) <
                   3e-3; // 1.7 pixels
        });
        moved += std::none_of(then.begin(), then.end(), [&](const Star& other) {
            return glm::length(other.direction - star.direction) < 3e-3;
        });
    }
    EXPECT_GE(found, 10) << "the faintest of them may change places with others";
    EXPECT_GE(moved, 10);
}

// Of the moon's disc the share (1 + cos phase) / 2 is lit, and it is the side towards the sun; its light is that of the
// moon, whatever is lit.
TEST_F(NightTest, the_moons_lit_side_faces_the_sun) {
    for (const double apart_deg : {60.0, 90.0, 140.0}) {
        Heavens heavens;
        const double turn = apart_deg * pi / 180;
        heavens.to_moon = glm::normalize(glm::dvec3(0.5, -0.9, 0.25));
        const glm::dvec3 aside =
            glm::normalize(glm::cross(heavens.to_moon, glm::dvec3(0.2, 0.1, -1)));
        const glm::dvec3 down = glm::cross(aside, heavens.to_moon);
        heavens.to_sun = std::cos(turn) * heavens.to_moon + std::sin(turn) * down;
        ASSERT_LT(heavens.to_sun.z, -0.2);
        heavens.moon_phase_rad = pi - turn;
        const Sky sky = sky_of(heavens);
        look_at(heavens.to_moon, 0.8, 128);
        const Picture picture = render(flat_sea(), sky);
        double most = 0, klx = 0, lit_sr = 0;
        glm::dvec3 middle(0);
        for (int y = 0; y < 128; ++y)
            for (int x = 0; x < 128; ++x)
                most = std::max(most, luminance(picture.pixel(x, y)));
        for (int y = 0; y < 128; ++y)
            for (int x = 0; x < 128; ++x) {
                const double light = luminance(picture.pixel(x, y));
                klx += (light - luminance_of(sky.behind(ray(x, y)))) * pixel_sr(x, y);
                lit_sr += light > 0.5 * most ? pixel_sr(x, y) : 0;
                middle += light * ray(x, y);
            }
        const double disc_sr = pi * Sky::sun_radius_rad * Sky::sun_radius_rad;
        EXPECT_NEAR(lit_sr / disc_sr, 0.5 - 0.5 * std::cos(turn), 0.04) << apart_deg;
        EXPECT_NEAR(klx / luminance_of(sky.light_irradiance()), 1, 0.06) << apart_deg;
        const glm::dvec3 off = glm::normalize(middle) - heavens.to_moon;
        EXPECT_GT(glm::dot(off, down), 0.05 * Sky::sun_radius_rad * (1 + std::cos(turn)));
        EXPECT_LT(std::abs(glm::dot(off, glm::cross(heavens.to_moon, down))),
                  0.03 * Sky::sun_radius_rad);
    }
}

// Neckel and Labs 1994, table 1: radiance over that of the middle, by the cosine of the angle from the sun's own vertical,
// as polynomials; for 550 nm those of 541.76 and 559.95 are mixed.
TEST_F(NightTest, the_suns_disc_darkens_towards_its_rim_as_measured) {
    constexpr double measured[3][6] = {
        {0.30854, 1.36620, -1.83572, 2.33221, -1.63082, 0.45959}, // 610.975 nm
        {0.26444, 1.30551, -1.43072, 1.67102, -1.12351, 0.31326},
        {0.15248, 1.38517, -1.49615, 1.99886, -1.48155, 0.44119}}; // 445.125 nm
    const Sky& sky = sky_at_hour(12);
    look_at(sky.sun_direction(), 0.6, 160);
    const Picture picture = render(flat_sea(), sky);
    const float* centre = picture.pixel(80, 80);
    int compared = 0;
    for (int x = 4; x < 156; x += 3) {
        const double off = glm::length(ray(x, 80) - sky.sun_direction()) / Sky::sun_radius_rad;
        if (off > 0.98)
            continue;
        const double mu = std::sqrt(1 - off * off);
        for (int c = 0; c < 3; ++c) {
            double seen = 0;
            for (int i = 5; i >= 0; --i)
                seen = seen * mu + measured[c][i];
            EXPECT_NEAR(static_cast<double>(picture.pixel(x, 80)[c] / centre[c]), seen, 0.012)
                << off;
        }
        ++compared;
    }
    EXPECT_GT(compared, 30);
}

// Through a thin layer the disc is seen, dimmer by its slant depth; through a thick one it is not.
TEST_F(NightTest, the_sun_is_seen_through_thin_cloud) {
    const auto middle = [&](double optical_depth) {
        Look look;
        look.clouds.coverage = optical_depth > 0 ? 1 : 0; // without a hole
        look.clouds.optical_depth = optical_depth;
        const Result<Sky> sky = maker_.make(look, heavens_at_hour(12), {.height_m = camera_.z_m});
        look_at(sky->sun_direction(), 2, 64);
        return luminance(render(flat_sea(), *sky).pixel(32, 32));
    };
    const double clear = middle(0);
    // The sun stands 45 degrees high. Around it the cloud itself shines, a thousandth of the disc. Where noise is lowest
    // the layer is thinner by a tenth.
    EXPECT_NEAR(std::log(clear / middle(2)), 2 * std::sqrt(2.0), 0.3);
    EXPECT_LT(middle(30), 1e-4 * clear);
}

// Shaders of pictures without discs know none: a sun whose rim alone is in the picture is still in it.
TEST_F(NightTest, a_sun_in_the_corner_of_the_picture_is_drawn) {
    const Sky& sky = sky_at_hour(10);
    look_at(sky.sun_direction(), 40, 100);
    // Half a turn of 40 degrees and a little: the sun's middle is outside.
    camera_.pitch_deg -= 20.1;
    const auto brightest = [&](const Picture& picture) {
        double most = 0;
        for (std::size_t i = 0; i < picture.rgba.size(); i += 4)
            most = std::max(most, luminance(&picture.rgba[i]));
        return most;
    };
    EXPECT_GT(brightest(render(flat_sea(), sky)), 1e4) << "its upper edge cuts the disc";
    EXPECT_EQ(sky_seen(sky.values(), camera_), SkySeen::discs);
    camera_.pitch_deg -= 12;
    EXPECT_LT(brightest(render(flat_sea(), sky)), 1e3);
    EXPECT_EQ(sky_seen(sky.values(), camera_), SkySeen::plain);
    camera_.yaw_deg += 180;
    EXPECT_EQ(sky_seen(sky.values(), camera_), SkySeen::plain);
    Look cloudy;
    cloudy.clouds.coverage = 0.1;
    EXPECT_EQ(sky_seen(maker_.make(cloudy, heavens_at_hour(10), {})->values(), camera_),
              SkySeen::clouds);
    EXPECT_EQ(sky_seen(sky_of(stars_at("2026-01-15T00:00Z")).values(), camera_), SkySeen::discs);
}

} // namespace
} // namespace seaway::client
