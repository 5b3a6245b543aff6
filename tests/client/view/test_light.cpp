// SPDX-License-Identifier: Apache-2.0
// What light does in the water and in the air, held against the formulas of the shaders' sources.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/client/view/renderer_fixture.h"
#include "tests/client/view/sky/sky_files.h"

namespace seaway::client {
namespace {

using LightTest = RendererTest;

double bearing_of_sun_deg(const Sky& sky) {
    return 90 - std::atan2(sky.sun_direction().y, sky.sun_direction().x) * 180 / pi;
}

TEST_F(LightTest, water_fades_into_the_air_with_distance) {
    Look fog;
    fog.air.visibility_m = 2e3;
    SkyMaker maker;
    for (const double z_m : {14.0, 900.0}) {
        camera_.z_m = z_m;
        camera_.pitch_deg = -14;
        const Result<Sky> sky = maker.make(fog, heavens_at_hour(12), {.height_m = z_m});
        ASSERT_TRUE(sky) << sky.error().message;
        const Picture clear = render(flat_sea(), *sky, DebugView::final, {.air = false});
        const Picture hazy = render(flat_sea(), *sky);
        const Picture place = render(flat_sea(), *sky, DebugView::place);
        for (int y = 60; y < camera_.height; y += 7)
            for (int x = 4; x < clear.width; x += 33) {
                const float* at = place.pixel(x, y);
                const double level_m =
                    std::hypot(static_cast<double>(at[0]), static_cast<double>(at[1]));
                if (level_m == 0)
                    continue; // sky
                const double distance_m = std::hypot(level_m, z_m);
                const float* water = clear.pixel(x, y);
                const glm::dvec3 seen = sky->through_air(glm::dvec3(static_cast<double>(water[0]),
                                                                    static_cast<double>(water[1]),
                                                                    static_cast<double>(water[2])),
                                                         distance_m, ray(x, y));
                for (int c = 0; c < 3; ++c) // single precision, a pixel's width of distance
                    EXPECT_NEAR(static_cast<double>(hazy.pixel(x, y)[c]) / seen[c], 1, 0.01)
                        << x << ", " << y << " channel " << c << " from " << z_m;
            }
    }
}

// Shader and CPU have the same clouds: what is mirrored of them is what stands above.
TEST_F(LightTest, clouds_on_the_device_are_those_of_the_cpu) {
    Look cloudy;
    cloudy.clouds.coverage = 0.6;
    cloudy.clouds.optical_depth = 6;
    SkyMaker maker;
    camera_.z_m = 14;
    camera_.pitch_deg = 50;
    camera_.view_deg = 30;
    for (const double hour : {10.0, 16.5}) {
        const Result<Sky> sky =
            maker.make(cloudy, heavens_at_hour(hour), {.height_m = camera_.z_m});
        ASSERT_TRUE(sky) << sky.error().message;
        const Picture picture = render(flat_sea(), *sky);
        double apart = 0, mean = 0, spread = 0;
        int count = 0;
        for (int y = 3; y < picture.height; y += 5)
            for (int x = 3; x < picture.width; x += 5) {
                const double truth = luminance_of(sky->behind(ray(x, y)));
                const double found = luminance(picture.pixel(x, y));
                apart += std::abs(found - truth);
                mean += truth;
                spread += truth * truth;
                ++count;
            }
        mean /= count;
        EXPECT_GT(std::sqrt(spread / count - mean * mean), 0.2 * mean)
            << "clouds and gaps are seen";
        EXPECT_LT(apart / count, 0.05 * mean) << "the device blurs what is finer than a pixel";
    }
}

// Patches of light on the sea: looking down, what comes out of the water goes with the beam that falls there.
// Naive: clouds end at the level, and between it and the horizon, which dips below it, the clear sky shines.
TEST_F(LightTest, an_overcast_sky_is_overcast_down_to_the_horizon) {
    Look overcast;
    overcast.clouds.coverage = 1;
    overcast.clouds.optical_depth = 60;
    SkyMaker maker;
    camera_.z_m = 700; // the horizon dips by 0.85 degrees: seven rows
    camera_.pitch_deg = 0;
    camera_.view_deg = 30;
    const Result<Sky> sky = maker.make(overcast, heavens_at_hour(12), {.height_m = camera_.z_m});
    ASSERT_TRUE(sky) << sky.error().message;
    const Picture picture = render(flat_sea(), *sky);
    const double level = luminance(picture.pixel(120, picture.height / 2 - 2));
    for (int y = picture.height / 2; y < picture.height; ++y) {
        EXPECT_LT(luminance(picture.pixel(120, y)), 1.1 * level) << "row " << y;
    }
    const glm::dvec3 dipped = glm::normalize(glm::dvec3(0, 1, -0.008));
    EXPECT_LT(luminance_of(sky->behind(dipped)), 1.1 * level);
}

TEST_F(LightTest, clouds_shade_the_sea_below_them) {
    Look patchy;
    patchy.clouds.coverage = 0.5;
    patchy.clouds.size_m = 150; // several in the picture; texels of noise are 4.7 m, pixels 2 m
    patchy.clouds.base_m = 1000;
    SkyMaker maker;
    camera_.z_m = 400;
    camera_.pitch_deg = -80;
    const Result<Sky> sky = maker.make(patchy, heavens_at_hour(12), {.height_m = camera_.z_m});
    ASSERT_TRUE(sky) << sky.error().message;
    const Picture picture = render(flat_sea(), *sky, DebugView::final, {.air = false});
    const Picture place = render(flat_sea(), *sky, DebugView::place);
    double least = 9, most = 0, apart = 0, even = 0;
    int count = 0;
    for (int y = 4; y < picture.height; y += 8)
        for (int x = 4; x < picture.width; x += 8) {
            const glm::dvec2 at(static_cast<double>(place.pixel(x, y)[0]),
                                static_cast<double>(place.pixel(x, y)[1]));
            const glm::dvec3 d = ray(x, y);
            const double fresnel = 0.02 + 0.98 * std::pow(1 + d.z, 5);
            const double mirrored = fresnel * sky->radiance({d.x, d.y, -d.z}).g;
            const double sine = sky->light_direction().z, beam = sky->light_irradiance().g * sine;
            const double share = sky->beam_over_mean(at);
            const auto seen = [&](double of_beam) {
                return mirrored +
                       (1 - fresnel) * 0.024 / pi * (sky->sky_irradiance().g + of_beam * beam);
            };
            const double found = static_cast<double>(picture.pixel(x, y)[1]);
            apart += std::abs(found / seen(share) - 1);
            even += std::abs(found / seen(1) - 1);
            least = std::min(least, share);
            most = std::max(most, share);
            ++count;
        }
    EXPECT_LT(least, 0.1);
    EXPECT_GT(most, 1.5);
    EXPECT_LT(apart / count, 0.03) << "weights of 8 bits in steep noise";
    EXPECT_GT(even / count, 0.2) << "else this test sees nothing";
}

// An eye above the clouds looks down on them: white where they are thick, the sea in their gaps.
TEST_F(LightTest, clouds_below_the_eye_hide_the_sea) {
    Look broken;
    broken.clouds.coverage = 0.5;
    broken.clouds.base_m = 1000;
    SkyMaker maker;
    camera_.z_m = 5000;
    camera_.pitch_deg = -50;
    const Result<Sky> sky = maker.make(broken, heavens_at_hour(12), {.height_m = camera_.z_m});
    ASSERT_TRUE(sky) << sky.error().message;
    const Picture picture = render(flat_sea(), *sky);
    double apart = 0, mean = 0;
    int count = 0, white = 0, sea = 0;
    for (int y = 4; y < picture.height; y += 6)
        for (int x = 4; x < picture.width; x += 6) {
            const glm::dvec3 d = ray(x, y);
            const glm::dvec3 water(0.3, 0.5,
                                   0.8); // about what the sea sends: a hundredth of clouds
            const glm::dvec3 clear = sky->through_air(water, -camera_.z_m / d.z, d);
            const double truth = luminance_of(sky->below_clouds(clear, d));
            apart += std::abs(luminance(picture.pixel(x, y)) - truth);
            mean += truth;
            white += truth > 5 * luminance_of(clear) ? 1 : 0;
            sea += truth < 1.1 * luminance_of(clear) ? 1 : 0;
            ++count;
        }
    EXPECT_GT(white, 0.1 * count);
    EXPECT_GT(sea, 0.1 * count);
    EXPECT_LT(apart, 0.1 * mean)
        << "the device blurs what is finer than a pixel; the sea is taken for one";
}

// A sky from a picture goes the same way: it stands behind, its sun is a disc, and the sea mirrors it.
TEST_F(LightTest, a_sky_from_a_picture_is_drawn_and_mirrored) {
    // Brighter towards the east and the north, so that a sky the wrong way round is seen.
    const auto even = [](const glm::dvec3& d) { return 3 + 1.2 * d.x + 0.6 * d.y; };
    constexpr double mean = 3; // of what falls on a level sea
    const glm::dvec3 lamp = glm::normalize(glm::dvec3(0.5, 0.6, 0.07));
    camera_.pitch_deg = 0;
    camera_.view_deg = 30;
    Look look;
    look.environment =
        sky_file("lamp.exr", sky_picture(512, 256, [&](const glm::dvec3& d) {
                     return glm::dvec3(glm::dot(d, lamp) > std::cos(0.01) ? 1e5 : even(d));
                 }));
    SkyMaker maker;
    const Result<Sky> sky = maker.make(look, heavens_at_hour(12), {.height_m = camera_.z_m});
    ASSERT_TRUE(sky) << sky.error().message;
    const Picture picture = render(flat_sea(), *sky, DebugView::final, {.air = false});
    const double level = sky->light_irradiance().g * sky->light_direction().z;
    EXPECT_LT(glm::length(sky->light_direction() - lamp), 4e-3)
        << "a third of the picture's texels";
    int sun = 0;
    for (int y = 4; y < picture.height; y += 1)
        for (int x = 4; x < picture.width; x += 1) {
            const glm::dvec3 d = ray(x, y);
            const double found = static_cast<double>(picture.pixel(x, y)[1]);
            const double off = glm::length(d - sky->light_direction()), pixel = camera_.pixel_rad();
            if (d.z > 0.01 && off < Sky::sun_radius_rad - pixel) {
                EXPECT_GT(found, 1e4);
                ++sun;
            } else if (d.z > 0.01 && off > Sky::sun_radius_rad + 2 * pixel) {
                EXPECT_NEAR(found, even(d), 0.02 * even(d));
            } else if (d.z < -0.05 && std::abs(d.x / d.y - lamp.x / lamp.y) > 0.3) {
                const double fresnel = 0.02 + 0.98 * std::pow(1 + d.z, 5);
                const double body = 0.024 / pi * (pi * mean + level);
                EXPECT_NEAR(found, fresnel * even({d.x, d.y, -d.z}) + (1 - fresnel) * body,
                            0.03 * found)
                    << x << ", " << y;
            }
        }
    EXPECT_GT(sun, 0);
}

// The air between goes over into the sky: from ten kilometres the last sea is as bright as the first sky.
TEST_F(LightTest, the_horizon_of_a_high_eye_has_no_edge) {
    camera_.z_m = 10e3;
    camera_.view_deg = 5;
    camera_.pitch_deg = -horizon_dip_rad(camera_.z_m) * 180 / pi;
    const Sky sky(sun_direction(12), camera_.z_m);
    const Picture picture = render(flat_sea(), sky);
    for (int x = 10; x < picture.width; x += 20) {
        const double above = luminance(picture.pixel(x, camera_.height / 2 - 3));
        const double below = luminance(picture.pixel(x, camera_.height / 2 + 3));
        EXPECT_NEAR(below / above, 1, 0.1) << x;
    }
}

/// How much greener crests are than troughs, looking down at a wave; slopes are zero on both, so they
/// mirror the same sky.
struct Glow {
    double crest;
    double trough;
};

/// What `of` says of a pixel, on average on crests and in troughs of a wave of 2 m.
template <class Of>
Glow on_average(const Picture& place, const Of& of) {
    double sums[2] = {0, 0};
    int counts[2] = {0, 0};
    for (std::size_t i = 0; i < place.rgba.size(); i += 4) {
        const float height = place.rgba[i + 2];
        if (std::abs(height) < 1.8f)
            continue;
        const int which = height > 0 ? 0 : 1;
        sums[which] += static_cast<double>(of(i));
        ++counts[which];
    }
    EXPECT_GT(counts[0], 100);
    EXPECT_GT(counts[1], 100);
    return Glow{sums[0] / counts[0], sums[1] / counts[1]};
}

TEST_F(LightTest, crests_glow_where_the_sun_shines_through_them_and_troughs_do_not) {
    SyntheticSea sea(one_wave(2.0, 100, 4));
    const SeaFrame frame = sea.at(0);
    const Sky& sky = sky_at_hour(16.5);
    camera_.z_m = 20;
    camera_.pitch_deg = -35;
    const auto green = [&](double yaw_deg) {
        camera_.yaw_deg = yaw_deg;
        const Picture place = render(frame, sky, DebugView::place);
        const Picture picture = render(frame, sky, DebugView::final, {.air = false});
        // Green beyond what red has: the sky is nearly the same in both, the water is not.
        return on_average(place,
                          [&](std::size_t i) { return picture.rgba[i + 1] - picture.rgba[i]; });
    };
    const Glow towards = green(bearing_of_sun_deg(sky));
    const Glow away = green(bearing_of_sun_deg(sky) + 180);
    EXPECT_GT(towards.crest - towards.trough, 0.1); // by their shapes alone some hundredths
    // Away from the sun only the sky's part is left.
    EXPECT_GT(towards.crest - towards.trough, 2 * (away.crest - away.trough));
}

// Naive: the size of a height, and troughs are tinted as crests are, which a choppy wave hides: its troughs are thick. Of one without
// choppiness, told to be a third as high, crests are tinted more and troughs are what they were.
TEST_F(LightTest, the_tint_by_height_is_of_crests_alone) {
    sea::Realization waves = one_wave(2.0, 100, 4);
    waves.choppiness = {0, 0};
    SyntheticSea sea(waves);
    SeaFrame high = sea.at(0), low = high;
    high.significant_height_m = 6;
    low.significant_height_m = 2;
    const Sky& sky = sky_at_hour(16.5);
    camera_.z_m = 20;
    camera_.pitch_deg = -35;
    camera_.yaw_deg = bearing_of_sun_deg(sky);
    const Picture place = render(high, sky, DebugView::place);
    const Picture some = render(high, sky, DebugView::final, {.air = false});
    const Picture more = render(low, sky, DebugView::final, {.air = false});
    const Glow greener =
        on_average(place, [&](std::size_t i) { return more.rgba[i + 1] - some.rgba[i + 1]; });
    EXPECT_GT(greener.crest, 0.05);
    EXPECT_LT(std::abs(greener.trough), 0.3 * greener.crest) << "that the mesh is another one";
}

// Towards a low sun, at one height of one wave: the face that leans away from it has the sun behind it, the other has it in
// front. Both lean by as much, so that what follows from the height and from how aslant they are seen is alike.
TEST_F(LightTest, a_face_glows_the_more_the_squarer_the_sun_stands_behind_it) {
    const Sky& sky = sky_at_hour(17);
    const double sun_deg = bearing_of_sun_deg(sky);
    const glm::dvec2 to_sun = glm::normalize(glm::dvec2(sky.sun_direction()));
    SyntheticSea sea(one_wave(2.0, 100, 4));
    const SeaFrame frame = sea.at(0);
    camera_.z_m = 20;
    camera_.pitch_deg = -50;
    camera_.yaw_deg = sun_deg;
    const Picture normal = render(frame, sky, DebugView::normal);
    const Picture place = render(frame, sky, DebugView::place);
    const auto extra_green = [&](double sign) {
        const Picture picture = render(frame, sky, DebugView::final, {.air = false});
        double sum = 0;
        int count = 0;
        for (std::size_t i = 0; i < place.rgba.size(); i += 4) {
            const double lean = static_cast<double>(normal.rgba[i]) * to_sun.x +
                                static_cast<double>(normal.rgba[i + 1]) * to_sun.y;
            // On the shoulders of crests, a third of the steepest slope and more.
            if (sign * lean < 0.08 || place.rgba[i + 2] < 0.8f || place.rgba[i + 2] > 1.7f)
                continue;
            sum += static_cast<double>(picture.rgba[i + 1] - picture.rgba[i]);
            ++count;
        }
        EXPECT_GT(count, 50) << sign;
        return sum / count;
    };
    EXPECT_GT(extra_green(-1), 1.3 * extra_green(1));
}

// The thinner a crest, the more light comes through. The same wave with and without choppiness: at its crest the Jacobian is
// 1 - ka = 0.5 and 1.
TEST_F(LightTest, sharp_crests_glow_more_than_round_ones) {
    const Sky& sky = sky_at_hour(16.5);
    camera_.z_m = 20;
    camera_.pitch_deg = -35;
    camera_.yaw_deg = bearing_of_sun_deg(sky);
    const auto glow = [&](double choppiness) {
        sea::Realization waves = one_wave(2.0, 100, 4);
        waves.choppiness = {choppiness, choppiness};
        SyntheticSea sea(waves);
        const SeaFrame frame = sea.at(0);
        const Picture place = render(frame, sky, DebugView::place);
        const Picture picture = render(frame, sky, DebugView::final, {.air = false});
        double sum = 0;
        int count = 0;
        for (std::size_t i = 0; i < place.rgba.size(); i += 4)
            if (place.rgba[i + 2] > 1.9f) {
                sum += static_cast<double>(picture.rgba[i + 1] - picture.rgba[i]);
                ++count;
            }
        EXPECT_GT(count, 50);
        return sum / count;
    };
    // Both mirror more red of the evening than green; by their shapes alone they would differ by 0.03.
    EXPECT_GT(glow(1) - glow(0), 0.1);
}

TEST_F(LightTest, deep_water_has_the_colour_of_its_body) {
    const Sky& sky = sky_at_hour(12);
    camera_.pitch_deg = -75; // down: 2 % is mirrored, the rest is the water
    const Picture picture = render(flat_sea(), sky, DebugView::final, {.air = false});
    const int x = picture.width / 2, y = picture.height / 2;
    const float* pixel = picture.pixel(x, y);
    EXPECT_GT(pixel[2], pixel[1]); // blue before green before red: clear ocean water
    EXPECT_GT(pixel[1], 1.5f * pixel[0]);
    const glm::dvec3 reflectance(0.008, 0.024, 0.026); // client/view/view_values
    const glm::dvec3 down = sky.sky_irradiance() + sky.sun_irradiance() * sky.sun_direction().z;
    const glm::dvec3 d = ray(x, y);
    const double fresnel = 0.02 + 0.98 * std::pow(1 + d.z, 5);
    const double turn = std::remainder(
        std::atan2(d.y, d.x) - std::atan2(sky.sun_direction().y, sky.sun_direction().x), 2 * M_PI);
    const glm::dvec3 mirrored = sky.radiance(std::asin(-d.z), std::abs(turn));
    for (int c = 0; c < 3; ++c) // 3 %: texels of the sky, and a tint that flat water does not have
        EXPECT_NEAR(static_cast<double>(pixel[c]) /
                        (fresnel * mirrored[c] + (1 - fresnel) * reflectance[c] * down[c] / M_PI),
                    1, 0.03)
            << c;
}

TEST_F(LightTest, displacement_fades_where_the_mesh_cannot_carry_it) {
    SyntheticSea sea = gale();
    const SeaFrame frame = sea.at(100'000'000);
    const auto rms_beyond = [&](double camera_m, double pitch_deg, double nearest_m) {
        camera_.z_m = camera_m;
        camera_.pitch_deg = pitch_deg;
        const Picture place = render(frame, sky_at_hour(15), DebugView::place);
        double squares = 0;
        int count = 0;
        for (std::size_t i = 0; i < place.rgba.size(); i += 4) {
            const double distance_m = std::hypot(static_cast<double>(place.rgba[i]),
                                                 static_cast<double>(place.rgba[i + 1]));
            const auto height = static_cast<double>(place.rgba[i + 2]);
            if (distance_m > nearest_m)
                squares += height * height, ++count;
        }
        EXPECT_GT(count, 500);
        return std::sqrt(squares / count);
    };
    // A pixel at 50 km covers kilometres: its mean height is the sea level.
    EXPECT_LT(rms_beyond(3000, -4, 50e3), 0.1 * rms_beyond(60, -30, 1));
}

// Naive: a cascade goes as a whole where cells of the mesh are wider than its grid. Of two waves of one grid, where cells are several of its
// points: the long one is carried, the short one is averaged away.
TEST_F(LightTest, a_wave_fades_by_its_own_length_and_not_by_its_grid) {
    const auto carried = [&](int steps) {
        SyntheticSea sea(one_wave(2.0, 400, steps, 0, 128)); // points 3 m apart
        camera_.z_m = 400;
        camera_.pitch_deg = -20;
        const Picture place = render(sea.at(0), sky_at_hour(15), DebugView::place);
        double squares = 0;
        int count = 0;
        for (std::size_t i = 0; i < place.rgba.size(); i += 4) {
            const double distance_m = std::hypot(static_cast<double>(place.rgba[i]),
                                                 static_cast<double>(place.rgba[i + 1]));
            const auto height = static_cast<double>(place.rgba[i + 2]);
            if (distance_m > 1000 && distance_m < 2500)
                squares += height * height, ++count;
        }
        EXPECT_GT(count, 500);
        return std::sqrt(squares / count) / (2.0 / std::numbers::sqrt2);
    };
    EXPECT_GT(carried(1), 0.9);
    EXPECT_LT(carried(50), 0.1);
}

} // namespace
} // namespace seaway::client
