// SPDX-License-Identifier: Apache-2.0
// Hulls in waves, in engines' frames and out of files.
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "base/text_file.h"
#include "sea/scene/scene.h"
#include "sea/surface/inverse.h"
#include "sea/waves/realize.h"
#include "tests/client/floating.h"

namespace seaway::tests {
namespace {

/// The water of a scene by the sum of its waves.
class SummedSea {
  public:
    explicit SummedSea(const std::string& scene_text)
        : sum_(std::make_shared<const sea::Realization>(
              *sea::realize(*sea::parse_scene(scene_text, "a scene", ".")))) {}

    seaway_answer operator()(const seaway_point& at) const {
        if (!moment_ || at.time_us != time_us_)
            moment_ = sum_.at_time(time_us_ = at.time_us);
        // Without a search for other sheets: where it folds, heights may jump, which has to be borne.
        const sea::Answer found = sea::surface_at({at.x_m, at.y_m, at.time_us},
                                                  {sum_.sea().choppiness, 1e-4, {}}, *moment_);
        seaway_answer answer{found.height_m, {}, {}, found.error_m, found.flags, 0};
        for (int i = 0; i < 3; ++i) {
            answer.normal[i] = found.normal[i];
            answer.velocity_mps[i] = found.velocity_mps[i];
        }
        return answer;
    }

  private:
    sea::DirectSum sum_;
    mutable std::optional<sea::DirectSum::Moment> moment_;
    mutable sea::TimeUs time_us_ = 0;
};

/// The hurricane of scenes/ on coarser grids, whose shortest waves are of 2.4 m, half of a box's length: a sum of all of the scene's takes
/// minutes. Bands end at band_end_share_of_nyquist (sea/basics/cascade.h).
std::string coarse_hurricane() {
    std::string text = *read_text_file(SEAWAY_SOURCE_DIR "/scenes/hurricane.toml", 1 << 20);
    const auto replace = [&text](const std::string& what, const std::string& by) {
        const auto at = text.find(what);
        ASSERT_NE(at, std::string::npos) << what;
        text.replace(at, what.size(), by);
    };
    replace("size = 512", "size = 128");
    replace("size = 256", "size = 64");
    replace("length_m = 47.0\nsize = 256", "length_m = 47.0\nsize = 64");
    return text;
}

TEST(BuoyancySeas, an_hour_of_the_hurricane_leaves_a_box_finite_and_on_the_water) {
    const SummedSea sea(coarse_hurricane());
    Floating box;
    box.hull.linear_drag = 300;
    box.hull.quadratic_drag = 1;
    box.hull.added_mass[2] = 0.8;
    double farthest_m = 0;
    double highest_m = 0;
    constexpr double step_s = 0.1; // six times what an engine takes
    for (int i = 0; i < 36'000; ++i) {
        ASSERT_EQ(box.ride(sea, i * step_s, step_s), SEAWAY_OK) << i * step_s;
        const seaway_body& body = box.body;
        double squares = 0;
        for (int axis = 0; axis < 3; ++axis)
            squares += body.velocity_mps[axis] * body.velocity_mps[axis] +
                       body.angular_velocity_radps[axis] * body.angular_velocity_radps[axis];
        ASSERT_LT(squares, 40.0 * 40.0) << i * step_s; // false for NaN; crests run at 30 m/s
        const seaway_answer above = sea(
            {body.position_m[0], body.position_m[1], static_cast<int64_t>((i + 1) * step_s * 1e6)});
        farthest_m = std::max(farthest_m, std::abs(body.position_m[2] - above.height_m));
        highest_m = std::max(highest_m, std::abs(above.height_m));
    }
    EXPECT_GT(highest_m, 5); // it was a hurricane
    // It is thrown off crests and dives behind them, by its own length and no more.
    EXPECT_LT(farthest_m, 4);
}

TEST(BuoyancySeas, a_long_swell_carries_a_box_up_and_down_as_its_water) {
    // One wave of 200 m and 1 m: far below the box's own frequency, so that it follows.
    const SummedSea sea("[sea]\n[[sea.system]]\ntype = \"modes\"\nlength_m = 400\n"
                        "data = \"nx,ny,amplitude_m,phase_rad\\n2,0,1,0\\n\"\n");
    Floating box;
    box.hull.linear_drag = 300;
    double off_m = 0;
    for (int i = 0; i < 60 * 60; ++i) {
        ASSERT_EQ(box.ride(sea, i / 60.0, 1 / 60.0), SEAWAY_OK);
        if (i > 30 * 60) // the start has died away
            off_m = std::max(off_m, std::abs(box.body.position_m[2] -
                                             sea({box.body.position_m[0], box.body.position_m[1],
                                                  (i + 1) * INT64_C(1'000'000) / 60})
                                                 .height_m));
    }
    // Of an oscillator at 3.5 times lower frequency: (1/8)^2 of 1 m, twice for its drift on the slope.
    EXPECT_LT(off_m, 0.04);
}

TEST(BuoyancySeas, waves_push_along_as_an_engine_at_any_frame_rate_sees) {
    const SummedSea sea("[sea]\n[[sea.system]]\ntype = \"modes\"\nlength_m = 60\n"
                        "data = \"nx,ny,amplitude_m,phase_rad\\n2,0,0.4,0\\n2,1,0.3,1\\n\"\n");
    std::vector<double> heights_m;
    for (const int rate_hz : {30, 60, 240}) {
        Floating box;
        box.hull.linear_drag = 300;
        box.hull.quadratic_drag = 1;
        for (int i = 0; i < 20 * rate_hz; ++i)
            ASSERT_EQ(box.ride(sea, static_cast<double>(i) / rate_hz, 1.0 / rate_hz), SEAWAY_OK);
        heights_m.push_back(box.body.position_m[2]);
    }
    // What is missed goes with the step: a few millimetres of waves of 0.7 m.
    EXPECT_NEAR(heights_m[0], heights_m[2], 0.01);
    EXPECT_NEAR(heights_m[1], heights_m[2], 0.005);
}

constexpr seaway_frame frames[] = {SEAWAY_Y_UP, SEAWAY_Y_UP_LEFT, SEAWAY_Z_UP_LEFT};

TEST(EngineFrames, up_is_up_and_what_is_north_of_east_has_the_hand_of_the_engine) {
    const double axes[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const double expected[3][3][3] = {{{1, 0, 0}, {0, 0, -1}, {0, 1, 0}},
                                      {{1, 0, 0}, {0, 0, 1}, {0, 1, 0}},
                                      {{1, 0, 0}, {0, -1, 0}, {0, 0, 1}}};
    for (const seaway_frame frame : frames) {
        double in_engine[3][3];
        for (int axis = 0; axis < 3; ++axis) {
            seaway_to_engine(frame, axes[axis], in_engine[axis]);
            double back[3];
            seaway_from_engine(frame, in_engine[axis], back);
            for (int i = 0; i < 3; ++i) {
                EXPECT_EQ(in_engine[axis][i], expected[frame][axis][i]) << frame << axis << i;
                EXPECT_EQ(back[i], axes[axis][i]) << frame << axis << i;
            }
        }
        double cross[3];
        seaway_cross(in_engine[0], in_engine[1], cross);
        EXPECT_EQ(seaway_dot(cross, in_engine[2]), frame == SEAWAY_Y_UP ? 1 : -1) << frame;
    }
}

TEST(EngineFrames, to_turn_and_bring_over_is_to_bring_over_and_turn) {
    const double about[3] = {0.3, -1.2, 0.7};
    const double v[3] = {2, -5, 11};
    double q[4] = {1, 0, 0, 0};
    seaway_turn(q, about);
    for (const seaway_frame frame : frames) {
        double rows[3][3], turned[3], first[3], q_engine[4], second[3], brought[3];
        seaway_rows(q, rows);
        seaway_to_world(rows, v, turned);
        seaway_to_engine(frame, turned, first);
        seaway_turn_to_engine(frame, q, q_engine);
        seaway_rows(q_engine, rows);
        seaway_to_engine(frame, v, brought);
        seaway_to_world(rows, brought, second);
        for (int i = 0; i < 3; ++i)
            EXPECT_NEAR(first[i], second[i], 1e-13) << frame;
        double back[4];
        seaway_turn_from_engine(frame, q_engine, back);
        for (int i = 0; i < 4; ++i)
            EXPECT_EQ(back[i], q[i]) << frame;
    }
}

seaway_code read(const std::string& text, std::vector<double>& vertices_m,
                 std::vector<std::uint32_t>& triangles, size_t& line) {
    seaway_obj mesh{};
    seaway_code code = seaway_read_obj(text.data(), text.size(), &mesh);
    vertices_m.assign(3 * mesh.vertex_count, -1);
    triangles.assign(3 * mesh.triangle_count, 99);
    mesh.vertices_m = vertices_m.data();
    mesh.vertex_room = mesh.vertex_count;
    mesh.triangles = triangles.data();
    mesh.triangle_room = mesh.triangle_count;
    code = seaway_read_obj(text.data(), text.size(), &mesh);
    line = mesh.line;
    return code;
}

TEST(HullFiles, a_box_of_four_cornered_faces_is_a_box) {
    const std::string text = // as some editors begin a file
        "\xef\xbb\xbf# a box\r\no box\nv -2 -1 -.5\nv 2.0 -1 -0.5\nv 2 1 -5e-1\nv -2 +1 -0.5 1.0\n"
        "vn 0 0 1\n\nv -2 -1 500e-3\nv 2 -1 .5\nv 2 1 0.5\nv -2 1 0.5\n"
        "f 1/1/1 4/2/1 3/3/1 2/4/1\nf 5 6 7 8\r\nf 1//1 2//1 6//1 5//1\n"
        "f -6 -5 -1 -2 # the bow\nf 1/1 5/2 8/3 4/4 #\nf 2 3 7 6#";
    std::vector<double> vertices_m;
    std::vector<std::uint32_t> triangles;
    size_t line = 0;
    ASSERT_EQ(read(text, vertices_m, triangles, line), SEAWAY_OK) << line;
    Floating box;
    box.hull.vertices_m = vertices_m.data();
    box.hull.vertex_count = vertices_m.size() / 3;
    box.hull.triangles = triangles.data();
    box.hull.triangle_count = triangles.size() / 3;
    EXPECT_EQ(box.hull.triangle_count, 12u);
    ASSERT_EQ(seaway_hull_fault(&box.hull), nullptr) << seaway_hull_fault(&box.hull);
    EXPECT_NEAR(seaway_hull_volume_m3(&box.hull), 8, 1e-14);
}

TEST(HullFiles, lines_end_as_on_any_machine) {
    for (const std::string end : {"\n", "\r\n", "\r"}) {
        std::vector<double> vertices_m;
        std::vector<std::uint32_t> triangles;
        size_t line = 0;
        std::string text;
        for (const char* words : {"v 0 0 0", "v 1 0 0", "", "v 0 1 0", "f 1 2 3"})
            text += words + end;
        EXPECT_EQ(read(text, vertices_m, triangles, line), SEAWAY_OK) << line;
        EXPECT_EQ(vertices_m.size(), 9u);
        EXPECT_EQ(triangles, (std::vector<std::uint32_t>{0, 1, 2}));
        EXPECT_EQ(line, 5u);
    }
}

TEST(HullFiles, a_hull_of_a_file_without_faces_is_told_that_it_has_none) {
    std::vector<double> vertices_m;
    std::vector<std::uint32_t> triangles;
    size_t line = 0;
    ASSERT_EQ(read("v 0 0 0\nv 1 0 0\nv 0 1 0\n", vertices_m, triangles, line), SEAWAY_OK);
    Floating box;
    box.hull.vertices_m = vertices_m.data();
    box.hull.vertex_count = vertices_m.size() / 3;
    box.hull.triangles = triangles.data();
    box.hull.triangle_count = triangles.size() / 3;
    EXPECT_STREQ(seaway_hull_fault(&box.hull),
                 "it has neither triangles nor volumes and a height of columns");
    EXPECT_EQ(seaway_hull_volume_m3(&box.hull), 0);
}

TEST(HullFiles, a_line_that_makes_no_sense_is_named) {
    for (const char* wrong :
         {"v 1 2", "v 1 2 x", "v 1 2 1e999", "v 1 2 .", "f 1 2", "f 1 2 4", "f 1 2 0", "f 1 2 -4",
          "f 1 2 99999999999999999999", "f 1 2 x", "f", "v nan 1 2", "v 1.0.5 2", "v 1-2 3",
          "v 1 2 3abc", "v 1e+-5 0 0", "f 1 2 3x", "f 1-2 3"}) {
        std::vector<double> vertices_m;
        std::vector<std::uint32_t> triangles;
        size_t line = 0;
        const std::string text = std::string("v 0 0 0\nv 1 0 0\nv 0 1 0\n") + wrong + "\nf 1 2 3\n";
        EXPECT_EQ(read(text, vertices_m, triangles, line), SEAWAY_BAD_ARGUMENT) << wrong;
        EXPECT_EQ(line, 4u) << wrong;
    }
    seaway_obj none{};
    EXPECT_EQ(seaway_read_obj("", 0, &none), SEAWAY_OK);
    EXPECT_EQ(none.vertex_count, 0u);
}

TEST(HullFiles, no_more_is_written_than_there_is_room_for) {
    const std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 3 2 1\n";
    double vertices_m[6] = {7, 7, 7, 7, 7, 7};
    std::uint32_t triangles[6] = {7, 7, 7, 7, 7, 7};
    seaway_obj mesh{vertices_m, 1, 0, triangles, 1, 0, 0};
    EXPECT_EQ(seaway_read_obj(text.data(), text.size(), &mesh), SEAWAY_OK);
    EXPECT_EQ(mesh.vertex_count, 3u);
    EXPECT_EQ(mesh.triangle_count, 2u);
    EXPECT_EQ(vertices_m[2], 0);
    EXPECT_EQ(vertices_m[3], 7);
    EXPECT_EQ(triangles[2], 2u);
    EXPECT_EQ(triangles[3], 7u);
}

} // namespace
} // namespace seaway::tests
