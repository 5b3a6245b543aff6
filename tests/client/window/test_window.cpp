// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <filesystem>

#include <gmock/gmock.h>

#include "client/view/look_file.h"
#include "gpu/call.h"
#include "sea/basics/constants.h"
#include "tests/client/window/window_fixture.h"
#include "tests/client/window/x11.h"

namespace seaway::client {
namespace {

TEST_F(WindowTest, shows_the_sea_with_its_horizon_where_geometry_says) {
    open(options());
    const tests::Screenshot seen = live_shot();
    EXPECT_GT(seen.mean(), 20) << "black";
    // Drawn at half the size, so a row of it is two; the waves' crests lift the horizon by less.
    EXPECT_NEAR(darkest_step(seen), horizon_row(viewer_->camera(), width, height), 3);
    EXPECT_TRUE(step_until([&] { return !viewer_->model().stale_s; }));
    EXPECT_TRUE(says(""));
}

TEST_F(WindowTest, is_drawn_anew_in_the_size_that_the_window_is_given) {
    open(options());
    for (const glm::ivec2 size : {glm::ivec2(1000, 700), glm::ivec2(500, 300)}) {
        display_->tool(fmt::format("windowsize {} {} {}", window_id(), size.x, size.y));
        ASSERT_TRUE(step_until([&] { return viewer_->drawn_pixels() == size; }));
        step();
        const tests::Screenshot seen = shot();
        ASSERT_EQ(seen.width, size.x);
        EXPECT_NEAR(darkest_step(seen), horizon_row(viewer_->camera(), size.x, size.y), 3);
        EXPECT_GT(seen.row(size.y - 1, 0, size.x), 5) << "the last row is drawn, too";
    }
}

TEST_F(WindowTest, a_click_on_the_sea_shows_what_the_server_says_of_that_place) {
    open(options());
    const glm::dvec2 clicked(600, 330);
    mouse(clicked.x, clicked.y);
    const auto client = Client::connect({.url = url_});
    ASSERT_TRUE(client) << client.error().message;
    // That place is below the mouse: projection knows nothing of how it was found. A click is of whole points, and its waves have moved
    // by a frame since, which on a busy machine may take a second: of a few times once is enough.
    glm::dvec2 off(HUGE_VAL);
    std::optional<glm::dvec2> before;
    for (int i = 0; i < 3 && (off.x > 2 || off.y > 2); ++i) {
        display_->tool("click 1");
        ASSERT_TRUE(step_until([&] {
            return viewer_->probe() && (!before || viewer_->probe()->place_m() != *before);
        }));
        const Probe& probe = *viewer_->probe();
        before = probe.place_m();
        ASSERT_TRUE(probe.answer());
        const sea::QueryPoint point{before->x, before->y, probe.time_us()};
        const auto exact = (*client)->ask({&point, 1}, {.exact = true});
        ASSERT_TRUE(exact) << exact.error().message;
        const sea::Answer truth = exact->front();
        EXPECT_NEAR(probe.answer()->height_m, truth.height_m,
                    probe.answer()->error_m + truth.error_m);
        EXPECT_LT(probe.answer()->error_m, 0.05);
        Camera camera = viewer_->camera();
        camera.width = width;
        camera.height = height;
        const auto mark = on_picture(camera, before->x, before->y, truth.height_m);
        ASSERT_TRUE(mark);
        const glm::dvec2 marked((mark->x + 1) / 2 * width, (mark->y + 1) / 2 * height);
        off = glm::abs(marked - clicked);
    }
    EXPECT_LE(off.x, 2);
    EXPECT_LE(off.y, 2);
    // And the panel says so, and draws its trace.
    EXPECT_TRUE(step_until([&] { return viewer_->model().trace.values.size() > 10; }));
    std::string said;
    for (const PanelRow& row : viewer_->model().probe)
        said += row.label + " " + row.value + "\n";
    EXPECT_THAT(said, testing::HasSubstr(fmt::format("height {:.3f} m, within",
                                                     viewer_->probe()->answer()->height_m)));
    EXPECT_THAT(said, testing::HasSubstr("velocity"));
    for (const char* curve : {"trace", "spectrum"}) {
        const Panels::Box box = viewer_->panels().places().at(curve);
        EXPECT_GT(box.high.x - box.low.x, 150) << curve;
        EXPECT_GT(box.high.y - box.low.y, 30) << curve;
    }
}

TEST_F(WindowTest, where_dots_are_half_as_large_window_and_panels_are_twice_as_many) {
    open(options());
    const Panels::Box hour = viewer_->panels().places().at("hour");
    viewer_.reset();
    ASSERT_TRUE(tests::set_dots_an_inch(display_->name(), 2 * 96));
    ViewOptions half = options();
    half.camera.width = 650; // the screen has 1400 columns
    half.camera.height = height;
    open(half);
    EXPECT_EQ(viewer_->pixels(), 2 * glm::ivec2(half.camera.width, half.camera.height));
    const Panels::Box twice = viewer_->panels().places().at("hour");
    // Letters are of whole dots.
    EXPECT_NEAR((twice.high.y - twice.low.y) / (hour.high.y - hour.low.y), 2, 0.1);
    EXPECT_NEAR((twice.high.x - twice.low.x) / (hour.high.x - hour.low.x), 2, 0.1);
    // And the mouse means what is below it.
    mouse(twice.low.x + 6, (twice.low.y + twice.high.y) / 2);
    step();
    display_->tool("click 1");
    EXPECT_TRUE(step_until([&] { return viewer_->choice().look.hour < 1; }));
    ASSERT_TRUE(tests::set_dots_an_inch(display_->name(), 96));
}

// Naive: the picture that nobody drew is put behind the panels.
TEST_F(WindowTest, a_level_that_no_map_has_is_said_and_nothing_is_shown) {
    ViewOptions asked = options();
    const Result<DebugChoice> level = parse_debug_view("map_slope:mip=10");
    ASSERT_TRUE(level) << level.error().message;
    asked.debug = *level;
    Result<std::unique_ptr<Viewer>> made =
        Viewer::open(asked, Viewer::streamed({.url = asked.url}, asked.limits), true);
    ASSERT_TRUE(made) << made.error().message;
    viewer_ = std::move(*made);
    const auto is_said = [&] {
        return viewer_->model().notice.find("mip 10: this map") != std::string::npos;
    };
    ASSERT_TRUE(step_until(is_said)) << text();
    step();
    EXPECT_TRUE(step_until(is_said)) << text();
    EXPECT_EQ(viewer_->sea_frames(), 0u);
}

// What a table is developed into is sampled by the window, as a frame of the sea is. The validation layer looks.
TEST_F(WindowTest, shows_tables_that_are_no_frames_of_the_sea) {
    for (const char* table : {"h0", "sky_transmittance"}) {
        ViewOptions asked = options();
        const Result<DebugChoice> view = parse_debug_view(table);
        ASSERT_TRUE(view) << view.error().message;
        asked.debug = *view;
        viewer_.reset();
        Result<std::unique_ptr<Viewer>> made =
            Viewer::open(asked, Viewer::streamed({.url = asked.url}, asked.limits), true);
        ASSERT_TRUE(made) << made.error().message;
        viewer_ = std::move(*made);
        ASSERT_TRUE(step_until([&] { return viewer_->model().shows_sea; })) << text();
        step();
        EXPECT_GT(shot().mean(), 2) << table << " is black";
        EXPECT_EQ(viewer_->device().validation().validation_message_count(), 0u) << table;
    }
}

TEST_F(WindowTest, a_click_on_a_panel_is_no_click_on_the_sea) {
    open(options());
    const Panels::Box& at = viewer_->panels().places().at("exposure");
    mouse(at.low.x + 5, (at.low.y + at.high.y) / 2);
    step();
    display_->tool("click 1");
    ASSERT_TRUE(step_until([&] { return viewer_->choice().look.exposure_stops < -1; }));
    step();
    EXPECT_FALSE(viewer_->probe());
}

TEST_F(WindowTest, the_slider_of_the_hour_makes_night) {
    open(options());
    const double noon = live_shot().mean();
    const Panels::Box at = viewer_->panels().places().at("hour");
    const double middle = (at.low.y + at.high.y) / 2;
    mouse((at.low.x + at.high.x) / 2, middle);
    step();
    display_->tool("mousedown 1");
    step();
    mouse(at.low.x + 3, middle);
    ASSERT_TRUE(step_until([&] { return viewer_->choice().look.hour < 1; }));
    display_->tool("mouseup 1");
    step(); // the next frame asks for that sky; until then that of where the drag began counts as settled
    ASSERT_TRUE(step_until([&] { return viewer_->skies().settled(); }));
    step();
    EXPECT_LT(shot().mean(), 0.7 * noon);
}

// Tables of a new sun take longer than a frame: frames go on meanwhile.
TEST_F(WindowTest, dragging_the_hour_holds_no_frame_up) {
    open(options());
    step();
    const Panels::Box at = viewer_->panels().places().at("hour");
    const double middle = (at.low.y + at.high.y) / 2;
    mouse((at.low.x + at.high.x) / 2, middle);
    step();
    display_->tool("mousedown 1");
    const int made = viewer_->skies().counts().made;
    const std::uint64_t frames = viewer_->sea_frames();
    for (double share = 0.5; share < 0.8; share += 0.05) {
        mouse(std::lerp(at.low.x, at.high.x, share), middle);
        step(2);
    }
    display_->tool("mouseup 1");
    ASSERT_TRUE(step_until([&] { return viewer_->skies().settled(); }));
    EXPECT_GT(viewer_->choice().look.hour, 14);
    EXPECT_GT(viewer_->skies().counts().made, made);
    EXPECT_GT(viewer_->skies().counts().frames_meanwhile, 0);
    EXPECT_GT(viewer_->sea_frames(), frames);
}

// A look that names a picture which is not there leaves the sky as it was, and the window says why.
TEST_F(WindowTest, says_why_a_picture_of_the_sky_is_not_shown) {
    const std::string look =
        tests::folder().write("look.toml", "[sky]\nenvironment = \"nowhere.exr\"\n");
    std::filesystem::current_path(std::filesystem::path(look).parent_path());
    open(options());
    step();
    for (const char* name :
         {"Connection", "View", "Look", "load look"}) { // the first two make room
        const Panels::Box at = viewer_->panels().places().at(name);
        mouse((at.low.x + at.high.x) / 2, (at.low.y + at.high.y) / 2);
        step();
        display_->tool("click 1");
        step();
    }
    EXPECT_TRUE(step_until([&] {
        return viewer_->model().notice.find("nowhere.exr: no such file") != std::string::npos;
    })) << viewer_->model().notice
        << viewer_->model().look_said;
    std::filesystem::current_path("/");
}

// A first sky that cannot be made ends nothing: the sea is drawn under the default look's, and the notice says why.
TEST_F(WindowTest, opens_under_the_default_sky_where_the_picture_cannot_be_read) {
    ViewOptions with = options();
    with.look.environment = "nowhere.exr";
    open(with);
    EXPECT_TRUE(step_until([&] {
        return viewer_->model().notice.find("nowhere.exr: no such file") != std::string::npos;
    })) << text();
    EXPECT_GT(viewer_->sea_frames(), 0u);
}

TEST_F(WindowTest, a_look_is_saved_and_loaded_and_what_is_wrong_with_one_is_said) {
    ViewOptions with = options();
    with.look_path = tests::folder().file("window_look.toml");
    with.camera.height = 700; // the panel lies below others
    with.look.clouds.coverage = 0.25;
    with.look.water = sea::WaterType::coastal_3;
    open(with);
    const auto click = [&](const char* what) {
        const Panels::Box at = viewer_->panels().places().at(what);
        mouse((at.low.x + at.high.x) / 2, (at.low.y + at.high.y) / 2);
        step(2);
        display_->tool("click 1");
        step(2);
    };
    click("Look");
    ASSERT_TRUE(step_until([&] { return viewer_->panels().places().contains("save look"); }));
    click("save look");
    ASSERT_TRUE(step_until([&] { return !viewer_->model().look_said.empty(); }));
    EXPECT_EQ(viewer_->model().look_said, "saved " + with.look_path);
    EXPECT_EQ(to_toml(*read_look(with.look_path)), to_toml(viewer_->choice().look));
    const double before = live_shot().mean();
    tests::folder().write("window_look.toml", "[time]\nhour = 0.5\n[water]\ntype = \"9C\"\n");
    click("load look");
    ASSERT_TRUE(step_until([&] { return viewer_->choice().look.hour == 0.5; }))
        << viewer_->model().look_said;
    EXPECT_EQ(viewer_->choice().look.water, sea::WaterType::coastal_9);
    EXPECT_EQ(viewer_->choice().look.clouds.coverage, 0) << "what a file leaves out is the default";
    step(); // the next frame asks for that sky
    ASSERT_TRUE(step_until([&] { return viewer_->skies().settled(); }));
    step(10);
    EXPECT_LT(shot().mean(), 0.8 * before) << "it is night";
    tests::folder().write("window_look.toml", "[clouds]\ncoverag = 1\n");
    click("load look");
    ASSERT_TRUE(step_until([&] {
        return viewer_->model().look_said.find("clouds.coverag: unknown key; the nearest is "
                                               "coverage") != std::string::npos;
    })) << viewer_->model().look_said;
    EXPECT_EQ(viewer_->choice().look.hour, 0.5) << "the look stays";
}

// Shown as heights, the sea has bright colours and its absence is dark.
TEST_F(WindowTest, the_mesh_of_another_camera_stays_where_it_is) {
    ViewOptions heights = options();
    heights.debug.view = DebugView::height;
    open(heights);
    const auto turn = [&] { // by 300 of 720 points: 26 degrees of 62, to the right
        mouse(700, 350);
        display_->tool("mousedown 1");
        step(2);
        mouse(550, 350);
        step(2);
        mouse(400, 350);
        step(2);
        display_->tool("mouseup 1");
        step(2);
    };
    const auto light_on_the_right = [&] {
        // Not at the bottom: there waves move points into the picture from all around the first camera.
        return live_shot().row(height - 200, width - 40, width);
    };
    EXPECT_GT(light_on_the_right(), 60);
    turn();
    EXPECT_NEAR(viewer_->camera().yaw_deg, 20 + 62 * 300.0 / 720, 0.5)
        << "what is dragged stays below the mouse";
    EXPECT_GT(light_on_the_right(), 60);
    display_->tool(fmt::format("windowfocus {}", window_id()));
    step();
    display_->tool("key m");
    ASSERT_TRUE(step_until([&] { return viewer_->choice().second_camera; }));
    EXPECT_GT(light_on_the_right(), 60);
    turn();
    EXPECT_NEAR(light_on_the_right(), 255 * (0.13 + 0.14 + 0.17) / 3, 2); // nothing
}

TEST_F(WindowTest, rides_on_a_float_as_high_as_the_sea_is) {
    open(options());
    display_->tool(fmt::format("windowfocus {}", window_id()));
    step();
    display_->tool("key 3");
    ASSERT_TRUE(step_until([&] { return viewer_->model().camera == CameraMode::follow; }));
    const auto client = Client::connect({.url = url_});
    ASSERT_TRUE(client) << client.error().message;
    step();
    for (int i = 0; i < 5; ++i) {
        step(10);
        const sea::QueryPoint point{viewer_->camera().x_m, viewer_->camera().y_m,
                                    viewer_->sea_time_us()};
        const auto answer = (*client)->ask({&point, 1}, {});
        ASSERT_TRUE(answer) << answer.error().message;
        // The float moved with the water after its height was asked: by its speed times a frame, times the slope.
        EXPECT_NEAR(viewer_->camera().z_m - Pilot::eye_m, answer->front().height_m, 0.03);
    }
}

TEST_F(WindowTest, a_server_that_goes_is_stale_and_one_that_comes_back_is_live) {
    open(options());
    const double live = live_shot().row(20, width * 6 / 10, width);
    server_->send(SIGKILL);
    server_->wait_for_exit(std::chrono::seconds(10));
    ASSERT_TRUE(step_until([&] { return viewer_->model().stale_s.value_or(0) > 0.5; })) << text();
    step();
    EXPECT_THAT(viewer_->model().notice, testing::StartsWith("stale, "));
    const double stale = shot().row(20, width * 6 / 10, width);
    EXPECT_LT(stale, 0.7 * live) << "dimmed";
    EXPECT_GT(stale, 0.2 * live) << "but there";
    const std::uint64_t drawn = viewer_->sea_frames();
    step(10);
    EXPECT_LE(viewer_->sea_frames(), drawn + 1) << "a frame that stands is not drawn again";

    start_server(url_.substr(std::string("ws://").size()));
    ASSERT_FALSE(url_.empty()) << server_->log();
    ASSERT_TRUE(step_until([&] { return !viewer_->model().stale_s; })) << text();
    EXPECT_GT(live_shot().row(20, width * 6 / 10, width), 0.8 * live);
    EXPECT_THAT(text(), testing::HasSubstr("connections: 2"));
}

TEST_F(WindowTest, a_lost_device_is_said_by_the_call_that_found_it) {
    open(options());
    gpu::fault::arm(1, VK_ERROR_DEVICE_LOST, true);
    Result<bool> stepped = true;
    for (int i = 0; i < 5 && stepped; ++i)
        stepped = viewer_->step();
    gpu::fault::disarm();
    ASSERT_FALSE(stepped);
    EXPECT_THAT(stepped.error().message, testing::HasSubstr("device lost"));
}

// Naive: only the quality's name is kept, and its own density is drawn.
TEST_F(WindowTest, the_density_that_was_asked_for_is_drawn_in_every_quality) {
    ViewOptions dense = options();
    dense.cell_pixels = 20;
    open(dense);
    EXPECT_EQ(viewer_->renderer()->options().quality, dense.as_dense(quality_table[quality_low]));
    choose_quality("default");
    step();
    EXPECT_EQ(viewer_->renderer()->options().quality,
              dense.as_dense(quality_table[quality_default]));
}

// Naive: what the device has no memory for ends the program.
TEST_F(WindowTest, a_quality_that_cannot_be_drawn_is_said_and_the_sea_goes_on_as_before) {
    open(options());
    choose_quality("default");
    gpu::fault::arm(30, VK_ERROR_OUT_OF_DEVICE_MEMORY); // of the calls that a renderer is made by
    step(1);
    gpu::fault::disarm();
    EXPECT_TRUE(says("default, 720 x 400: "));
    EXPECT_THAT(viewer_->model().notice, testing::HasSubstr("VK_ERROR_OUT_OF_DEVICE_MEMORY"));
    EXPECT_EQ(viewer_->choice().quality, quality_low);
    EXPECT_EQ(viewer_->renderer()->options().quality, quality_table[quality_low]);
    const std::uint64_t drawn = viewer_->sea_frames();
    ASSERT_TRUE(step_until([&] { return viewer_->sea_frames() > drawn + 2; }));
    choose_quality("default"); // there is memory by now
    step();
    EXPECT_EQ(viewer_->renderer()->options().quality, quality_table[quality_default]);
    EXPECT_TRUE(says(""));
}

TEST_F(WindowTest, a_size_that_cannot_be_drawn_is_said_and_not_tried_again) {
    open(options());
    const glm::ivec2 before = viewer_->drawn_pixels();
    display_->tool(fmt::format("windowsize {} {} {}", window_id(), 1000, 700));
    ASSERT_TRUE(step_until([&] {
        gpu::fault::arm(60, VK_ERROR_OUT_OF_DEVICE_MEMORY); // a frame alone has fewer calls
        return viewer_->model().notice.starts_with("low, 1000 x 700: ");
    }));
    gpu::fault::disarm();
    step(30);
    EXPECT_EQ(viewer_->drawn_pixels(), before);
    EXPECT_TRUE(says("low, 1000 x 700: "));
    display_->tool(fmt::format("windowsize {} {} {}", window_id(), 500, 300));
    ASSERT_TRUE(step_until([&] { return viewer_->drawn_pixels() == glm::ivec2(500, 300); }));
    EXPECT_TRUE(says(""));
}

TEST_F(WindowTest, opens_without_a_server_and_says_why_there_is_no_sea) {
    ViewOptions nowhere = options();
    nowhere.url = "ws://127.0.0.1:1";
    Result<std::unique_ptr<Viewer>> made =
        Viewer::open(nowhere, Viewer::streamed({.url = nowhere.url}, {}), true);
    ASSERT_TRUE(made) << made.error().message;
    viewer_ = std::move(*made);
    ASSERT_TRUE(step_until([&] {
        return viewer_->model().notice.find("no sea yet: ws://127.0.0.1:1 (") == 0;
    })) << text();
    step();
    EXPECT_THAT(text(), testing::HasSubstr("state: next attempt in"));
    EXPECT_EQ(viewer_->sea_frames(), 0u);
}

} // namespace
} // namespace seaway::client
