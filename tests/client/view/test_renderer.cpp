// SPDX-License-Identifier: Apache-2.0
// Pictures held against geometry, against the surface that answers queries and against the optics
// of a flat sea. Validation layers are on; one message of theirs fails the test.
#include "tests/client/view/renderer_fixture.h"

namespace seaway::client {
namespace {

TEST_F(RendererTest, drawn_points_are_where_a_query_finds_the_sea) {
    SyntheticSea sea = gale();
    // Through a long lens, so that pixels are smaller than cells: what is seen is the mesh itself.
    camera_.pitch_deg = -38;
    camera_.view_deg = 8;
    camera_.x_m = 5230.25;
    camera_.y_m = -88110.5;
    const SeaFrame frame = sea.at(100'300'000);
    const sea::Surface surface = sea.surface(frame);
    const Picture picture = render(frame, sky_at_hour(15), DebugView::place);
    int compared = 0;
    double moved_least_m = 1e9;
    for (int y = 0; y < picture.height; y += 3)
        for (int x = 0; x < picture.width; x += 5) {
            const float* place = picture.pixel(x, y);
            const glm::dvec2 still(place[0], place[1]);
            const glm::dvec2 eye(camera_.x_m, camera_.y_m);
            const sea::LagrangianPoint p =
                surface.at(eye.x + still.x, eye.y + still.y, frame.time_us);
            const glm::dvec2 moved(frame.choppiness.x * p.displacement_x,
                                   frame.choppiness.y * p.displacement_y);
            const glm::dvec2 there = eye + still + moved;
            const sea::Answer answer = surface.answer({there.x, there.y, frame.time_us});
            if (answer.flags & sea::answer_folded)
                continue;
            ++compared;
            moved_least_m = std::min(moved_least_m, glm::length(moved));
            // Cells are 0.1 m here: flat triangles miss (k s)^2 / 8 of the finest waves, 10 % of
            // some centimetres.
            EXPECT_NEAR(static_cast<double>(place[2]), answer.height_m, 0.01) << x << ", " << y;
            // And there the pixel's ray meets it: within a pixel, and a centimetre more of flat triangles sideways.
            const glm::dvec3 seen(still + moved, static_cast<double>(place[2]) - camera_.z_m);
            EXPECT_LT(off_ray_m(seen, x, y), camera_.pixel_rad() * glm::length(seen) + 0.02)
                << x << ", " << y;
        }
    EXPECT_GT(compared, 200);
    EXPECT_GT(moved_least_m, 0.5) << "else it does not matter whether points are moved";
}

// From 3000 m the horizon lies six pixels below the level; the edge of a plane that ends where the sea
// is out of sight would lie three below it.
TEST_F(RendererTest, the_horizon_is_straight_and_where_geometry_says) {
    for (const double z_m : {14.0, 3000.0}) {
        camera_.z_m = z_m;
        const Picture picture = render(flat_sea(), sky_at_hour(15), DebugView::place);
        const double dip = horizon_dip_rad(z_m);
        for (int x = 0; x < picture.width; ++x)
            for (int y = 0; y < picture.height; ++y) {
                const double elevation = std::asin(ray(x, y).z);
                const float* place = picture.pixel(x, y);
                const bool sky = place[0] == 0 && place[1] == 0;
                // The pixel that the horizon crosses may be either.
                if (std::abs(elevation + dip) > camera_.pixel_rad()) {
                    EXPECT_EQ(sky, elevation > -dip) << x << ", " << y << " from " << z_m << " m";
                }
            }
    }
}

// At 300 m a pixel is 1.5 m across the line of sight and 30 m along it. Waves of 25 m that run across
// it are resolved all the same: the strip's probes keep at least sinc(6.4 m / 25 m) = 0.9 of them, less
// what mips blur. A round filter of the strip's length would leave nothing.
TEST_F(RendererTest, a_pixel_is_a_strip_along_the_line_of_sight_and_resolves_waves_across_it) {
    SyntheticSea sea(one_wave(0.1, 100, 4));
    const SeaFrame frame = sea.at(0);
    const sea::Surface surface = sea.surface(frame);
    camera_.yaw_deg = 0; // north; the waves run east
    const Picture slope = render(frame, sky_at_hour(12), DebugView::slope);
    const Picture place = render(frame, sky_at_hour(12), DebugView::place);
    double product = 0, squares = 0;
    for (std::size_t i = 0; i < place.rgba.size(); i += 4) {
        const auto x = static_cast<double>(place.rgba[i]),
                   y = static_cast<double>(place.rgba[i + 1]);
        if (std::abs(y - 300) > 30 || std::abs(x) > 30)
            continue;
        const double truth = surface.at(x, y, 0).slope_x;
        product += truth * static_cast<double>(slope.rgba[i]);
        squares += truth * truth;
    }
    ASSERT_GT(squares, 0);
    EXPECT_GT(product / squares, 0.6);
    EXPECT_LT(product / squares, 1.02);
}

TEST_F(RendererTest, the_sky_is_that_of_the_model) {
    // At the sea, and from where the horizon has sunk by three degrees.
    for (const double z_m : {14.0, 10e3}) {
        camera_.z_m = z_m;
        const Sky sky(sun_direction(15), z_m);
        const Picture picture = render(flat_sea(), sky);
        for (int y = 0; y < 40; y += 8)
            for (int x = 0; x < picture.width; x += 16) {
                const glm::dvec3 truth = sky.behind(ray(x, y));
                for (int c = 0; c < 3; ++c) // the device's weights have 8 bits
                    EXPECT_NEAR(static_cast<double>(picture.pixel(x, y)[c]) / truth[c], 1, 5e-3);
            }
    }
}

// With one sample a pixel is sea or sky, each drawn by a pipeline of its own: no pixel is left out, none is drawn as the
// other. Four samples differ along crests and at the horizon alone.
TEST_F(RendererTest, sea_and_sky_of_one_sample_a_pixel_are_those_of_four) {
    SyntheticSea sea = gale();
    const SeaFrame frame = sea.at(100'000'000);
    const Sky& sky = sky_at_hour(15);
    Quality one = quality_table[quality_high];
    one.samples = 1;
    const Picture many = render(frame, sky);
    const Picture single = render(frame, sky, DebugView::final, {.quality = one});
    int other = 0, pixels = 0;
    for (std::size_t i = 0; i < many.rgba.size(); i += 4, ++pixels)
        other += std::abs(single.rgba[i + 1] / many.rgba[i + 1] - 1) > 0.1f ? 1 : 0;
    EXPECT_LT(other, 0.04 * pixels);
    camera_.pitch_deg = 40; // sky alone
    EXPECT_EQ(render(frame, sky).rgba, render(frame, sky, DebugView::final, {.quality = one}).rgba);
}

TEST_F(RendererTest, a_flat_sea_mirrors_the_sky_by_fresnel) {
    const Sky& sky = sky_at_hour(12); // in the south; the camera looks north-east: no glint
    const RenderOptions clear_air{.air = false};
    const Picture picture = render(flat_sea(), sky, DebugView::final, clear_air);
    const double sun_azimuth = std::atan2(sky.sun_direction().y, sky.sun_direction().x);
    const glm::dvec3 reflectance(0.008, 0.024, 0.026); // of the water body, client/view/view_values
    const glm::dvec3 down = sky.sky_irradiance() + sky.sun_irradiance() * sky.sun_direction().z;
    for (int y = camera_.height / 2; y < camera_.height; y += 10)
        for (int x = 4; x < picture.width; x += 33) {
            const glm::dvec3 d = ray(x, y);
            const double cosine = -d.z;
            const double fresnel = 0.02 + 0.98 * std::pow(1 - cosine, 5);
            const double turn = std::remainder(std::atan2(d.y, d.x) - sun_azimuth, 2 * pi);
            const glm::dvec3 mirrored = sky.radiance(std::asin(-d.z), std::abs(turn));
            for (int c = 0; c < 3; ++c) {
                const double body = reflectance[c] * down[c] / pi;
                // 3 %: texels of the sky, and a tint that flat water (height 0) does not have.
                EXPECT_NEAR(static_cast<double>(picture.pixel(x, y)[c]) /
                                (fresnel * mirrored[c] + (1 - fresnel) * body),
                            1, 0.03)
                    << x << ", " << y << " channel " << c;
            }
        }
}

TEST_F(RendererTest, the_sea_glitters_below_the_sun_and_nowhere_else) {
    SyntheticSea sea = gale();
    const SeaFrame frame = sea.at(100'000'000);
    const Sky& sky = sky_at_hour(15.5); // about 33 degrees high, in the west-south-west
    const double azimuth = std::atan2(sky.sun_direction().y, sky.sun_direction().x);
    const auto mean_of_sea = [&](double yaw_deg) {
        camera_.yaw_deg = yaw_deg;
        const Picture picture = render(frame, sky);
        double sum = 0;
        for (int y = camera_.height / 2; y < camera_.height; ++y)
            for (int x = 0; x < picture.width; ++x)
                sum += luminance(picture.pixel(x, y));
        return sum / (picture.width * picture.height / 2.0);
    };
    const double sun_bearing = 90 - azimuth * 180 / pi;
    const double up_sun = mean_of_sea(sun_bearing);
    const double down_sun = mean_of_sea(sun_bearing + 180);
    // Facets that mirror a sun 33 degrees high to an eye that looks 10 degrees down tilt 11 degrees
    // towards the sun, slope 0.2: with the gale's rms slope of 0.2 they are common. Away from the
    // sun they would tilt 68 degrees: there are none, and only the sky's side counts.
    EXPECT_GT(up_sun, 3 * down_sun);
    for (const double aside_deg : {90, -90}) // a tilt of 50 degrees, slope 1.2: there are none
        EXPECT_LT(mean_of_sea(sun_bearing + aside_deg), 2 * down_sun) << aside_deg;
}

TEST_F(RendererTest, every_pixel_is_a_number_and_none_is_dark_by_day) {
    SyntheticSea sea = gale();
    const SeaFrame frame = sea.at(100'000'000);
    const Sky& sky = sky_at_hour(15);
    const double azimuth = std::atan2(sky.sun_direction().y, sky.sun_direction().x);
    // Straight up-sun, straight down-sun and down from within the waves.
    for (const double yaw_deg : {90 - azimuth * 180 / pi, 270 - azimuth * 180 / pi})
        for (const double z_m : {2.0, 14.0}) {
            camera_.yaw_deg = yaw_deg;
            camera_.z_m = z_m;
            const Picture picture = render(frame, sky);
            for (std::size_t i = 0; i < picture.rgba.size(); ++i) {
                ASSERT_TRUE(std::isfinite(picture.rgba[i])) << "float " << i;
                ASSERT_GT(picture.rgba[i], 0.0f) << "float " << i;
            }
        }
}

/// The ratio in the western half of the tile, and in the eastern one.
void set_foam(SeaFrame& frame, double mean, float west, float east) {
    sea::Keyframe keyframe;
    keyframe.size = frame.cascades[0].spec.size;
    keyframe.length_m = frame.cascades[0].spec.length_m;
    keyframe.fields = {sea::Field::foam};
    keyframe.values.resize(keyframe.plane_size());
    const auto size = static_cast<std::size_t>(keyframe.size);
    for (std::size_t i = 0; i < keyframe.values.size(); ++i)
        keyframe.values[i] = i % size < size / 2 ? west : east;
    frame.foam_mean = mean;
    frame.cascades[0].foam_before = frame.cascades[0].foam_after =
        std::make_shared<const sea::Keyframe>(std::move(keyframe));
}

TEST_F(RendererTest, breaking_crests_are_white_and_troughs_never) {
    // k a = 2 pi 4 / 100 * 2 = 0.5: the Jacobian is 0.5 on crests, 1.5 in troughs.
    SyntheticSea sea(one_wave(2.0, 100, 4));
    SeaFrame frame = sea.at(0);
    frame.foam_threshold = 0.6;
    set_foam(frame, 0.02, 0, 0); // nothing broke before: one cascade's coverage is mean * ratio
    camera_.z_m = 30;
    camera_.pitch_deg = -30;
    const auto white = [&] {
        const Picture foam = render(frame, sky_at_hour(12), DebugView::foam);
        const Picture place = render(frame, sky_at_hour(12), DebugView::place);
        double sums[2] = {0, 0}, counts[2] = {0, 0};
        for (std::size_t i = 0; i < foam.rgba.size(); i += 4)
            for (const auto& [which, there] : {std::pair{0, place.rgba[i + 2] > 1.9f},
                                               std::pair{1, place.rgba[i + 2] < -1.0f}}) {
                sums[which] += there ? static_cast<double>(foam.rgba[i]) : 0.0;
                counts[which] += there ? 1 : 0;
            }
        EXPECT_GT(counts[0], 100);
        EXPECT_GT(counts[1], 100);
        return std::pair{sums[0] / counts[0], sums[1] / counts[1]};
    };
    const auto [crests, troughs] = white();
    EXPECT_GT(crests, 0.5) << "most of the highest crests, whose Jacobian is below the threshold";
    // Below -1 m, J is above 1.25: six standard deviations of the law from breaking.
    EXPECT_LT(troughs, 1e-3 * crests);
    frame.foam_mean = 0;
    EXPECT_EQ(white().first, 0) << "a scene without foam has none";
}

// Noise has some hundred patches in a picture: their area is the share within a tenth or so, and
// the soft edges of patches take from one side what they give to the other.
TEST_F(RendererTest, what_has_broken_covers_the_share_that_the_foam_maps_say) {
    SeaFrame frame = flat_sea();
    frame.foam_threshold = 0.1;
    camera_.x_m = 50; // on the border of the halves, looking along it
    camera_.yaw_deg = 0;
    camera_.z_m = 40;
    camera_.pitch_deg = -40;
    for (const float share : {0.05f, 0.3f, 0.7f}) {
        set_foam(frame, 0.1, 0, 10 * share);
        const Picture foam = render(frame, sky_at_hour(12), DebugView::foam);
        const Picture place = render(frame, sky_at_hour(12), DebugView::place);
        double west = 0, east = 0, west_pixels = 0, east_pixels = 0;
        for (std::size_t i = 0; i < foam.rgba.size(); i += 4) {
            const double at = (camera_.x_m + static_cast<double>(place.rgba[i])) / 100;
            const double u = at - std::floor(at);
            const double value = static_cast<double>(foam.rgba[i]);
            if (u > 0.05 && u < 0.45)
                west += value, ++west_pixels;
            if (u > 0.55 && u < 0.95)
                east += value, ++east_pixels;
        }
        EXPECT_EQ(west, 0) << share;
        ASSERT_GT(east_pixels, 1000) << share;
        EXPECT_GT(west_pixels, 1000) << share;
        EXPECT_NEAR(east / east_pixels, static_cast<double>(share),
                    0.02 + 0.15 * static_cast<double>(share));
    }
}

// Where a pixel covers many waves it is as white as the sea is on average, whatever breaks in it.
TEST_F(RendererTest, the_distance_is_as_white_as_the_sea_is_on_average) {
    SyntheticSea sea = gale();
    SeaFrame frame = sea.at(5'000'000);
    frame.foam_threshold = 0.71;
    frame.foam_mean = 0.024;
    camera_.z_m = 3000;
    camera_.pitch_deg = -30;
    const Picture foam = render(frame, sky_at_hour(12), DebugView::foam);
    double sum = 0;
    for (std::size_t i = 0; i < foam.rgba.size(); i += 4)
        sum += static_cast<double>(foam.rgba[i]);
    const double mean = sum / (static_cast<double>(foam.rgba.size()) / 4);
    // A pixel of 15 m: what little of the long waves it resolves may add a few percent.
    EXPECT_NEAR(mean, 0.024, 0.1 * 0.024);
}

TEST_F(RendererTest, normals_are_exact_on_a_choppy_wave) {
    SyntheticSea sea(one_wave(2.0, 100, 4));
    const SeaFrame frame = sea.at(0);
    const sea::Surface surface = sea.surface(frame);
    camera_.z_m = 20;
    camera_.pitch_deg = -35;
    const Picture slope = render(frame, sky_at_hour(12), DebugView::slope);
    const Picture place = render(frame, sky_at_hour(12), DebugView::place);
    int compared = 0;
    for (std::size_t i = 0; i < slope.rgba.size(); i += 4 * 37) {
        const sea::LagrangianPoint p = surface.at(static_cast<double>(place.rgba[i]),
                                                  static_cast<double>(place.rgba[i + 1]), 0);
        const double truth = p.slope_x / (1 + p.strain_xx); // long-crested: no cross terms
        // A pixel is 0.1 to 1 m of a 25 m wave, curvature at most 0.5: it blurs this much.
        EXPECT_NEAR(static_cast<double>(slope.rgba[i]), truth, 0.02);
        EXPECT_NEAR(static_cast<double>(slope.rgba[i + 1]), 0, 1e-4);
        ++compared;
    }
    EXPECT_GT(compared, 500);
}

// An oblique wave that is choppier along east than along north: every term has its own factor.
sea::Realization oblique_wave() {
    sea::Realization sea = one_wave(2.0, 100, 3, 3);
    sea.choppiness = {1.4, 0.6};
    return sea;
}

TEST_F(RendererTest, normals_are_exact_where_choppiness_differs_by_direction) {
    SyntheticSea sea(oblique_wave());
    const SeaFrame frame = sea.at(0);
    const sea::Surface surface = sea.surface(frame);
    camera_.z_m = 10;
    camera_.pitch_deg = -50;
    const Picture slope = render(frame, sky_at_hour(12), DebugView::slope);
    const Picture place = render(frame, sky_at_hour(12), DebugView::place);
    const double lx = frame.choppiness.x, ly = frame.choppiness.y;
    for (std::size_t i = 0; i < slope.rgba.size(); i += 4 * 37) {
        const sea::LagrangianPoint p = surface.at(static_cast<double>(place.rgba[i]),
                                                  static_cast<double>(place.rgba[i + 1]), 0);
        const glm::dvec3 normal =
            glm::cross(glm::dvec3(1 + lx * p.strain_xx, ly * p.strain_xy, p.slope_x),
                       glm::dvec3(lx * p.strain_xy, 1 + ly * p.strain_yy, p.slope_y));
        // As above: what a pixel blurs.
        EXPECT_NEAR(static_cast<double>(slope.rgba[i]), -normal.x / normal.z, 0.02);
        EXPECT_NEAR(static_cast<double>(slope.rgba[i + 1]), -normal.y / normal.z, 0.02);
    }
}

// What is drawn stands where the picture's points are moved to, not where they were: a pixel's ray meets
// the point that the pixel shows.
TEST_F(RendererTest, a_pixel_shows_the_moved_point_that_its_ray_meets) {
    SyntheticSea sea(oblique_wave());
    const SeaFrame frame = sea.at(0);
    const sea::Surface surface = sea.surface(frame);
    camera_.z_m = 10;
    camera_.pitch_deg = -50;
    const Picture picture = render(frame, sky_at_hour(12), DebugView::place);
    double moved_most_m = 0;
    for (int y = 0; y < picture.height; y += 7)
        for (int x = 0; x < picture.width; x += 5) {
            const float* place = picture.pixel(x, y);
            const glm::dvec2 still(place[0], place[1]);
            const sea::LagrangianPoint p = surface.at(still.x, still.y, 0);
            const glm::dvec2 moved(frame.choppiness.x * p.displacement_x,
                                   frame.choppiness.y * p.displacement_y);
            moved_most_m = std::max(moved_most_m, glm::length(moved));
            const glm::dvec3 seen(still + moved, static_cast<double>(place[2]) - camera_.z_m);
            // A pixel, and a centimetre of flat triangles.
            EXPECT_LT(off_ray_m(seen, x, y), camera_.pixel_rad() * glm::length(seen) + 0.01)
                << x << ", " << y;
        }
    EXPECT_GT(moved_most_m, 1.5);
}

// Maps are kept from frame to frame: a sea of more tiles needs others, of the same size.
TEST_F(RendererTest, a_sea_of_more_tiles_is_drawn_as_by_a_new_renderer) {
    sea::Realization two = one_wave(0.7, 90, 3, -2);
    two.cascades.push_back(one_wave(0.2, 31, -1, 4).cascades[0]);
    const SeaFrame one = SyntheticSea(one_wave(0.7, 90, 3)).at(0);
    const SeaFrame more = SyntheticSea(two).at(0);
    const Sky& sky = sky_at_hour(12);
    (void)render(one, sky, DebugView::slope);
    const Picture picture = render(more, sky, DebugView::slope);
    Result<Renderer> renderer = Renderer::create(*device_, camera_.width, camera_.height);
    ASSERT_TRUE(renderer) << renderer.error().message;
    const Result<Picture> by_new = renderer->render(more, camera_, sky, {DebugView::slope});
    ASSERT_TRUE(by_new) << by_new.error().message;
    EXPECT_EQ(picture.rgba, by_new->rgba);
}

// draw() returns while the device works. What it reads of the sea before stays until it has.
TEST_F(RendererTest, a_sea_of_larger_tiles_may_follow_while_a_frame_is_under_way) {
    SyntheticSea coarse(one_wave(0.5, 90, 3)), fine(one_wave(0.5, 90, 3, 0, 128));
    Renderer& renderer = renderer_for({});
    for (SyntheticSea* sea : {&coarse, &fine, &coarse})
        ASSERT_TRUE(
            renderer.draw(sea->at(500'000), camera_, sky_at_hour(15), {}, {}, Wanted::nothing));
    ASSERT_TRUE(renderer.finish());
}

TEST_F(RendererTest, the_same_sea_is_the_same_bytes) {
    SyntheticSea sea = gale();
    const SeaFrame frame = sea.at(100'000'000);
    const Sky& sky = sky_at_hour(15);
    const Picture first = render(frame, sky);
    (void)render(frame, sky_at_hour(40));
    EXPECT_EQ(render(frame, sky).rgba, first.rgba) << "whatever was drawn between";
    renderers_.clear();
    EXPECT_EQ(render(frame, sky).rgba, first.rgba) << "and by another renderer";
}

} // namespace
} // namespace seaway::client
