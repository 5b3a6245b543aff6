// SPDX-License-Identifier: Apache-2.0
// Skies from pictures: what they hold, and what is refused.
#include <algorithm>
#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <sys/stat.h>

#include "client/view/sky/sky_feed.h"
#include "tests/client/view/sky/air_fixture.h"
#include "tests/client/view/sky/sky_files.h"
#include "tests/support/read_file.h"

namespace seaway::client {
namespace {

using testing::HasSubstr;

const glm::dvec3 lamp = towards(35, 30);

/// Brighter to the north and to the zenith, with a sun a degree wide and soft at its rim.
glm::dvec3 evening_sky(const glm::dvec3& direction) {
    const glm::dvec3 sky =
        glm::dvec3(1.0, 1.5, 2.5) * (2 + direction.y + 0.5 * std::max(direction.z, 0.0));
    const double off = glm::length(direction - lamp) / (0.5 * air_degree);
    return sky + glm::dvec3(600e3, 500e3, 400e3) * std::exp(-off * off * off * off);
}

Sky sky_of_file(SkyMaker& maker, const std::string& path, double turn_deg = 0,
                double strength = 1) {
    Look look;
    look.environment = path;
    look.environment_turn_deg = turn_deg;
    look.sun_strength = strength;
    Result<Sky> sky = maker.make(look, heavens_at_hour(12), {.height_m = 12});
    EXPECT_TRUE(sky) << sky.error().message;
    return *sky;
}

TEST(Environment, a_constant_sky_is_constant_and_has_no_sun) {
    const glm::dvec3 colour(2.5, 3, 4);
    SkyMaker maker;
    const Sky sky = sky_of_file(
        maker,
        sky_file("constant.exr", sky_picture(64, 32, [&](const glm::dvec3&) { return colour; })));
    EXPECT_EQ(sky.light_irradiance(), glm::dvec3(0));
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(sky.sky_irradiance()[c], air_pi * colour[c], 1e-3 * colour[c]);
        for (const double elevation_deg : {0.01, 0.5, 10.0, 60.0, 89.9})
            for (const double azimuth_deg : {0.0, 77.0, 200.0}) {
                const glm::dvec3 d = towards(elevation_deg, azimuth_deg);
                EXPECT_NEAR(sky.behind(d)[c], colour[c], 1e-5);
                EXPECT_NEAR(sky.radiance(d)[c], colour[c], 1e-5);
            }
        // From the sea comes less than that, and through air comes nothing else.
        EXPECT_LT(sky.radiance(towards(-30))[c], 0.3 * colour[c]);
        EXPECT_NEAR(sky.through_air(colour, 5000, towards(-1))[c], colour[c], 1e-4);
    }
    EXPECT_EQ(sky.values().star_klx, 0) << "what stands in the picture is all";
    EXPECT_EQ(sky.values().moon.y, 0);
}

// What falls on the level of the picture falls of sky and sun: 1 % for the table's texels.
TEST(Environment, the_sun_is_taken_out_and_no_light_is_lost) {
    const EnvironmentPicture picture = sky_picture(1024, 512, evening_sky);
    const glm::dvec3 all = level_light(picture);
    const Environment made = environment_of(picture, 0, air_pool());
    // Its middle, by texels of 0.35 degrees.
    EXPECT_LT(glm::length(made.to_sun - lamp), 0.03 * air_degree);
    SkyMaker maker;
    const Sky sky = sky_of_file(maker, sky_file("evening.exr", picture));
    const glm::dvec3 found =
        sky.sky_irradiance() + sky.light_irradiance() * sky.light_direction().z;
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(found[c] / all[c], 1, 0.01);
        // pi/4 a (0.5 deg)^2 of e^-x^4, whose integral over the plane is pi^1.5 / 2.
        const double truth = std::pow(air_pi, 1.5) / 2 * std::pow(0.5 * air_degree, 2);
        EXPECT_NEAR(made.sun_klx[c] / (truth * (600 - 100 * c) * 1e3), 1, 0.02);
        EXPECT_GT(made.sun_klx[c] * made.to_sun.z, 0.3 * all[c]) << "else this test sees nothing";
    }
    // Sky is left where it was; where there is no sun, the picture is as it was.
    const auto sky_alone = [](const glm::dvec3& d) {
        return glm::dvec3(1.0, 1.5, 2.5) * (2 + d.y + 0.5 * d.z);
    };
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(sky.behind(lamp)[c] / sky_alone(lamp)[c], 1, 0.05);
        for (const double azimuth_deg : {-100.0, 0.0, 60.0, 190.0}) {
            const glm::dvec3 d = towards(20, azimuth_deg);
            EXPECT_NEAR(sky.behind(d)[c] / sky_alone(d)[c], 1, 0.01);
        }
    }
    // The disc that is drawn sends what the sun sends.
    const double disc = 2 * air_pi * (1 - std::cos(Sky::sun_radius_rad));
    EXPECT_NEAR(static_cast<double>(sky.values().sun_high.y) * disc, made.sun_klx.g,
                1e-4 * made.sun_klx.g);
}

TEST(Environment, turns_clockwise_with_its_sun) {
    SkyMaker maker;
    const std::string path = sky_file("turned.exr", sky_picture(512, 256, evening_sky));
    const Sky straight = sky_of_file(maker, path), turned = sky_of_file(maker, path, 50);
    EXPECT_LT(glm::length(turned.light_direction() - towards(35, 30 - 50)), 0.1 * air_degree);
    for (const double azimuth_deg : {-100.0, 60.0, 190.0}) {
        const glm::dvec3 before = straight.behind(towards(20, azimuth_deg));
        const glm::dvec3 after = turned.behind(towards(20, azimuth_deg - 50));
        EXPECT_NEAR(after.g / before.g, 1, 5e-3);
    }
    // The picture's middle is the north.
    EXPECT_GT(straight.behind(towards(20, 90)).g, 1.3 * straight.behind(towards(20, 0)).g);
}

TEST(Environment, is_read_once_and_linear_in_its_strength) {
    SkyMaker maker;
    const std::string path = sky_file("linear.exr", sky_picture(128, 64, evening_sky));
    const Sky once = sky_of_file(maker, path);
    for (int i = 0; i < 10; ++i)
        EXPECT_EQ(sky_of_file(maker, path).texels(), once.texels());
    EXPECT_EQ(maker.counts().picture, 1);
    const Sky twice = sky_of_file(maker, path, 0, 2);
    EXPECT_EQ(maker.counts().picture, 2);
    EXPECT_EQ(twice.light_irradiance(), 2.0 * once.light_irradiance());
    EXPECT_EQ(twice.behind(towards(50)), 2.0 * once.behind(towards(50)));
}

TEST(Environment, files_of_tiles_and_wide_ones_are_read) {
    const EnvironmentPicture small = sky_picture(128, 64, evening_sky);
    const Result<EnvironmentPicture> tiled =
        read_environment(sky_file("tiled.exr", small, {"R", "G", "B"}, true));
    ASSERT_TRUE(tiled) << tiled.error().message;
    EXPECT_EQ(tiled->texels, small.texels);
    const EnvironmentPicture wide = sky_picture(4096, 2048, evening_sky);
    const Result<EnvironmentPicture> held = read_environment(sky_file("wide.exr", wide));
    ASSERT_TRUE(held) << held.error().message;
    ASSERT_EQ(held->width, 2048);
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(level_light(*held)[c] / level_light(wide)[c], 1, 1e-5);
}

// Whatever the sides: heights that are odd, or prime, have no common divisor with a width of at most 2048. What a wide
// picture sends is kept: 1e-4 of it are the slope of the sine within a row of the picture, pi / 1024 high.
TEST(Environment, pictures_of_any_width_are_held_with_all_their_light) {
    for (const int height : {509, 1025, 1027, 1031}) { // primes: 509 and 1031
        const EnvironmentPicture picture = sky_picture(2 * height, height, evening_sky);
        const Result<EnvironmentPicture> held =
            read_environment(sky_file("any_width.exr", picture));
        ASSERT_TRUE(held) << held.error().message;
        EXPECT_EQ(held->width, std::min(2 * height, environment_width_held));
        EXPECT_EQ(held->height, held->width / 2);
        const Environment made = environment_of(*held, 0, air_pool());
        const Environment truth = environment_of(picture, 0, air_pool());
        EXPECT_LT(glm::length(made.to_sun - lamp), 0.03 * air_degree) << height;
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(level_light(*held)[c] / level_light(picture)[c], 1, 1e-4) << height;
            EXPECT_NEAR(made.sun_klx[c] / truth.sun_klx[c], 1, 2e-3) << height;
        }
    }
}

// Only what is finite comes out of pictures of any size, and a sky of one colour stays so.
TEST(Environment, a_constant_sky_of_any_size_is_constant) {
    for (const int height : {8, 9, 31, 1029, 1031}) {
        const Result<EnvironmentPicture> held = read_environment(
            sky_file("plain.exr", sky_picture(2 * height, height,
                                              [](const glm::dvec3&) { return glm::dvec3(3); })));
        ASSERT_TRUE(held) << held.error().message;
        const Environment made = environment_of(*held, 0, air_pool());
        EXPECT_EQ(made.sun_klx, glm::dvec3(0)) << height;
        // Means over 8 x 8 samples, in floats.
        for (const glm::vec3& texel : made.sky.texels())
            ASSERT_NEAR(texel.g, 3, 1e-4) << height;
        EXPECT_NEAR(level_light(*held).g, 3 * air_pi, 1e-4) << height;
    }
}

// A texel of 16 columns is 22 degrees high: all around a sun of one texel is farther away than 6 degrees.
TEST(Environment, the_sun_of_a_coarse_picture_is_taken_out) {
    for (const int width : {16, 18, 24, 48, 60, 118, 120}) {
        const int height = width / 2, x = width / 3, y = height / 4;
        EnvironmentPicture picture =
            sky_picture(width, height, [](const glm::dvec3&) { return glm::dvec3(2); });
        picture.texels[static_cast<std::size_t>(y * width + x)] = glm::vec3(5000);
        const glm::dvec3 truth = picture.direction(x, y);
        const double sun_klx = 4998 * picture.texel_sr(y);
        const Environment made = environment_of(picture, 0, air_pool());
        EXPECT_NEAR(made.sun_klx.g / sun_klx, 1, 1e-6) << width;
        EXPECT_LT(glm::length(made.to_sun - truth), 1e-6) << width;
        for (const glm::vec3& texel : made.sky.texels())
            ASSERT_NEAR(texel.g, 2, 1e-4) << width;
    }
}

// Its lower half is not used: neither lamps there nor the half of a sun that is below the horizon are light of the sky.
TEST(Environment, of_a_sun_on_the_horizon_the_upper_half_shines) {
    for (const int height : {512, 509}) {
        const auto at_horizon = [](const glm::dvec3& d) {
            const double off = glm::length(d - towards(0, 40));
            return glm::dvec3(off < air_degree ? 4000 : 2);
        };
        const EnvironmentPicture whole = sky_picture(2 * height, height, at_horizon);
        EnvironmentPicture upper = whole;
        for (std::size_t i = whole.texels.size() * 36 / 70; i < whole.texels.size(); ++i)
            upper.texels[i] = glm::vec3(0); // and what lies around it there does not count
        const Environment made = environment_of(whole, 0, air_pool());
        EXPECT_EQ(made.sun_klx, environment_of(upper, 0, air_pool()).sun_klx);
        double half_sr = 0;
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < whole.width; ++x)
                if (whole.texels[static_cast<std::size_t>(y * whole.width + x)].g > 3)
                    half_sr +=
                        std::min(whole.texel_sr(y),
                                 2 * air_pi / whole.width *
                                     std::max(std::sin(air_pi * (0.5 - double(y) / height)), 0.0));
        EXPECT_NEAR(made.sun_klx.g / (3998 * half_sr), 1, 1e-5) << height;
        // Half a disc of a degree's radius, to a third of a texel at its rim.
        EXPECT_NEAR(half_sr / (0.5 * air_pi * air_degree * air_degree), 1, 0.2) << height;
        EXPECT_GT(made.to_sun.z, 0) << height;
    }
}

std::string refusal(const std::string& path) {
    const Result<EnvironmentPicture> picture = read_environment(path);
    if (picture)
        return "read";
    EXPECT_THAT(picture.error().message, HasSubstr("sky picture " + path + ": "));
    EXPECT_EQ(picture.error().message.find('\n'), std::string::npos) << "one line";
    return picture.error().message;
}

TEST(Environment, what_is_no_sky_is_refused_by_name) {
    const tests::Folder& folder = tests::folder();
    EXPECT_THAT(refusal(folder.file("nowhere.exr")), HasSubstr("no such file"));
    EXPECT_THAT(refusal("/tmp"), HasSubstr("is a folder"));
    const std::string pipe = folder.file("pipe.exr");
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    EXPECT_THAT(refusal(pipe), HasSubstr("is a pipe")) << "and nobody waits for it";
    EXPECT_THAT(refusal("/dev/zero"), HasSubstr("is a pipe, a device"));
    EXPECT_THAT(refusal(folder.write("empty.exr", "")), HasSubstr("cannot be read"));
    EXPECT_THAT(refusal(folder.write("text.exr", "a sky")), HasSubstr("cannot be read"));

    const EnvironmentPicture fine = sky_picture(64, 32, evening_sky);
    const std::string path = sky_file("fine.exr", fine);
    ASSERT_EQ(refusal(path), "read");
    const std::string bytes = tests::read_file(path);
    EXPECT_THAT(refusal(folder.write("cut.exr", bytes.substr(0, bytes.size() / 2))),
                HasSubstr("cannot be read"));
    EXPECT_THAT(refusal(folder.write("head.exr", bytes.substr(0, 100))),
                HasSubstr("cannot be read"));

    EXPECT_THAT(refusal(sky_file("square.exr", sky_picture(32, 32, evening_sky))),
                HasSubstr("is 32 x 32: a sky is twice as wide as high"));
    EXPECT_THAT(refusal(sky_file("small.exr", sky_picture(8, 4, evening_sky))),
                HasSubstr("is 8 x 4: width is 16 .. 16384"));
    EXPECT_THAT(refusal(sky_file("grey.exr", fine, {"Y"})), HasSubstr("has no channel R"));
    EXPECT_THAT(refusal(sky_file("blind.exr", fine, {"R", "G"})), HasSubstr("has no channel B"));
    for (const auto& [value, said] :
         {std::pair(std::numeric_limits<float>::quiet_NaN(), "nan"),
          std::pair(std::numeric_limits<float>::infinity(), "inf"), std::pair(-1.0f, "-1")}) {
        EnvironmentPicture bad = fine;
        bad.texels[3 * 64 + 7].g = value;
        EXPECT_THAT(
            refusal(sky_file("bad.exr", bad)),
            HasSubstr(std::string("pixel 7, 3: G is ") + said + "; radiance is a number from 0"));
    }
}

// A header that speaks of 2^30 columns is refused before memory is asked for.
TEST(Environment, a_header_of_an_enormous_picture_is_refused) {
    std::string bytes = tests::read_file(sky_file("honest.exr", sky_picture(64, 32, evening_sky)));
    for (const char* name : {"dataWindow", "displayWindow"}) {
        // Name, 0, "box2i", 0, 16 as four bytes, then x and y from and to.
        const std::size_t x_max = bytes.find(name) + std::string(name).size() + 1 + 6 + 4 + 8;
        bytes[x_max + 3] = 0x40;
    }
    EXPECT_THAT(refusal(tests::folder().write("enormous.exr", bytes)), HasSubstr("cannot be read"));
}

TEST(Environment, a_bad_picture_leaves_a_window_its_last_sky) {
    SkyFeed feed;
    Look look;
    const Sky first = feed.at(look, heavens_at_hour(12), {});
    look.environment = "nowhere.exr";
    for (int i = 0; i < 3; ++i) {
        const Sky next = feed.at(look, heavens_at_hour(12), {});
        EXPECT_EQ(next.texels(), first.texels());
        feed.wait();
    }
    EXPECT_THAT(feed.error(), HasSubstr("sky picture nowhere.exr: no such file"));
    EXPECT_EQ(feed.counts().made, 1) << "it is not tried with every frame";
}

// There is a sky to draw from the first frame on, and error() says what is wrong with the one that was asked for.
TEST(Environment, a_bad_first_picture_leaves_a_window_the_default_sky) {
    SkyFeed feed;
    Look look;
    look.environment = "nowhere.exr";
    const Sky first = feed.at(look, heavens_at_hour(4), {});
    EXPECT_THAT(feed.error(), HasSubstr("sky picture nowhere.exr: no such file"));
    EXPECT_EQ(*first.texels(),
              *SkyMaker().make(Look{}, heavens_at_hour(Look{}.hour), {})->texels());
    for (int i = 0; i < 3; ++i) {
        const Sky next = feed.at(look, heavens_at_hour(4), {});
        EXPECT_EQ(next.texels(), first.texels());
        feed.wait();
    }
    EXPECT_EQ(feed.counts().made, 1) << "it is not tried with every frame";
    look.environment = "elsewhere.exr";
    (void)feed.at(look, heavens_at_hour(4), {});
    feed.wait();
    EXPECT_THAT(feed.error(), HasSubstr("sky picture elsewhere.exr: no such file"));
    (void)feed.at(Look{}, heavens_at_hour(12), {});
    feed.wait();
    EXPECT_EQ(feed.error(), "") << "what was wrong is no longer asked for";
}

// Whoever mends the file, or writes another to its place, says so, and it is read again: after an error, and after a
// picture that was shown.
TEST(Environment, a_picture_that_has_changed_is_read_once_more_when_that_is_said) {
    const auto plain = [](double radiance) {
        return sky_picture(16, 8, [&](const glm::dvec3&) { return glm::dvec3(radiance); });
    };
    Look look;
    look.environment = tests::folder().write("mended.exr", "no picture");
    SkyFeed feed;
    const auto shown = [&] { // when all that was asked for is made
        (void)feed.at(look, heavens_at_hour(12), {});
        do {
            feed.wait();
            (void)feed.at(look, heavens_at_hour(12), {});
        } while (!feed.settled());
        return feed.at(look, heavens_at_hour(12), {}).behind(towards(50)).g;
    };
    shown();
    EXPECT_THAT(feed.error(), HasSubstr("mended.exr"));
    sky_file("mended.exr", plain(3));
    shown();
    EXPECT_THAT(feed.error(), HasSubstr("mended.exr")) << "nobody looks at the file meanwhile";
    feed.read_again();
    EXPECT_FALSE(feed.settled()) << "else a window would not ask";
    EXPECT_NEAR(shown(), 3, 1e-4);
    EXPECT_EQ(feed.error(), "");
    sky_file("mended.exr", plain(5));
    EXPECT_NEAR(shown(), 3, 1e-4);
    feed.read_again();
    EXPECT_NEAR(shown(), 5, 1e-4);
}

} // namespace
} // namespace seaway::client
