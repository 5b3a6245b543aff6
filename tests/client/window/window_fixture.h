// SPDX-License-Identifier: Apache-2.0
// A window on a display without a screen, on the sea of a real server. Validation layers are on; one message of theirs
// fails the test.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "client/window/viewer.h"
#include "tests/client/window/display.h"
#include "tests/support/folder.h"
#include "tests/support/free_port.h"
#include "tests/support/server_process.h"

namespace seaway::client {

/// Waves of half a metre, cheap to compute.
inline std::string small_waves() {
    return tests::folder().write("small_waves.toml", R"([sea]
seed = 7
choppiness = 1.0
[[sea.system]]
type = "swell"
spectrum = "jonswap"
significant_height_m = 0.5
peak_period_s = 5.0
from_deg = 300
spreading = "cos2s"
spreading_exponent = 10
[[cascade]]
length_m = 211.0
size = 64
[[cascade]]
length_m = 31.0
size = 64
[accuracy]
height_error_m = 0.01
)");
}

class WindowTest : public testing::Test {
  protected:
    static constexpr int width = 720, height = 400;

    static void SetUpTestSuite() { display_ = std::make_unique<tests::Display>(); }
    static void TearDownTestSuite() { display_.reset(); }

    void SetUp() override {
        ASSERT_TRUE(display_->is_there()) << "Xvfb did not start";
        // Which nobody is given while it is down.
        start_server(fmt::format("127.0.0.1:{}", tests::free_port()));
        ASSERT_FALSE(url_.empty()) << server_->log();
    }
    void TearDown() override {
        if (!viewer_)
            return;
        EXPECT_EQ(viewer_->device().validation().validation_message_count(), 0u);
        for (const std::string& message : viewer_->device().validation().validation_messages())
            ADD_FAILURE() << message;
    }

    void start_server(const std::string& address) {
        server_ = std::make_unique<tests::ServerProcess>(
            std::vector<std::string>{small_waves(), "--listen", address});
        url_ = server_->wait_until_ready();
    }

    ViewOptions options() const {
        ViewOptions made;
        made.url = url_;
        // Away from the sun, from so high that waves do not lift the horizon.
        made.camera = {.z_m = 30, .yaw_deg = 20, .pitch_deg = -6, .width = width, .height = height};
        made.look.hour = 12;
        made.quality = quality_table[quality_low];
        return made;
    }
    void open(const ViewOptions& with) {
        Result<std::unique_ptr<Viewer>> made =
            Viewer::open(with, Viewer::streamed({.url = with.url}, with.limits), true);
        ASSERT_TRUE(made) << made.error().message;
        viewer_ = std::move(*made);
        ASSERT_TRUE(step_until([&] { return viewer_->sea_frames() > 2; })) << text();
    }

    /// Frames until the condition holds; false after a minute, which a busy machine does not need either.
    template <class Condition>
    bool step_until(const Condition& condition) {
        const auto deadline = std::chrono::steady_clock::now() + std::chrono::minutes(1);
        while (!condition()) {
            const Result<bool> open = viewer_->step();
            if (!open) {
                ADD_FAILURE() << open.error().message;
                return false;
            }
            if (!*open || std::chrono::steady_clock::now() > deadline)
                return false;
        }
        return true;
    }
    /// So that what was drawn is on the screen.
    void step(int frames = 4) {
        int n = 0;
        EXPECT_TRUE(step_until([&] { return n++ == frames; }));
    }

    /// The notice begins so, or, of nothing, there is none; on a busy machine a stale sea may be said meanwhile.
    bool says(std::string_view words) {
        return step_until([&] {
            const std::string& notice = viewer_->model().notice;
            return words.empty() ? notice.empty() : notice.starts_with(words);
        });
    }

    std::string text() const {
        std::string all = viewer_->model().notice + "\n";
        for (const auto& rows : {viewer_->model().connection, viewer_->model().sea})
            for (const PanelRow& row : rows)
                all += row.label + ": " + row.value + "\n";
        return all;
    }
    tests::Screenshot shot() const {
        return display_->shot(viewer_->pixels().x, viewer_->pixels().y);
    }
    /// Of a sea of now: on a busy machine it may be stale meanwhile, and is dimmed.
    tests::Screenshot live_shot() {
        int frames = 0;
        EXPECT_TRUE(step_until([&] {
            frames = viewer_->model().stale_s ? 0 : frames + 1;
            return frames > 4; // what was drawn is on the screen
        })) << text();
        return shot();
    }
    void mouse(double x, double y) const {
        display_->tool(fmt::format("mousemove {:.0f} {:.0f}", x, y));
    }
    /// By the panel's list; the next frame is to be drawn by it.
    void choose_quality(const std::string& name) {
        for (const std::string& click : {std::string("quality"), name}) {
            ASSERT_TRUE(step_until([&] { return viewer_->panels().places().contains(click); }));
            step(); // a list has its place from its second frame on
            const Panels::Box at = viewer_->panels().places().at(click);
            mouse(at.low.x + 5, (at.low.y + at.high.y) / 2);
            step(2);
            display_->tool("click 1");
        }
        ASSERT_TRUE(
            step_until([&] { return quality_table[viewer_->choice().quality].name == name; }));
    }
    std::string window_id() const {
        std::string id = display_->tool("search --name Seaway");
        return id.substr(0, id.find('\n'));
    }
    /// Columns that no panel covers.
    static int free_from(const tests::Screenshot& seen) { return seen.width * 6 / 10; }

    /// The row where light falls most from row to row.
    static int darkest_step(const tests::Screenshot& seen) {
        int best = 1;
        double most = 0;
        for (int y = 1; y + 2 < seen.height; ++y) {
            const double fall = seen.row(y - 1, free_from(seen), seen.width) -
                                seen.row(y + 1, free_from(seen), seen.width);
            if (fall > most) {
                most = fall;
                best = y;
            }
        }
        return best;
    }
    /// Where geometry says that the horizon is.
    static double horizon_row(const Camera& camera, int columns, int rows) {
        const double below = horizon_dip_rad(camera.z_m) + camera.pitch_deg * sea::pi / 180;
        const double half = std::tan(camera.view_deg * sea::pi / 360) * rows / columns;
        return rows / 2.0 * (1 + std::tan(below) / half);
    }

    static inline std::unique_ptr<tests::Display> display_;
    std::unique_ptr<tests::ServerProcess> server_;
    std::string url_;
    std::unique_ptr<Viewer> viewer_;
};

} // namespace seaway::client
