// SPDX-License-Identifier: Apache-2.0
// Views of the sea: each number against what the CPU knows of the place that the pixel shows.
#include <algorithm>

#include "client/view/sea/mesh.h"
#include "tests/client/view/renderer_fixture.h"

namespace seaway::client {
namespace {

class SeaViewsTest : public RendererTest {
  protected:
    SeaViewsTest() {
        camera_ = {.x_m = 311.5,
                   .y_m = -77.25,
                   .z_m = 12,
                   .yaw_deg = 130,
                   .pitch_deg = -35,
                   .width = 160,
                   .height = 90};
    }
    /// Two oblique waves of different tiles, choppier along east.
    static sea::Realization two_waves() {
        sea::Realization sea = one_wave(1.1, 90, 3, -2);
        sea.cascades.push_back(one_wave(0.3, 31, -1, 4).cascades[0]);
        sea.choppiness = {1.1, 0.5};
        return sea;
    }
    Picture draw(const SeaFrame& frame, const DebugChoice& choice) {
        Result<Picture> picture = renderer_for({}).render(frame, camera_, sky_at_hour(12), choice);
        EXPECT_TRUE(picture) << picture.error().message;
        return std::move(*picture);
    }
    Picture draw(const SeaFrame& frame, const char* words) {
        const Result<DebugChoice> choice = parse_debug_view(words);
        EXPECT_TRUE(choice) << words;
        return draw(frame, *choice);
    }
    /// Every so many pixels of sea: what(place, x, y).
    template <class What>
    int each_place(const SeaFrame& frame, const What& what) {
        const Picture places = draw(frame, "place");
        int count = 0;
        for (int y = 3; y < places.height; y += 9)
            for (int x = 3; x < places.width; x += 11) {
                const float* place = places.pixel(x, y);
                if (place[3] == 0)
                    continue;
                ++count;
                what(glm::dvec2(place[0], place[1]), x, y);
            }
        return count;
    }
    glm::dvec2 in_world(const glm::dvec2& place) const {
        return place + glm::dvec2(camera_.x_m, camera_.y_m);
    }
    static glm::dvec3 numbers(const Picture& picture, int x, int y) {
        const float* p = picture.pixel(x, y);
        return {p[0], p[1], p[2]};
    }
    static void expect_near(const glm::dvec3& found, const glm::dvec3& expected, double within,
                            const char* what) {
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(found[c], expected[c], within) << what << ", channel " << c;
    }
};

TEST_F(SeaViewsTest, displacement_is_how_far_the_surface_has_moved_there) {
    SyntheticSea sea(two_waves());
    const SeaFrame frame = sea.at(1'700'000);
    const sea::Surface all = sea.surface(frame);
    const Picture moved = draw(frame, "displacement");
    const Picture second = draw(frame, "displacement:cascade=1");
    const sea::Surface alone({frame.cascades[1].keyframes}, frame.choppiness, {}, {});
    const auto of = [&](const sea::Surface& surface, const glm::dvec2& at) {
        const sea::LagrangianPoint p = surface.at(at.x, at.y, frame.time_us);
        return glm::dvec3(frame.choppiness.x * p.displacement_x,
                          frame.choppiness.y * p.displacement_y, p.height);
    };
    int count = 0;
    each_place(frame, [&](const glm::dvec2& place, int x, int y) {
        if (glm::length(place) > 40)
            return; // there pixels are as wide as grid cells and blur them
        ++count;
        const glm::dvec2 at = in_world(place);
        // The spline itself; floats of a place 20 m away.
        expect_near(numbers(moved, x, y), of(all, at), 2e-3, "all cascades");
        expect_near(numbers(second, x, y), of(alone, at), 2e-3, "the second alone");
    });
    EXPECT_GT(count, 80);
}

TEST_F(SeaViewsTest, gradient_and_jacobian_are_those_of_the_cascades_that_were_chosen) {
    SyntheticSea sea(two_waves());
    const SeaFrame frame = sea.at(0);
    const sea::Surface all = sea.surface(frame);
    const sea::Surface first({frame.cascades[0].keyframes}, frame.choppiness, {}, {});
    const Picture gradient = draw(frame, "gradient"), of_first = draw(frame, "gradient:0");
    const Picture jacobian = draw(frame, "jacobian:0");
    const double lx = frame.choppiness.x, ly = frame.choppiness.y;
    const auto derivatives = [&](const sea::LagrangianPoint& p) {
        return glm::dvec3(lx * p.strain_xx, ly * p.strain_yy, lx * p.strain_xy);
    };
    each_place(frame, [&](const glm::dvec2& place, int x, int y) {
        const glm::dvec2 at = in_world(place);
        // What a pixel of some decimetres blurs of waves of 7 m and 25 m, on a GPU other pixels than on a processor (0.0169
        // of one).
        expect_near(numbers(gradient, x, y), derivatives(all.at(at.x, at.y, 0)), 0.018, "all");
        const sea::LagrangianPoint p = first.at(at.x, at.y, 0);
        expect_near(numbers(of_first, x, y), derivatives(p), 0.006, "the first");
        EXPECT_NEAR(numbers(jacobian, x, y).x, sea::jacobian(p, frame.choppiness), 0.008);
    });
}

TEST_F(SeaViewsTest, what_is_reflected_leaves_at_the_angle_at_which_the_ray_came) {
    SyntheticSea sea(two_waves());
    const SeaFrame frame = sea.at(0);
    const Picture normals = draw(frame, "normal"), reflected = draw(frame, "reflected");
    each_place(frame, [&](const glm::dvec2&, int x, int y) {
        const glm::dvec3 away = ray(x, y), normal = numbers(normals, x, y);
        expect_near(numbers(reflected, x, y), away - 2 * glm::dot(away, normal) * normal, 1e-4,
                    "the mirror image of the ray");
    });
}

/// Where a point of the local frame is seen, pixels.
glm::dvec2 seen_at(const Camera& camera, const glm::dvec3& local) {
    const glm::dvec4 clip = camera.clip_from_local() * glm::dvec4(local, 1);
    return {(clip.x / clip.w + 1) / 2 * camera.width, (clip.y / clip.w + 1) / 2 * camera.height};
}

TEST_F(SeaViewsTest, density_is_the_area_that_a_cell_of_the_mesh_takes_on_the_picture) {
    SyntheticSea sea(two_waves());
    const SeaFrame frame = sea.at(0);
    const sea::Surface surface = sea.surface(frame);
    const Mesh mesh = build_mesh(camera_, frame, quality_table[quality_high].cell_pixels);
    const Picture density = draw(frame, "density");
    const auto corner = [&](double r, double turn) {
        const glm::dvec2 still = mesh.apex_m + r * glm::dvec2(std::cos(turn), std::sin(turn));
        const glm::dvec2 at = in_world(still);
        const sea::LagrangianPoint p = surface.at(at.x, at.y, 0);
        return seen_at(camera_, {still.x + frame.choppiness.x * p.displacement_x,
                                 still.y + frame.choppiness.y * p.displacement_y, p.height});
    };
    double ratios = 0;
    int compared = 0;
    each_place(frame, [&](const glm::dvec2& place, int x, int y) {
        const glm::dvec2 from_apex = place - mesh.apex_m;
        const double r = glm::length(from_apex), turn = std::atan2(from_apex.y, from_apex.x);
        const auto after = std::upper_bound(mesh.rows_m.begin(), mesh.rows_m.end(), r);
        if (after == mesh.rows_m.begin() || after == mesh.rows_m.end())
            return;
        const double length_m = static_cast<double>(after[0] - after[-1]);
        // A cell around the place itself.
        const double half = 0.5 * length_m, side = 0.5 * mesh.step_rad;
        const glm::dvec2 a = corner(r - half, turn - side), b = corner(r - half, turn + side),
                         c = corner(r + half, turn + side), d = corner(r + half, turn - side);
        const auto cross = [](const glm::dvec2& u, const glm::dvec2& v) {
            return u.x * v.y - u.y * v.x;
        };
        const double area = 0.5 * std::abs(cross(c - a, d - b));
        const double found = numbers(density, x, y).x;
        EXPECT_NEAR(found / area, 1, 0.25) << "normals of a pixel against those of a cell";
        ratios += found / area;
        ++compared;
    });
    ASSERT_GT(compared, 80);
    EXPECT_NEAR(ratios / compared, 1, 0.02);
}

// From near, where cells are tens of pixels wide: bright on the edges of triangles, dark in their middles.
TEST_F(SeaViewsTest, wires_lie_on_the_edges_of_the_triangles) {
    const SeaFrame frame = flat_sea();
    camera_.z_m = 3;
    camera_.pitch_deg = -50;
    const Mesh mesh = build_mesh(camera_, frame, quality_table[quality_high].cell_pixels);
    const Picture wires = draw(frame, "wireframe"), places = draw(frame, "place"),
                  density = draw(frame, "density");
    int edges = 0, middles = 0;
    for (int y = 0; y < wires.height; ++y)
        for (int x = 0; x < wires.width; ++x) {
            const glm::dvec2 from_apex =
                glm::dvec2(places.pixel(x, y)[0], places.pixel(x, y)[1]) - mesh.apex_m;
            const double r = glm::length(from_apex);
            const auto after = std::upper_bound(mesh.rows_m.begin(), mesh.rows_m.end(), r);
            if (after == mesh.rows_m.begin() || after == mesh.rows_m.end() ||
                density.pixel(x, y)[0] < 60)
                continue;
            const double row =
                (r - static_cast<double>(after[-1])) / static_cast<double>(after[0] - after[-1]);
            const double turn = std::atan2(from_apex.y, from_apex.x) - mesh.azimuth_rad;
            const double columns = (turn - 2 * pi * std::floor(turn / (2 * pi))) / mesh.step_rad;
            const double column = columns - std::floor(columns);
            const double nearest =
                std::min({row, 1 - row, column, 1 - column, std::abs(row + column - 1)});
            const float found = wires.pixel(x, y)[0];
            if (nearest < 0.01) {
                EXPECT_GT(found, 0.5f) << x << " " << y;
                ++edges;
            } else if (std::min({row, 1 - row, column, 1 - column}) > 0.2 &&
                       std::abs(row + column - 1) > 0.3) {
                EXPECT_LT(found, 0.4f) << x << " " << y;
                ++middles;
            }
        }
    EXPECT_GT(edges, 50);
    EXPECT_GT(middles, 50);
}

TEST_F(SeaViewsTest, age_is_the_clock_less_the_keyframe_of_each_cascade_in_strips_or_of_one) {
    SyntheticSea sea(two_waves());
    const SeaFrame frame = sea.at(1'234'567);
    const auto of = [&](std::size_t cascade) {
        const sea::SplinePair& pair = frame.cascades[cascade].keyframes;
        return 1e-3 * glm::dvec3(frame.time_us - pair.before->time_us(),
                                 pair.after->time_us() - frame.time_us,
                                 pair.after->time_us() - pair.before->time_us());
    };
    ASSERT_NE(of(0), of(1));
    const Picture strips = draw(frame, "age"), second = draw(frame, "age:1");
    each_place(frame, [&](const glm::dvec2&, int x, int y) {
        expect_near(numbers(strips, x, y), of(x < 80 ? 0 : 1), 1e-3, "strips");
        expect_near(numbers(second, x, y), of(1), 1e-3, "the second");
    });
    EXPECT_NEAR(largest_number(frame, *parse_debug_view("age")), std::max(of(0).z, of(1).z), 1e-9);
}

TEST_F(SeaViewsTest, bound_is_what_an_answer_there_states) {
    SyntheticSea sea(two_waves());
    // Naive: what maps were sent without is left out, and coding is taken for what it is on the maps' own grids.
    for (const bool compact : {false, true}) {
        const sea::TimeUs time_us = compact ? 400'000 : 1'234'567;
        SeaFrame frame = sea.at(time_us);
        for (sea::CascadeLoss& loss :
             frame.error.cascades) { // so that it hangs on the place in a cell
            loss.height.east_m = 0.004;
            loss.height.north_m = 0.007;
            for (sea::MapLoss* of : {&loss.height, &loss.displacement})
                if (compact) {
                    of->cut_m = 0.006;
                    of->value_m = 0.02;
                    of->coded_relief = 0;
                }
        }
        const sea::Surface surface({frame.cascades[0].keyframes, frame.cascades[1].keyframes},
                                   frame.choppiness, sea.surface(frame).folds(), frame.error);
        const Picture bound = draw(frame, "bound");
        double least = 1e9, most = 0;
        each_place(frame, [&](const glm::dvec2& place, int x, int y) {
            const glm::dvec2 at = in_world(place);
            const sea::LagrangianPoint p = surface.at(at.x, at.y, time_us);
            const sea::Answer answer =
                surface.answer({at.x + frame.choppiness.x * p.displacement_x,
                                at.y + frame.choppiness.y * p.displacement_y, time_us});
            const double found = numbers(bound, x, y).x;
            EXPECT_EQ(bound.pixel(x, y)[3], 1.0f) << "nothing folds";
            // The slope that is seen is blurred by some percent, which counts where much moves sideways; an answer's
            // inverse leaves micrometres.
            EXPECT_NEAR(found, answer.error_m, 0.03 * answer.error_m);
            least = std::min(least, found);
            most = std::max(most, found);
        });
        EXPECT_GT(most, 1.05 * least) << "it hangs on the place";
        EXPECT_LT(most, 1.01 * largest_number(frame, *parse_debug_view("bound")));
    }
}

TEST_F(SeaViewsTest, a_surface_that_folds_is_flagged_and_one_that_does_not_is_not) {
    sea::Realization steep = one_wave(1.1, 90, 4);
    steep.choppiness = {4.0, 0}; // amplitude times wavenumber is 0.31: J is as low as -0.2
    SyntheticSea sea(std::move(steep));
    const SeaFrame frame = sea.at(0);
    const sea::Surface surface = sea.surface(frame);
    const Picture bound = draw(frame, "bound"), jacobian = draw(frame, "jacobian");
    int folded = 0, fine = 0;
    each_place(frame, [&](const glm::dvec2&, int x, int y) {
        const double j = numbers(jacobian, x, y).x;
        if (j < -0.01) {
            EXPECT_EQ(bound.pixel(x, y)[3], 2.0f) << j;
            ++folded;
        } else if (j > 0.1) { // more than maps may be wrong by
            EXPECT_EQ(bound.pixel(x, y)[3], 1.0f) << j;
            ++fine;
        }
    });
    EXPECT_GT(folded, 0);
    EXPECT_GT(fine, 20);
}

TEST_F(SeaViewsTest, the_sky_has_no_number_of_the_sea) {
    SyntheticSea sea(two_waves());
    const SeaFrame frame = sea.at(0);
    camera_.pitch_deg = 20;
    camera_.view_deg = 80;
    for (const DebugViewInfo& row : debug_view_table()) {
        if (row.source != DebugSource::sea)
            continue;
        const Picture picture = draw(frame, DebugChoice{.view = row.view});
        EXPECT_EQ(picture.pixel(80, 0)[3], 0.0f) << row.name;
        EXPECT_GE(picture.pixel(80, 88)[3], 1.0f) << row.name;
    }
}

} // namespace
} // namespace seaway::client
