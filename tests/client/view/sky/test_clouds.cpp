// SPDX-License-Identifier: Apache-2.0
// One layer of clouds: how much sky it takes, and what becomes of the light.
#include "client/view/sky/clouds.h"
#include "client/view/sky/sky.h"
#include "tests/client/view/sky/air_fixture.h"

namespace seaway::client {
namespace {

constexpr int noise_columns = 192, noise_rows = 64;

const std::vector<glm::vec2>& small_noise() {
    static const std::vector<glm::vec2> noise = cloud_noise(noise_columns, noise_rows, air_pool());
    return noise;
}

/// Tables of the air are made once: what a maker has kept changes nothing.
Sky under_clouds(double coverage, double optical_depth, double hour = 13) {
    static SkyMaker maker;
    Look look;
    look.clouds.coverage = coverage;
    look.clouds.optical_depth = optical_depth;
    Result<Sky> made = maker.make(look, heavens_at_hour(hour), {});
    EXPECT_TRUE(made) << made.error().message;
    return *made;
}

TEST(Clouds, noise_is_evenly_distributed_and_repeats_without_a_seam) {
    int below = 0;
    for (const glm::vec2& texel : small_noise()) {
        ASSERT_TRUE(texel.x > 0 && texel.x < 1 && texel.y > 0 && texel.y < 1);
        below += texel.x < 0.3f ? 1 : 0;
    }
    EXPECT_NEAR(below / double{noise_columns * noise_rows}, 0.3, 1e-3);
    double across = 0, inside = 0;
    for (int y = 0; y < noise_rows; ++y) {
        const auto at = [&](int x) {
            return static_cast<double>(
                small_noise()[static_cast<std::size_t>(y * noise_columns + x)].x);
        };
        across += std::abs(at(0) - at(noise_columns - 1));
        inside += std::abs(at(noise_columns / 2) - at(noise_columns / 2 - 1));
    }
    EXPECT_LT(across, 2 * inside + 0.5);
}

// Pattern, detail and region are independent, so the share of the sky that is covered follows the
// coverage within a few hundredths; the ends are exact.
TEST(Clouds, cover_the_share_of_the_sky_that_was_asked_for) {
    for (const double coverage : {0.0, 0.2, 0.5, 0.7, 1.0}) {
        CloudLayer layer;
        layer.threshold = cloud_threshold(coverage);
        layer.optical_depth = 10;
        int covered = 0, count = 0;
        for (double pattern = 0.05; pattern < 1; pattern += 0.1)
            for (double detail = 0.05; detail < 1; detail += 0.1)
                for (double region = 0.05; region < 1; region += 0.1) {
                    covered += cloud_depth(layer, pattern, detail, region) > 0 ? 1 : 0;
                    ++count;
                }
        EXPECT_NEAR(covered / double(count), coverage, coverage == 0 || coverage == 1 ? 0 : 0.06);
    }
}

TEST(Clouds, a_closed_thick_layer_hides_the_sun_and_is_darker_the_thicker_it_is) {
    const Sky clear = under_clouds(0, 12), fair = under_clouds(0.4, 12);
    const Sky grey = under_clouds(1, 12), storm = under_clouds(1, 60);
    EXPECT_LT(fair.sun_irradiance().g, clear.sun_irradiance().g);
    EXPECT_GT(fair.sky_irradiance().g, clear.sky_irradiance().g) << "white clouds light the sea";
    EXPECT_LT(grey.sun_irradiance().g, 1e-3 * clear.sun_irradiance().g);
    EXPECT_LT(storm.sky_irradiance().g, 0.5 * grey.sky_irradiance().g);
    // CIE: an overcast sky gives some tenth of a clear noon's light; a storm less.
    const double noon = clear.white_radiance();
    EXPECT_NEAR(grey.white_radiance() / noon, 0.35, 0.2);
    EXPECT_LT(storm.white_radiance(), 0.25 * noon);
    EXPECT_GT(storm.white_radiance(), 0.03 * noon);
}

// No layer gives away more light than it was given. 15 %: the sky has the clouds that stand there, the
// beam is that of all of them.
TEST(Clouds, make_no_light) {
    const double clear = under_clouds(0, 12).white_radiance();
    for (const double depth : {0.5, 2.0, 8.0, 60.0})
        for (const double coverage : {0.3, 0.7, 1.0})
            EXPECT_LT(under_clouds(coverage, depth).white_radiance(), 1.15 * clear)
                << coverage << ", " << depth;
}

// The eye passes from one period of the noise to the next, and over all that its place is kept by: 20 cm on, every cloud is 20 cm on.
TEST(Clouds, go_on_where_their_noise_begins_anew) {
    Look look;
    look.clouds.coverage = 0.5;
    const glm::dvec2 period_m = look.clouds.size_m * cloud_periods;
    SkyMaker maker;
    for (const double periods : {0.0, 1.0, -3.0, cloud_wrap_periods})
        for (const glm::dvec2& along : {glm::dvec2(1, 0), glm::dvec2(0, 1)}) {
            const auto seen_at = [&](double past_m) {
                const glm::dvec2 place_m = along * (periods * period_m + past_m);
                return *maker.make(look, heavens_at_hour(13),
                                   {.east_m = place_m.x, .north_m = place_m.y});
            };
            const Sky before = seen_at(-0.1), after = seen_at(0.1);
            double change = 0, sum = 0;
            for (double elevation_deg = 10; elevation_deg < 90; elevation_deg += 5)
                for (double azimuth_deg = 0; azimuth_deg < 360; azimuth_deg += 10) {
                    const glm::dvec3 direction = towards(elevation_deg, azimuth_deg);
                    sum += before.behind(direction).g;
                    change += std::abs(after.behind(direction).g - before.behind(direction).g);
                }
            // Edges of clouds are tens of metres wide; 2 m change 1.3 %, other clouds 40 %.
            EXPECT_LT(change, 0.01 * sum) << periods << " periods along " << along.x;
        }
}

CloudLayer patchy_layer(const glm::dvec3& to_light) {
    CloudLayer layer;
    layer.threshold = cloud_threshold(0.5);
    layer.optical_depth = 8;
    layer.height_m = 1500;
    layer.period_m = {15e3, 5e3};
    layer.curvature_per_m = 0.5 / earth_radius_m;
    layer.to_light = to_light;
    return layer;
}

// What an eye on the sea sees left of the sun's disc is what falls of its beam there.
TEST(Clouds, shade_the_places_from_which_they_hide_the_sun) {
    for (const double elevation_deg : {75.0, 35.0, 15.0}) {
        const CloudLayer layer = patchy_layer(towards(elevation_deg, 130));
        int lit = 0, shaded = 0;
        for (double east_m = -9e3; east_m < 9e3; east_m += 700)
            for (double north_m = -9e3; north_m < 9e3; north_m += 700) {
                const double share =
                    beam_share(layer, small_noise(), noise_columns, noise_rows, {east_m, north_m});
                CloudLayer from_there = layer;
                from_there.origin += glm::dvec2(east_m, north_m) / layer.period_m;
                const CloudSeen seen = clouds_seen(from_there, small_noise(), noise_columns,
                                                   noise_rows, layer.to_light);
                // The one goes by the sun's height, the other by the angle at the layer: 1 % at 15 degrees.
                EXPECT_NEAR(std::log(share), std::log(seen.left), 1e-6 - 0.01 * std::log(share));
                lit += share > 0.99 ? 1 : 0;
                shaded += share < 0.01 ? 1 : 0;
            }
        EXPECT_GT(lit, 100);
        EXPECT_GT(shaded, 20) << elevation_deg;
    }
}

// The mean beam is what the light of a whole picture goes by. 0.04: it takes pattern, detail and region for independent.
TEST(Clouds, patches_of_light_have_the_mean_of_the_beam) {
    const CloudLayer layer = patchy_layer(towards(40, 20));
    double sum = 0;
    int count = 0;
    for (double east_m = 0; east_m < 200e3; east_m += 777) // many periods of the region
        for (double north_m = 0; north_m < 200e3; north_m += 777, ++count)
            sum += beam_share(layer, small_noise(), noise_columns, noise_rows, {east_m, north_m});
    EXPECT_NEAR(sum / count, mean_cloud_share(layer, small_noise()).straight, 0.04);
}

TEST(Clouds, without_clouds_every_place_has_the_same_light) {
    const Sky clear = under_clouds(0, 12);
    EXPECT_EQ(clear.beam_over_mean({300, -7000}), 1);
    EXPECT_EQ(clear.values().cloud_patches, 0) << "shaders do nothing for it";
    const Sky closed = under_clouds(1, 60);
    EXPECT_EQ(closed.values().cloud_patches, 0) << "nothing comes straight through";
    EXPECT_GT(under_clouds(0.5, 12).values().cloud_patches, 1);
}

// The edge of a cloud is thin, and seen near the horizon it hides the sky behind it: it has to shine as much as it hides, or
// clouds had dark rims.
TEST(Clouds, are_not_darker_at_their_edges_than_what_is_beside_and_within) {
    CloudLayer layer = patchy_layer(towards(60, 130));
    layer.threshold = -1; // everywhere, as thick as is said
    layer.light = glm::dvec3(90);
    layer.sky = glm::dvec3(12);
    constexpr double clear = 4; // of the sky behind
    for (const double elevation_deg : {8.0, 20.0, 60.0}) {
        const auto seen = [&](double optical_depth) {
            layer.optical_depth = optical_depth;
            const CloudSeen cloud = clouds_seen(layer, small_noise(), noise_columns, noise_rows,
                                                towards(elevation_deg));
            return clear * cloud.left + cloud.radiance.g;
        };
        const double within = seen(12);
        EXPECT_GT(within, clear);
        for (const double depth : {0.03, 0.1, 0.3, 1.0})
            EXPECT_GT(seen(depth), 0.97 * clear) << depth << " at " << elevation_deg;
    }
}

TEST(Clouds, stand_above_an_eye_below_them_and_below_one_above) {
    CloudLayer layer;
    layer.threshold = -1;
    layer.optical_depth = 5;
    layer.period_m = {15e3, 5e3};
    layer.curvature_per_m = 0.5 / earth_radius_m;
    layer.light = glm::dvec3(100);
    const auto seen = [&](double height_m, double elevation_deg) {
        layer.height_m = height_m;
        return clouds_seen(layer, small_noise(), noise_columns, noise_rows, towards(elevation_deg));
    };
    EXPECT_EQ(seen(1500, -5).distance_m, 0);
    EXPECT_NEAR(seen(1500, 90).distance_m, 1500, 0.5);
    EXPECT_NEAR(seen(1500, 30).distance_m, 3000, 5);
    EXPECT_EQ(seen(-8500, 5).distance_m, 0);
    EXPECT_NEAR(seen(-8500, -90).distance_m, 8500, 10);
    EXPECT_EQ(seen(-8500, -1).distance_m, 0) << "below the level, above the clouds' horizon";
    // The layer bends with the earth: level, it is met where the sphere is.
    EXPECT_NEAR(seen(1500, 0).distance_m, std::sqrt(2 * earth_radius_m * 1500), 200);
    EXPECT_LT(seen(1500, 20).left, 1e-5);
}

} // namespace
} // namespace seaway::client
