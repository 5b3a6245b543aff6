// SPDX-License-Identifier: Apache-2.0
// A window on a sea that is made in its process.
#include <gmock/gmock.h>

#include "local/local_sea.h"
#include "tests/client/window/window_fixture.h"
#include "tests/local/local_scenes.h"

namespace seaway::local {
namespace {

class LocalWindow : public client::WindowTest {
  protected:
    void SetUp() override { ASSERT_TRUE(display_->is_there()) << "Xvfb did not start"; }
    void open_scene(const std::string& path, double time_s) {
        client::ViewOptions options = this->options();
        options.scene = path;
        options.time_s = time_s;
        const Result<server::RunningSeaPtr> sea = read_local_scene(options.scene);
        ASSERT_TRUE(sea) << sea.error().message;
        Result<std::unique_ptr<client::Viewer>> made =
            client::Viewer::open(options, open_in_a_window(*sea, options), true);
        ASSERT_TRUE(made) << made.error().message;
        viewer_ = std::move(*made);
        waves_ = (*sea)->truth;
        ASSERT_TRUE(step_until([&] { return viewer_->sea_frames() > 4; })) << text();
    }
    std::shared_ptr<const sea::DirectSum> waves_;
};

TEST_F(LocalWindow, runs_by_the_clock_from_the_time_that_was_asked_for_and_copies_nothing) {
    open_scene(tests::small_gale(), 500);
    EXPECT_GE(viewer_->sea_time_us(), 500'000'000);
    EXPECT_LT(viewer_->sea_time_us(), 620'000'000);
    const sea::TimeUs then_us = viewer_->sea_time_us();
    ASSERT_TRUE(step_until([&] {
        return viewer_->sea_time_us() > then_us + 1'500'000 && !viewer_->model().stale_s;
    })) << text();
    std::string said;
    for (const auto& rows :
         {viewer_->model().connection, viewer_->model().rates, viewer_->model().sea})
        for (const client::PanelRow& row : rows)
            said += row.label + ": " + row.value + "\n";
    EXPECT_THAT(said, testing::HasSubstr("scene: " + tests::small_gale()));
    EXPECT_THAT(said, testing::HasSubstr("sea shown: now"));
    EXPECT_THAT(said, testing::HasSubstr("copied out: 0 keyframes"));
    EXPECT_THAT(said, testing::HasSubstr("cascade 1: 97 m, 64 points"));
    EXPECT_FALSE(viewer_->model().spectrum.values.empty());
    EXPECT_FALSE(window_id().empty());
}

TEST_F(LocalWindow, a_click_on_the_sea_is_answered_by_its_waves) {
    open_scene(client::small_waves(), 100);
    mouse(width * 0.75, height * 0.8);
    step();
    display_->tool("click 1");
    ASSERT_TRUE(step_until([&] { return viewer_->probe() && viewer_->probe()->answer(); }));
    const client::Probe& probe = *viewer_->probe();
    const sea::DirectSum::Moment moment = waves_->at_time(probe.time_us());
    const sea::QueryPoint point{probe.place_m().x, probe.place_m().y, probe.time_us()};
    const sea::Answer truth = sea::surface_at(point, {{1, 1}, 1e-9, sea::FoldSearch{}}, moment);
    // To what the inverse leaves: waves of half a metre do not fold.
    EXPECT_NEAR(probe.answer()->height_m, truth.height_m, 1e-6);
    ASSERT_TRUE(step_until([&] { return viewer_->model().trace.values.size() > 10; }));
}

} // namespace
} // namespace seaway::local
