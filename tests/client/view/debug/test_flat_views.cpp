// SPDX-License-Identifier: Apache-2.0
// Flat views: maps of the device texel by texel, tables of the sky, and the spectrum that the scene says.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "client/view/debug/debug_pictures.h"
#include "sea/waves/centred_spectrum.h"
#include "tests/client/view/renderer_fixture.h"

namespace seaway::client {
namespace {

class FlatViewsTest : public RendererTest {
  protected:
    /// As wide as the level has texels, and something beside it.
    Picture draw(const SeaFrame& frame, const char* words, int side) {
        camera_ = {.z_m = 12, .pitch_deg = 60, .width = 2 * side, .height = side}; // at the sky
        const Result<DebugChoice> choice = parse_debug_view(words);
        EXPECT_TRUE(choice) << words;
        Result<Picture> picture = renderer_for({}).render(frame, camera_, sky_at_hour(12), *choice);
        EXPECT_TRUE(picture) << picture.error().message;
        EXPECT_EQ(picture->pixel(side / 2 - 1, 0)[3], 0.0f) << "beside the map";
        EXPECT_EQ(picture->pixel(side / 2, 0)[3], 1.0f) << "its corner";
        EXPECT_EQ(picture->pixel(side / 2 + side, 0)[3], 0.0f) << "beside the map";
        return std::move(*picture);
    }
    /// Texel of a map that fills the middle of a picture, row 0 in the south.
    static glm::dvec3 texel(const Picture& picture, int column, int row) {
        const float* p = picture.pixel(picture.height / 2 + column, picture.height - 1 - row);
        return {p[0], p[1], p[2]};
    }
    static sea::Realization waves() {
        sea::Realization sea = one_wave(1.1, 90, 3, -2);
        sea.cascades.push_back(one_wave(0.3, 31, -1, 4).cascades[0]);
        sea.choppiness = {1.1, 0.5};
        return sea;
    }
};

TEST_F(FlatViewsTest, level_0_holds_what_the_sampler_says_at_each_point) {
    SyntheticSea sea(waves());
    const SeaFrame frame = sea.at(300'000);
    for (int cascade = 0; cascade < 2; ++cascade) {
        const auto index = static_cast<std::size_t>(cascade);
        const sea::Surface alone({frame.cascades[index].keyframes}, frame.choppiness, {}, {});
        const double length_m = frame.cascades[index].spec.length_m;
        const std::string of = ":" + std::to_string(cascade);
        const Picture moved = draw(frame, ("map_displacement" + of).c_str(), 64);
        const Picture slope = draw(frame, ("map_slope" + of).c_str(), 128);
        const Picture strain = draw(frame, ("map_gradient" + of).c_str(), 128);
        const Picture jacobian = draw(frame, ("map_jacobian" + of).c_str(), 128);
        for (int row = 1; row < 64; row += 9)
            for (int column = 0; column < 64; column += 7) {
                const sea::LagrangianPoint p =
                    alone.at(column * length_m / 64, row * length_m / 64, frame.time_us);
                const glm::dvec3 d = texel(moved, column, row);
                EXPECT_NEAR(d.x, p.displacement_x, 1e-5);
                EXPECT_NEAR(d.y, p.displacement_y, 1e-5);
                EXPECT_NEAR(d.z, p.height, 1e-5);
                // Two nodes a point; half floats.
                EXPECT_NEAR(texel(slope, 2 * column, 2 * row).x, p.slope_x, 3e-4);
                EXPECT_NEAR(texel(slope, 2 * column, 2 * row).y, p.slope_y, 3e-4);
                const glm::dvec3 s = texel(strain, 2 * column, 2 * row);
                EXPECT_NEAR(s.x, p.strain_xx, 3e-4);
                EXPECT_NEAR(s.y, p.strain_yy, 3e-4);
                EXPECT_NEAR(s.z, p.strain_xy, 3e-4);
                EXPECT_NEAR(texel(jacobian, 2 * column, 2 * row).x,
                            sea::jacobian(p, frame.choppiness), 1e-3);
            }
    }
}

TEST_F(FlatViewsTest, a_texel_of_level_k_is_the_mean_of_4_to_the_k_texels) {
    SyntheticSea sea(waves());
    const SeaFrame frame = sea.at(0);
    const Picture fine = draw(frame, "map_slope", 128);
    for (const int level : {1, 3, 5}) {
        const int block = 1 << level, side = 128 >> level;
        const Picture coarse =
            draw(frame, ("map_slope:mip=" + std::to_string(level)).c_str(), side);
        const Picture rough =
            draw(frame, ("map_roughness:mip=" + std::to_string(level)).c_str(), side);
        for (int row = 0; row < side; ++row)
            for (int column = 0; column < side; ++column) {
                glm::dvec3 sum(0.0), squares(0.0);
                for (int y = 0; y < block; ++y)
                    for (int x = 0; x < block; ++x) {
                        const glm::dvec3 s = texel(fine, column * block + x, row * block + y);
                        sum += s;
                        squares += s * s;
                    }
                const double count = block * block;
                const glm::dvec3 mean = sum / count, variance = squares / count - mean * mean;
                // Each level is rounded to half floats, variances to 1 %.
                EXPECT_NEAR(texel(coarse, column, row).x, mean.x, 5e-4);
                EXPECT_NEAR(texel(coarse, column, row).y, mean.y, 5e-4);
                EXPECT_NEAR(texel(rough, column, row).x, std::sqrt(variance.x + variance.y), 3e-3);
            }
    }
    const Picture moved = draw(frame, "map_displacement", 64);
    const Picture above = draw(frame, "map_displacement:mip=2", 16);
    for (int row = 0; row < 16; row += 3)
        for (int column = 0; column < 16; ++column) {
            glm::dvec3 sum(0.0);
            for (int i = 0; i < 16; ++i)
                sum += texel(moved, 4 * column + i % 4, 4 * row + i / 4);
            const glm::dvec3 mean = sum / 16.0, found = texel(above, column, row);
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(found[c], mean[c], 1e-5);
        }
}

TEST_F(FlatViewsTest, foam_is_the_share_that_the_keyframes_say) {
    SyntheticSea sea(waves());
    SeaFrame frame = sea.at(0);
    frame.foam_mean = 0.1;
    const auto foam = [&](float share) {
        auto made = std::make_shared<sea::Keyframe>();
        made->size = 64;
        made->length_m = 90;
        made->fields = {sea::Field::foam};
        made->values.resize(made->plane_size());
        for (std::size_t i = 0; i < made->plane_size(); ++i)
            made->values[i] = share * static_cast<float>(i % 64) / 32; // over its mean
        return made;
    };
    frame.cascades[0].foam_before = foam(1);
    frame.cascades[0].foam_after = foam(1);
    const Picture picture = draw(frame, "map_foam", 128);
    for (int column = 0; column < 64; column += 5)
        EXPECT_NEAR(texel(picture, 2 * column, 40).x, 0.1 * column / 32, 2e-4) << column;
}

class TablesTest : public ::testing::Test {
  protected:
    FlatTable table(const char* words, const std::string& scene = {}) {
        const Result<DebugChoice> choice = parse_debug_view(words);
        EXPECT_TRUE(choice) << words;
        Result<FlatTable> made = tables_.table(*choice, {frame_, sky_, scene});
        EXPECT_TRUE(made) << made.error().message;
        return std::move(*made);
    }
    static glm::dvec3 at(const FlatTable& table, int column, int row) {
        const float* p = &table.rgba[4 * static_cast<std::size_t>(row * table.columns + column)];
        return {p[0], p[1], p[2]};
    }
    static std::string gale() {
        const Result<sea::Scene> scene =
            sea::read_scene(SEAWAY_SOURCE_DIR "/scenes/north_sea_gale.toml");
        EXPECT_TRUE(scene);
        return sea::to_toml(*scene);
    }
    static const Sky& morning() {
        static const Sky sky(sun_direction(9), 30);
        return sky;
    }
    DebugTables tables_;
    SeaFrame frame_ = flat_sea();
    const Sky& sky_ = morning();
};

TEST_F(TablesTest, of_the_sky_hold_what_the_sky_says) {
    const FlatTable eye = table("sky_eye"), sea = table("sky_sea"),
                    blurred = table("sky_sea:mip=3");
    ASSERT_EQ(eye.columns, shaders::sky_columns);
    ASSERT_EQ(eye.rows, shaders::sky_rows);
    ASSERT_EQ(blurred.columns, shaders::sky_columns / 8);
    const Dome dome(shaders::sky_columns, shaders::sky_rows,
                    std::atan2(sky_.sun_direction().y, sky_.sun_direction().x),
                    horizon_dip_rad(SkyView::height_min_m));
    for (int column = 5; column < eye.columns; column += 37)
        for (const int row : {70, 90, 120}) {
            const glm::dvec3 direction = dome.direction(column, row);
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(at(sea, column, row)[c], sky_.radiance(direction)[c],
                            1e-3 * sky_.radiance(direction)[c]);
        }
    EXPECT_EQ(blurred.largest, sea.largest) << "one scale for all levels";
    EXPECT_LT(sea.largest, 128) << "without the sun";
    const FlatTable out = table("sky_transmittance"), again = table("sky_scattering");
    const glm::dvec3 up = sky_.air().transmittance.to_space(0, 1);
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(at(out, 0, 0)[c], up[c], 1e-5) << "straight up from the sea";
        EXPECT_NEAR(at(out, out.columns - 1, 0)[c], sky_.air().transmittance.to_space(0, 0)[c],
                    1e-4)
            << "along the horizon";
        EXPECT_NEAR(at(again, again.columns - 1, 0)[c], sky_.air().multiple.at(0, 1)[c], 1e-6);
        EXPECT_NEAR(at(again, 0, again.rows - 1)[c], sky_.air().multiple.at(1e9, -1)[c], 1e-6);
    }
}

TEST_F(TablesTest, of_the_spectrum_are_what_the_scene_is_realised_with) {
    const std::string scene = gale();
    const Result<sea::Scene> parsed = sea::parse_scene(scene, "gale", "");
    ASSERT_TRUE(parsed);
    const Result<sea::Realization> sea = sea::realize(*parsed);
    ASSERT_TRUE(sea);
    frame_.time_us = 12'340'000;
    for (const std::size_t cascade : {0u, 2u}) {
        const std::string of = ":" + std::to_string(cascade);
        const FlatTable h0 = table(("h0" + of).c_str(), scene),
                        h = table(("h" + of).c_str(), scene);
        const sea::CascadeModes& modes = sea->cascades[cascade];
        const int size = modes.spec.size, middle = h0.columns / 2;
        ASSERT_EQ(h0.columns, h0.rows);
        double largest = 0, energy = 0, all = 0;
        for (const std::complex<double>& mode : modes.h0)
            all += std::norm(mode);
        for (int y = 0; y < h0.rows; ++y)
            for (int x = 0; x < h0.columns; ++x) {
                const int nx = x - middle, ny = y - middle;
                const auto index = [&](int kx, int ky) {
                    return static_cast<std::size_t>((ky + size) % size * size + (kx + size) % size);
                };
                const std::complex<double> mode = modes.h0[index(nx, ny)];
                ASSERT_NEAR(at(h0, x, y).x, std::abs(mode), 1e-7);
                largest = std::max(largest, std::abs(mode));
                energy += std::norm(mode);
                if (std::abs(mode) > 0) {
                    ASSERT_NEAR(at(h0, x, y).y, std::arg(mode), 1e-6);
                }
                // h = h0(k) exp(-iwt) + conj(h0(-k)) exp(iwt), at the moment of the picture; of waves that both have.
                const std::complex<double> against = modes.h0[index(-nx, -ny)];
                if (std::abs(mode) > 0 && std::abs(against) > 0 && x > 0 && y > 0) {
                    const double phase = sea::omega_from_rate(modes.rate[index(nx, ny)]) * 12.34;
                    const std::complex<double> then = mode * std::polar(1.0, -phase) +
                                                      std::conj(against) * std::polar(1.0, phase);
                    ASSERT_NEAR(at(h, x, y).x, std::abs(then), 1e-6 * largest + 1e-9);
                    ASSERT_NEAR(std::abs(std::polar(at(h, x, y).x, at(h, x, y).y) - then), 0,
                                1e-5 * largest + 1e-9);
                }
                // Of a real sea: h(-k) is the conjugate of h(k).
                if (x > 0 && y > 0 && at(h, x, y).x > 0) {
                    const glm::dvec3 mirrored = at(h, 2 * middle - x, 2 * middle - y);
                    ASSERT_NEAR(at(h, x, y).x, mirrored.x, 1e-6 * mirrored.x + 1e-12);
                    ASSERT_NEAR(std::sin(at(h, x, y).y + mirrored.y), 0, 1e-5);
                }
            }
        EXPECT_NEAR(energy, all, 1e-12 * all) << "nothing lies beyond the rim";
        EXPECT_NEAR(h0.largest, largest, 1e-9);
        EXPECT_NEAR(h.largest, 2 * largest, 1e-9);
        EXPECT_THAT(h0.across, testing::HasSubstr(fmt::format(
                                   "{:.3g} rad/m", middle * modes.spec.wavenumber_step_radpm())));
    }
}

TEST_F(TablesTest, a_server_that_does_not_tell_its_scene_is_named_as_the_reason) {
    const Result<FlatTable> none = tables_.table(*parse_debug_view("h0:1"), {frame_, sky_, {}});
    ASSERT_FALSE(none);
    EXPECT_THAT(none.error().message,
                testing::HasSubstr("--debug h0:cascade=1: the server does not tell its scene"));
}

TEST_F(TablesTest, a_pixel_of_several_modes_shows_the_largest) {
    FlatTable modes{8, 8, std::vector<float>(4 * 64, 0.1f), 1, {}, {}, true};
    modes.rgba[4 * (3 * 8 + 5)] = 0.7f; // column 5, row 3 from the south
    const Picture picture = spread(modes, 6, 4);
    EXPECT_EQ(picture.pixel(1 + 2, 2)[0], 0.7f);
    EXPECT_EQ(picture.pixel(1 + 1, 2)[0], 0.1f);
    EXPECT_EQ(picture.pixel(0, 2)[3], 0.0f) << "beside it";
}

} // namespace
} // namespace seaway::client
