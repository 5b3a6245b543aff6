// SPDX-License-Identifier: Apache-2.0
// Views of numbers and the edges of things: each held against what the sea, the mesh or the sun says.
#include <algorithm>

#include "client/view/sea/mesh.h"
#include "gpu/draw/graphics_pipeline.h"
#include "shaders/view/final_frag.h"
#include "shaders/view/picture_vert.h"
#include "tests/client/view/renderer_fixture.h"

namespace seaway::client {
namespace {

class ViewsTest : public RendererTest {
  protected:
    ViewsTest() {
        camera_ = {.x_m = 311.5,
                   .y_m = -77.25,
                   .z_m = 12,
                   .yaw_deg = 130,
                   .pitch_deg = -45,
                   .width = 160,
                   .height = 90};
    }
    /// Two oblique waves of different tiles, choppier along east.
    static sea::Realization crossing() {
        sea::Realization sea = one_wave(1.1, 90, 3, -2);
        sea.cascades.push_back(one_wave(0.3, 31, -1, 4).cascades[0]);
        sea.choppiness = {1.1, 0.5};
        return sea;
    }
    glm::dvec2 world(const float* place) const {
        return {camera_.x_m + static_cast<double>(place[0]),
                camera_.y_m + static_cast<double>(place[1])};
    }
};

TEST_F(ViewsTest, each_cascade_shows_its_own_slopes) {
    SyntheticSea sea(crossing());
    const SeaFrame frame = sea.at(0);
    const Picture place = render(frame, sky_at_hour(12), DebugView::place);
    for (int cascade = 0; cascade < 2; ++cascade) {
        const auto index = static_cast<std::size_t>(cascade);
        const sea::Surface alone({frame.cascades[index].keyframes}, frame.choppiness, {}, {});
        const Result<Picture> picture =
            renderer_for({}).render(frame, camera_, sky_at_hour(12), {DebugView::cascade, cascade});
        ASSERT_TRUE(picture) << picture.error().message;
        for (int y = 3; y < place.height; y += 11)
            for (int x = 3; x < place.width; x += 13) {
                const glm::dvec2 at = world(place.pixel(x, y));
                const sea::LagrangianPoint p = alone.at(at.x, at.y, 0);
                // What a pixel of some decimetres blurs of the waves of 7 m and 25 m.
                EXPECT_NEAR(static_cast<double>(picture->pixel(x, y)[0]), p.slope_x, 0.01);
                EXPECT_NEAR(static_cast<double>(picture->pixel(x, y)[1]), p.slope_y, 0.01);
            }
    }
}

TEST_F(ViewsTest, normals_are_unit_vectors_square_to_both_tangents) {
    SyntheticSea sea(crossing());
    const SeaFrame frame = sea.at(0);
    const sea::Surface surface = sea.surface(frame);
    const Sky& sky = sky_at_hour(12);
    const Picture place = render(frame, sky, DebugView::place);
    const Picture normal = render(frame, sky, DebugView::normal);
    const Picture jacobian = render(frame, sky, DebugView::jacobian);
    const double lx = frame.choppiness.x, ly = frame.choppiness.y;
    for (int y = 3; y < place.height; y += 11)
        for (int x = 3; x < place.width; x += 13) {
            const glm::dvec2 at = world(place.pixel(x, y));
            const sea::LagrangianPoint p = surface.at(at.x, at.y, 0);
            const float* found = normal.pixel(x, y);
            const glm::dvec3 n(found[0], found[1], found[2]);
            EXPECT_NEAR(glm::length(n), 1, 1e-6);
            // As above: what a pixel blurs.
            EXPECT_NEAR(glm::dot(n, {1 + lx * p.strain_xx, ly * p.strain_xy, p.slope_x}), 0, 0.015);
            EXPECT_NEAR(glm::dot(n, {lx * p.strain_xy, 1 + ly * p.strain_yy, p.slope_y}), 0, 0.015);
            EXPECT_NEAR(static_cast<double>(jacobian.pixel(x, y)[0]),
                        sea::jacobian(p, frame.choppiness), 0.015);
        }
}

TEST_F(ViewsTest, the_grid_is_every_sixteenth_row_and_column_of_the_mesh) {
    SyntheticSea sea(crossing());
    const SeaFrame frame = sea.at(0);
    for (const double pitch_deg : {-12.0, -45.0}) { // a fan, and a whole circle
        camera_.pitch_deg = pitch_deg;
        const Sky& sky = sky_at_hour(12);
        const Picture place = render(frame, sky, DebugView::place);
        const Picture grid = render(frame, sky, DebugView::grid);
        const Mesh mesh = build_mesh(camera_, frame, 2.5);
        int lines = 0, compared = 0, wrong = 0;
        for (int y = 0; y < place.height; ++y)
            for (int x = 0; x < place.width; ++x) {
                const float* at = place.pixel(x, y);
                if (at[0] == 0 && at[1] == 0)
                    continue; // sky
                const glm::dvec2 from_apex = glm::dvec2(at[0], at[1]) - mesh.apex_m;
                const auto r = static_cast<float>(glm::length(from_apex));
                const auto after = std::upper_bound(mesh.rows_m.begin(), mesh.rows_m.end(), r);
                if (after == mesh.rows_m.begin() || after == mesh.rows_m.end())
                    continue;
                const double row = static_cast<double>(after - mesh.rows_m.begin() - 1) +
                                   static_cast<double>((r - after[-1]) / (after[0] - after[-1]));
                const double turn = std::atan2(from_apex.y, from_apex.x) - mesh.azimuth_rad;
                const double column = (turn - 2 * pi * std::floor(turn / (2 * pi))) / mesh.step_rad;
                const auto on_line = [](double cell) {
                    return cell / 16 - std::floor(cell / 16) < 0.08;
                };
                const bool line = on_line(row) || on_line(column);
                lines += line;
                ++compared;
                wrong += line != (grid.pixel(x, y)[0] > 0.5f);
            }
        EXPECT_GT(lines, 0.1 * compared);
        EXPECT_LT(lines, 0.25 * compared);
        EXPECT_LT(wrong, 0.01 * compared) << "rounding of floats at the edge of a line";
    }
}

// From within a gale crests hide the sea behind them. What a pixel shows lies where its ray goes, not on
// the plane of a triangle that the pixel grazes.
TEST_F(ViewsTest, at_the_edges_of_crests_a_pixel_shows_what_lies_on_its_ray) {
    SyntheticSea sea = gale();
    const SeaFrame frame = sea.at(100'000'000);
    camera_ = {.z_m = 6, .yaw_deg = 40, .pitch_deg = -2, .width = 240, .height = 136};
    const sea::Surface surface = sea.surface(frame);
    const Picture picture = render(frame, sky_at_hour(15), DebugView::place);
    int sea_pixels = 0, far_off = 0;
    for (int y = 0; y < picture.height; ++y)
        for (int x = 0; x < picture.width; ++x) {
            const float* place = picture.pixel(x, y);
            if (place[0] == 0 && place[1] == 0)
                continue;
            const glm::dvec2 still(place[0], place[1]);
            const double distance_m = glm::length(still);
            if (distance_m > 2000)
                continue; // the planet curves, and cells are as large as waves
            const sea::LagrangianPoint p = surface.at(still.x, still.y, frame.time_us);
            const glm::dvec3 seen(still.x + frame.choppiness.x * p.displacement_x,
                                  still.y + frame.choppiness.y * p.displacement_y,
                                  static_cast<double>(place[2]) - camera_.z_m);
            const glm::dvec3 through = ray(x, y);
            ++sea_pixels;
            const double along = glm::dot(seen, through);
            const double off = glm::length(seen - along * through) / std::max(along, 1e-3);
            if (off > 8 * camera_.pixel_rad())
                ++far_off;
        }
    EXPECT_GT(sea_pixels, 5000);
    EXPECT_LE(far_off, sea_pixels / 1000); // on an edge a sample may be of the crest's other side
}

// A cascade without foam maps is as white as the average; here all of it is.
SeaFrame white_sea() {
    SeaFrame frame = flat_sea();
    frame.foam_mean = 1;
    return frame;
}

// Foam between thin and thick reflects six tenths of what falls on it (Whitlock 1982 has 0.54): of the sky and of the beam of the
// sun by the sine of its height.
TEST_F(ViewsTest, a_sea_that_is_all_foam_is_a_sheet_in_the_light_of_sky_and_sun) {
    const Sky& sky = sky_at_hour(16);
    const Picture picture = render(white_sea(), sky, DebugView::final, {.air = false});
    const glm::dvec3 lit =
        0.6 / pi * (sky.sky_irradiance() + sky.sun_irradiance() * sky.sun_direction().z);
    glm::dvec3 sum(0);
    int count = 0;
    double least = 1e9, most = 0;
    for (int y = 30; y < picture.height; ++y)
        for (int x = 0; x < picture.width; ++x) {
            for (int c = 0; c < 3; ++c)
                sum[c] += static_cast<double>(picture.pixel(x, y)[c]);
            const double share = static_cast<double>(picture.pixel(x, y)[1]) / lit[1];
            least = std::min(least, share);
            most = std::max(most, share);
            ++count;
        }
    // Bumps and thin places are lighter and darker; all of them together are the sheet. Some 400 bumps are in the
    // picture, of 20 % each.
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(sum[c] / count / lit[c], 1, 0.03);
    EXPECT_GT(least, 0.2);
    EXPECT_LT(most, 1.8);
    EXPECT_GT(most - least, 0.2) << "it has a surface of its own";
}

// A white sea is brighter than the sky behind it; where the horizon runs through a pixel, each of its
// four samples counts.
TEST_F(ViewsTest, a_pixel_on_the_horizon_is_sky_and_sea_by_their_shares) {
    const Sky& sky = sky_at_hour(12);
    camera_.z_m = 14;
    int mixed = 0;
    for (const double part : {0.2, 0.4, 0.6, 0.8}) {
        // The horizon lies this part of a pixel below the upper edge of row 45.
        camera_.pitch_deg = (-horizon_dip_rad(camera_.z_m) + part * camera_.pixel_rad()) * 180 / pi;
        const Picture picture = render(white_sea(), sky, DebugView::final, {.air = false});
        const int x = picture.width / 2;
        const double above = luminance(picture.pixel(x, 43));
        const double below = luminance(picture.pixel(x, 47));
        const double share = (luminance(picture.pixel(x, 45)) - above) / (below - above);
        EXPECT_GT(below, 1.2 * above);
        EXPECT_NEAR(share, 1 - part, 0.3) << "samples lie at eighths: within a quarter";
        mixed += share > 0.2 && share < 0.8;
    }
    EXPECT_GE(mixed, 2);
}

TEST_F(ViewsTest, the_disk_of_the_sun_sends_all_of_its_light_and_no_more) {
    const Sky& sky = sky_at_hour(16);
    const glm::dvec3 sun = sky.sun_direction();
    camera_ = {.z_m = 12,
               .yaw_deg = 90 - std::atan2(sun.y, sun.x) * 180 / pi,
               .pitch_deg = std::asin(sun.z) * 180 / pi,
               .view_deg = 3,
               .width = 96,
               .height = 96};
    const Picture picture = render(flat_sea(), sky);
    const double pixel_sr = camera_.pixel_rad() * camera_.pixel_rad();
    const glm::dvec3 behind = sky.radiance(std::asin(sun.z), 0);
    glm::dvec3 light(0);
    for (std::size_t i = 0; i < picture.rgba.size(); i += 4)
        for (int c = 0; c < 3; ++c)
            light[c] +=
                (static_cast<double>(picture.rgba[i + static_cast<std::size_t>(c)]) - behind[c]) *
                pixel_sr;
    for (int c = 0; c < 3; ++c) // the edge is smooth over two pixels of a disk of 17
        EXPECT_NEAR(light[c] / sky.sun_irradiance()[c], 1, 0.03);
    // The centre is the sun, beyond its radius of half a hundredth of a radian is the sky.
    EXPECT_GT(luminance(picture.pixel(48, 48)), 1e3 * luminance(picture.pixel(48, 30)));
    EXPECT_GT(luminance(picture.pixel(48, 48)), 1e3 * luminance(picture.pixel(30, 48)));
}

// Patches of foam have soft edges: a pixel that is much finer than the finest patches is nearly as white
// as its neighbours.
TEST_F(ViewsTest, patches_of_foam_have_no_seams) {
    SeaFrame frame = flat_sea();
    frame.foam_mean = 0.5;
    frame.significant_height_m = 100; // patches of 16 m, lace of 1 m and 1/4 m
    double least = 1, most = 0, jump = 0;
    for (int look = 0; look < 20;
         ++look) { // a look is a tenth of a metre: edges are some pixels wide
        camera_ = {.x_m = 7.3 * look,
                   .y_m = -4.1 * look,
                   .z_m = 2.5,
                   .pitch_deg = -80,
                   .view_deg = 2,
                   .width = 120,
                   .height = 68};
        const Picture foam = render(frame, sky_at_hour(12), DebugView::foam);
        for (int y = 1; y < foam.height; ++y)
            for (int x = 1; x < foam.width; ++x) {
                const auto here = static_cast<double>(foam.pixel(x, y)[0]);
                least = std::min(least, here);
                most = std::max(most, here);
                for (const float* beside : {foam.pixel(x - 1, y), foam.pixel(x, y - 1)})
                    jump = std::max(jump, std::abs(here - static_cast<double>(beside[0])));
            }
    }
    EXPECT_LT(least, 0.01);
    EXPECT_GT(most, 0.99);
    EXPECT_LT(jump, 0.3);
}

// From 60 m the picture is 72 m wide, east to the right: six rows of 10 m. Waves run east; so do the rows, and means along
// them differ by more than means across them.
TEST_F(ViewsTest, foam_gathers_in_rows_along_the_wind_once_there_is_enough_of_it) {
    SeaFrame frame = flat_sea();
    frame.mean_from_deg = 270;
    frame.significant_height_m = 0.5; // patches are small
    camera_ = {.z_m = 60, .yaw_deg = 0, .pitch_deg = -89, .width = 160, .height = 160};
    struct Scatter {
        double of_rows, of_columns;
    };
    const auto scatter = [&](double foam_mean) {
        frame.foam_mean = foam_mean;
        const Picture foam = render(frame, sky_at_hour(12), DebugView::foam);
        std::vector<double> rows(160), columns(160);
        for (int y = 0; y < 160; ++y)
            for (int x = 0; x < 160; ++x) {
                const double share = static_cast<double>(foam.pixel(x, y)[0]) / 160;
                rows[static_cast<std::size_t>(y)] += share;
                columns[static_cast<std::size_t>(x)] += share;
            }
        const auto of = [](const std::vector<double>& means) {
            double sum = 0, squares = 0;
            for (const double mean : means)
                sum += mean, squares += mean * mean;
            return std::sqrt(std::max(squares - sum * sum / 160, 0.0));
        };
        return Scatter{of(rows), of(columns)};
    };
    const Scatter gale = scatter(0.1);
    EXPECT_GT(gale.of_rows, 1.8 * gale.of_columns);
    EXPECT_GT(gale.of_rows, 0.05);
    EXPECT_LT(scatter(0.004).of_rows, 1e-4) << "below 10 m/s there are none";
}

// Near, where every bubble of the lace is seen, holes and all. Looks lie in other rows of the wind: their shares differ.
TEST_F(ViewsTest, lace_leaves_as_much_white_as_the_share_says) {
    SeaFrame frame = flat_sea();
    frame.significant_height_m = 0.1; // patches of 6 cm
    for (const double share : {0.05, 0.3, 0.7}) {
        frame.foam_mean = share;
        double sum = 0, white = 0, dark = 0, pixels = 0;
        for (int look = 0; look < 24; ++look) {
            camera_ = {.x_m = 41.3 * look,
                       .y_m = -17.7 * look,
                       .z_m = 0.7,
                       .pitch_deg = -80,
                       .view_deg = 20,
                       .width = 240,
                       .height = 136};
            const Picture foam = render(frame, sky_at_hour(12), DebugView::foam);
            for (std::size_t i = 0; i < foam.rgba.size(); i += 4) {
                sum += static_cast<double>(foam.rgba[i]);
                white += foam.rgba[i] > 0.9f;
                dark += foam.rgba[i] < 0.1f;
                ++pixels;
            }
        }
        // Places are the same every time; rows scatter the mean of all looks by 6 % of s (1 - s), patches by as much.
        EXPECT_NEAR(sum / pixels, share, 0.03) << share;
        EXPECT_GT((white + dark) / pixels, 0.5) << "it is seen, not averaged";
    }
}

// At 400 m, from 10 m, a pixel is 2 m wide and 80 m long: patches of 8 m are not seen one by one, or they would flicker
// as waves go by; the pixel is as white as their share.
TEST_F(ViewsTest, foam_in_the_distance_is_its_share_where_a_pixel_is_longer_than_a_patch) {
    SeaFrame frame = flat_sea();
    frame.foam_mean = 0.3;
    frame.significant_height_m = 13; // cells of 8 m and less
    camera_ = {.z_m = 10, .pitch_deg = -2, .width = 240, .height = 136};
    const Picture foam = render(frame, sky_at_hour(12), DebugView::foam);
    const Picture place = render(frame, sky_at_hour(12), DebugView::place);
    int compared = 0;
    for (std::size_t i = 0; i < foam.rgba.size(); i += 4) {
        const double away =
            std::hypot(static_cast<double>(place.rgba[i]), static_cast<double>(place.rgba[i + 1]));
        if (away < 250 || away > 600)
            continue;
        ++compared;
        EXPECT_NEAR(foam.rgba[i], 0.3, 0.02) << away;
    }
    EXPECT_GT(compared, 100);
}

// Ripples of 6 cm that a pixel does not resolve let the Jacobian of a long wave vary by choppiness times
// their rms slope: by so much of the normal distribution lies below the threshold.
TEST_F(ViewsTest, a_crest_breaks_by_what_the_pixel_does_not_resolve) {
    sea::Realization waves = one_wave(1.2, 100, 3, 3);
    waves.choppiness = {0.8, 0.3};
    waves.cascades.push_back(one_wave(0.0014, 0.5, 8).cascades[0]);
    SyntheticSea sea(waves);
    SeaFrame frame = sea.at(0);
    const sea::Surface swell({frame.cascades[0].keyframes}, frame.choppiness, {}, {});
    frame.foam_threshold = 0.85;
    frame.foam_mean = 1e-7;            // what broke before is next to nothing
    frame.significant_height_m = 1e-3; // patches finer than pixels: the share itself is seen
    camera_.z_m = 40;
    const Sky& sky = sky_at_hour(12);
    const Picture place = render(frame, sky, DebugView::place);
    const Picture foam = render(frame, sky, DebugView::foam);
    const double k = 2 * pi / 0.5 * 8, variance = 0.5 * std::pow(0.0014 * k, 2);
    const double k_swell = 2 * pi / 100 * std::hypot(3, 3);
    const double resolved = 1 - variance / (variance + 0.5 * std::pow(1.2 * k_swell, 2));
    const double sigma = std::sqrt(0.8 * 0.8 * variance + 0.03 * 0.03);
    int half = 0;
    for (int y = 3; y < place.height; y += 7)
        for (int x = 3; x < place.width; x += 9) {
            const glm::dvec2 at = world(place.pixel(x, y));
            const double j = sea::jacobian(swell.at(at.x, at.y, 0), frame.choppiness);
            const double share = resolved * resolved * 0.5 *
                                 std::erfc((j - frame.foam_threshold) / sigma / std::sqrt(2.0));
            half += share > 0.2 && share < 0.5;
            // The logistic function is within 0.01 of the normal one; the rest is what a pixel blurs, on a GPU other pixels
            // than on a processor (0.0227 of one).
            EXPECT_NEAR(static_cast<double>(foam.pixel(x, y)[0]), share, 0.024) << j;
        }
    EXPECT_GT(half, 10);
}

// Naive: the driver is asked for what it need not have, and what it draws is anything.
TEST_F(ViewsTest, nothing_is_laid_over_a_picture_whose_format_cannot_be_blended) {
    const auto made = gpu::GraphicsPipeline::create(
        *device_, "spray", picture_vert, final_frag, {},
        {.colour_format = VK_FORMAT_R32G32B32A32_UINT, .blended = true}); // whole numbers never are
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().message, "pipeline \"spray\": " + device_->info().name +
                                        " cannot lay anything over pictures of this format");
}

TEST_F(ViewsTest, a_shader_that_reads_something_else_than_the_program_binds_is_refused) {
    using gpu::ExpectedBinding;
    constexpr VkDescriptorType image = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
    const std::vector<ExpectedBinding> fine{{"View", VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER},
                                            {"Rows", VK_DESCRIPTOR_TYPE_STORAGE_BUFFER},
                                            {"vertices", VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER},
                                            {"gradients", VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER},
                                            {"sky_map", image},
                                            {"geometry", image}};
    const auto error_with = [&](std::vector<ExpectedBinding> bindings) {
        const auto made =
            gpu::GraphicsPipeline::create(*device_, "test", picture_vert, final_frag, bindings, {});
        return made ? "none" : made.error().message;
    };
    EXPECT_EQ(error_with(fine), "none");
    std::vector<ExpectedBinding> other_type = fine, other_name = fine, fewer = fine;
    other_type[4].type = VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE;
    other_name[4].name = "moon_map";
    fewer.pop_back();
    const std::string held = "pipeline \"test\": binding 4 of set 0 is \"sky_map\" (combined image "
                             "sampler) in the shader and ";
    EXPECT_EQ(error_with(other_type), held + "\"sky_map\" (sampled image) in the program");
    EXPECT_EQ(error_with(other_name),
              held + "\"moon_map\" (combined image sampler) in the program");
    EXPECT_EQ(error_with(fewer), "pipeline \"test\": binding 5 of set 0 is \"geometry\" (combined "
                                 "image sampler) in the shader and nothing in the program");
}

} // namespace
} // namespace seaway::client
