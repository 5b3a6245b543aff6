// SPDX-License-Identifier: Apache-2.0
// A sea made on the device that draws it, against the same sea made by this processor and copied there. Validation layers
// are on.
#include <cmath>
#include <memory>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/view/renderer.h"
#include "gpu/call.h"
#include "local/local_sea.h"
#include "server/device/native_synthesizer.h"
#include "server/simulation/schedule.h"
#include "tests/gpu/held_drivers.h"
#include "tests/gpu/read_in_place.h"
#include "tests/local/local_scenes.h"

namespace seaway::local {
namespace {

using client::CascadeFrame;
using client::DebugView;
using client::Picture;
using client::SeaFrame;
using testing::HasSubstr;

constexpr sea::TimeUs time_us = 40'123'456;

server::RunningSeaPtr scene(const std::string& path = tests::small_gale()) {
    Result<server::RunningSeaPtr> sea = read_local_scene(path);
    EXPECT_TRUE(sea) << sea.error().message;
    return *sea;
}

/// The same sea by way of this processor's memory: keyframes of native maps, made splines here.
class CopiedSea {
  public:
    explicit CopiedSea(server::RunningSeaPtr sea)
        : sea_(std::move(sea)), foam_(server::steady_course(sea_)) {
        EXPECT_TRUE(device_.set_sea(sea_->realization, 1));
    }
    /// `frame` with maps of its own.
    SeaFrame like(const SeaFrame& frame) {
        SeaFrame copied = frame;
        copied.water_m = nullptr;
        for (std::size_t c = 0; c < copied.cascades.size(); ++c) {
            CascadeFrame& cascade = copied.cascades[c];
            cascade.foam_before = keyframe(c, cascade.before_us());
            cascade.foam_after = keyframe(c, cascade.after_us());
            cascade.standing.reset();
            cascade.keyframes = {std::make_shared<const sea::SplineMap>(*cascade.foam_before),
                                 std::make_shared<const sea::SplineMap>(*cascade.foam_after)};
        }
        return copied;
    }

  private:
    sea::KeyframePtr keyframe(std::size_t cascade, sea::TimeUs keyframe_us) {
        const auto made = foam_.synthesize(
            device_, {{static_cast<int>(cascade), keyframe_us, client::drawn_fields}});
        EXPECT_TRUE(made) << made.error().message;
        return made->front();
    }

    server::RunningSeaPtr sea_;
    server::NativeSynthesizer device_{2};
    server::FoamMaps foam_;
};

class LocalSeaTest : public testing::TestWithParam<bool> {
  protected:
    void SetUp() override {
        Result<std::unique_ptr<gpu::Device>> made =
            gpu::Device::create({.validation = true, .staged = GetParam()});
        ASSERT_TRUE(made) << made.error().message;
        device_ = std::move(*made);
        if (!GetParam() && !gpu::reads_in_place(*device_))
            GTEST_SKIP() << gpu::not_in_place;
        ASSERT_EQ(device_->unified_memory(), !GetParam());
    }
    void TearDown() override {
        EXPECT_THAT(device_->validation().validation_messages(), testing::IsEmpty());
    }
    std::unique_ptr<LocalSea> open(const server::RunningSeaPtr& sea) {
        Result<std::unique_ptr<LocalSea>> made = LocalSea::create(sea, device_);
        EXPECT_TRUE(made) << made.error().message;
        return std::move(*made);
    }
    static SeaFrame frame_of(LocalSea& sea, sea::TimeUs at_us) {
        Result<SeaFrame> frame = sea.at(at_us);
        EXPECT_TRUE(frame) << frame.error().message;
        return std::move(*frame);
    }
    client::Renderer renderer() {
        Result<client::Renderer> made = client::Renderer::create(
            *device_, 128, 128, {.quality = client::quality_table[client::quality_default]});
        EXPECT_TRUE(made) << made.error().message;
        return std::move(*made);
    }
    Picture draw(client::Renderer& renderer, const SeaFrame& frame,
                 const client::DebugChoice& choice = {}) {
        const client::Camera camera{
            .z_m = 14, .yaw_deg = 40, .pitch_deg = -8, .width = 128, .height = 128};
        Result<Picture> picture = renderer.render(frame, camera, sky_, choice);
        EXPECT_TRUE(picture) << picture.error().message;
        return std::move(*picture);
    }

    std::shared_ptr<gpu::Device> device_;
    static const client::Sky& afternoon() {
        static const client::Sky sky(client::sun_direction(15));
        return sky;
    }
    const client::Sky& sky_ = afternoon();
};
INSTANTIATE_TEST_SUITE_P(Memory, LocalSeaTest, testing::Bool(), [](const auto& staged) {
    return staged.param ? "that_the_cpu_cannot_see" : "in_place";
});

double largest_difference(const Picture& a, const Picture& b, std::size_t channels) {
    double largest = 0;
    for (std::size_t i = 0; i < a.rgba.size(); i += 4)
        for (std::size_t c = 0; c < channels; ++c)
            largest = std::max(largest, std::abs(static_cast<double>(a.rgba[i + c]) -
                                                 static_cast<double>(b.rgba[i + c])));
    return largest;
}

double largest_number(const Picture& a, std::size_t channels) {
    return largest_difference(a, {a.width, a.height, std::vector<float>(a.rgba.size())}, channels);
}

// Flat maps, number by number: what moves points, its gradients, foam; of each cascade.
TEST_P(LocalSeaTest, has_the_maps_that_this_processor_would_copy_there) {
    const server::RunningSeaPtr running = scene();
    const std::unique_ptr<LocalSea> sea = open(running);
    CopiedSea copied(running);
    client::Renderer drawn = renderer();
    const SeaFrame frame = frame_of(*sea, time_us);
    ASSERT_TRUE(frame.stands_there());
    const SeaFrame truth = copied.like(frame);
    struct Row {
        DebugView view;
        std::size_t channels;
        double tolerance; ///< of the largest number
    };
    // Displacements and heights are floats, of transforms that lose 3e-7 of the sum of amplitudes each: some 20 times the
    // largest value. Gradients and foam are half floats, a step of 2^-11 of a number; a step apart where they are rounded
    // the other way, and slopes are differences of neighbours.
    const Row rows[] = {{DebugView::map_displacement, 3, 2e-5},
                        {DebugView::map_slope, 2, 2e-3},
                        {DebugView::map_foam, 1, 2e-3}};
    for (int c = 0; c < 2; ++c)
        for (const Row& row : rows) {
            const client::DebugChoice choice{.view = row.view, .cascade = c};
            const Picture made = draw(drawn, frame, choice), wanted = draw(drawn, truth, choice);
            const double most = largest_number(wanted, row.channels);
            ASSERT_GT(most, 0.01) << "something is to be seen";
            EXPECT_LE(largest_difference(made, wanted, row.channels), row.tolerance * most)
                << client::info(row.view).name << " of cascade " << c;
        }
}

// What the picture needs beside maps, against the scene's file: green water, two metres of it, and a floor.
TEST_P(LocalSeaTest, lies_in_the_water_and_as_deep_as_its_scene_says) {
    const server::RunningSeaPtr running = scene(SEAWAY_SOURCE_DIR "/scenes/shallow_lagoon.toml");
    const SeaFrame frame = frame_of(*open(running), time_us);
    EXPECT_EQ(frame.depth_m, 2.0);
    EXPECT_EQ(frame.water, running->scene.water);
    EXPECT_NE(frame.water, sea::Water{}) << "else one that was never set would do";
    EXPECT_EQ(frame.reach_m, running->budget.displacement_reach_m);
    EXPECT_GT(frame.reach_m, 0);
    EXPECT_EQ(frame.choppiness.x, 1.0);
    EXPECT_EQ(frame.time_us, time_us);
}

TEST_P(LocalSeaTest, is_made_without_a_copy_out_of_the_device_or_into_it) {
    const std::unique_ptr<LocalSea> sea = open(scene());
    client::Renderer drawn = renderer();
    for (int i = 0; i < 12; ++i)
        draw(drawn, frame_of(*sea, time_us + i * sea::TimeUs{100'000}));
    const server::SynthesisCounters counters = sea->counters();
    EXPECT_GT(counters.keyframes, 8u);
    EXPECT_GT(counters.foam_ticks, 10u);
    EXPECT_EQ(counters.copies, 0u) << "keyframes that were read back";
    EXPECT_EQ(counters.readback_bytes, 0u) << "nor do strains travel that foam goes on by";
    EXPECT_EQ(drawn.copies(), 0u) << "maps that were given to the renderer";
}

// The picture of a moment is no matter of the way there.
TEST_P(LocalSeaTest, is_the_same_sea_for_who_came_from_elsewhere_in_time) {
    const server::RunningSeaPtr running = scene();
    const std::unique_ptr<LocalSea> straight = open(running), wandering = open(running);
    for (const sea::TimeUs at_us : {time_us + 9'000'000, time_us - 700'000, time_us - 100'000})
        frame_of(*wandering, at_us);
    client::Renderer first = renderer(), second = renderer();
    const SeaFrame a = frame_of(*straight, time_us), b = frame_of(*wandering, time_us);
    EXPECT_EQ(draw(first, a, {DebugView::height}).rgba, draw(second, b, {DebugView::height}).rgba);
    // Foam's histories agree to what the start of one forgets (docs/foam.md): a thousandth of the ratio.
    const client::DebugChoice foam{.view = DebugView::map_foam, .cascade = 0};
    const Picture wanted = draw(first, a, foam);
    EXPECT_LE(largest_difference(draw(second, b, foam), wanted, 1),
              2e-3 * largest_number(wanted, 1));
}

// Two frames may be under way: what they read is given back when neither is.
TEST_P(LocalSeaTest, frames_under_way_keep_their_maps) {
    const std::unique_ptr<LocalSea> sea = open(scene());
    client::Renderer drawn = renderer();
    const client::Camera camera{.z_m = 14, .pitch_deg = -8, .width = 128, .height = 128};
    std::vector<std::weak_ptr<const void>> maps;
    for (int i = 0; i < 4; ++i) { // not waited for
        const SeaFrame frame = frame_of(*sea, time_us + i * sea::TimeUs{5'000'000});
        ASSERT_TRUE(
            drawn.draw(frame, camera, sky_, {DebugView::height}, {}, client::Wanted::nothing));
        maps.push_back(frame.cascades[0].standing->before->keeper);
    }
    EXPECT_FALSE(maps[3].expired()) << "the last one";
    EXPECT_FALSE(maps[2].expired()) << "may be under way";
    EXPECT_TRUE(maps[1].expired()) << "has been waited for";
    EXPECT_TRUE(maps[0].expired());
    ASSERT_TRUE(drawn.finish());
}

// Foam is made of strains that go at once; what is left of a run between keyframes must be of use to the next. Cascades of
// one size share their memory, and those whose keyframes fall due apart let go of it apart.
TEST_P(LocalSeaTest, frames_however_far_apart_have_room_while_two_are_under_way) {
    const server::RunningSeaPtr running = scene(tests::foaming_tiles());
    const client::Camera camera{.z_m = 14, .pitch_deg = -8, .width = 128, .height = 128};
    for (const sea::TimeUs step_us : {5'000'000, 430'000}) {
        const std::unique_ptr<LocalSea> sea = open(running);
        client::Renderer drawn = renderer();
        for (int i = 0; i < 40; ++i) { // not waited for
            const Result<SeaFrame> frame = sea->at(time_us + i * step_us);
            ASSERT_TRUE(frame) << "frame " << i << ", " << step_us
                               << " us apart: " << frame.error().message;
            ASSERT_TRUE(
                drawn.draw(*frame, camera, sky_, {DebugView::height}, {}, client::Wanted::nothing));
        }
        ASSERT_TRUE(drawn.finish());
        EXPECT_GT(sea->counters().foam_ticks, 40u) << "strains were made";
    }
}

TEST_P(LocalSeaTest, more_frames_than_there_is_memory_for_are_an_error_until_some_are_let_go) {
    const std::unique_ptr<LocalSea> sea = open(scene(tests::foaming_tiles()));
    std::vector<SeaFrame> kept;
    Result<SeaFrame> frame = sea->at(0);
    for (int i = 1; frame && i < 100; ++i) {
        kept.push_back(std::move(*frame));
        frame = sea->at(i * sea::TimeUs{5'000'000});
    }
    ASSERT_FALSE(frame);
    EXPECT_TRUE(frame.error().is(server::DeviceError::out_of_memory)) << frame.error().message;
    EXPECT_THAT(frame.error().message, HasSubstr("are held"));
    EXPECT_EQ(kept.size(), 4u) << "two under way, the one that a window is about, and the next";
    kept.erase(kept.begin() + 1); // a place between others
    EXPECT_TRUE(sea->at(900'000'000));
    kept.clear();
    EXPECT_TRUE(sea->at(1'000'000'000));
}

TEST_P(LocalSeaTest, an_eye_in_a_crest_is_under_water_and_above_a_trough_is_not) {
    const std::unique_ptr<LocalSea> sea = open(scene());
    const SeaFrame frame = frame_of(*sea, time_us);
    int under = 0;
    for (int i = 0; i < 40; ++i) {
        const client::Camera camera{.x_m = 37.0 * i, .z_m = 0.5};
        const client::EyeSide eye = eye_side(frame, camera);
        const sea::QueryPoint point{camera.x_m, 0, time_us};
        sea::Answer answer;
        sea->waves()->answer({&point, 1}, {&answer, 1}, {});
        EXPECT_EQ(eye.under, camera.z_m < answer.height_m);
        under += eye.under;
    }
    EXPECT_GT(under, 4);
    EXPECT_LT(under, 36);
}

TEST_P(LocalSeaTest, every_call_that_fails_is_an_error) {
    const server::RunningSeaPtr running =
        scene(tests::calm_tiles()); // whose foam is no call of its own
    const auto sail = [&]() -> Result<void> {
        SEAWAY_TRY_LET(const std::unique_ptr<LocalSea> sea, LocalSea::create(running, device_));
        SEAWAY_TRY_LET(client::DeviceSea maps, client::DeviceSea::create(*device_, {}));
        SEAWAY_TRY_LET(const gpu::Buffer values,
                       gpu::Buffer::create(*device_, "values", sizeof(shaders::ViewValues),
                                           gpu::BufferKind::upload));
        SEAWAY_TRY_LET(const SeaFrame frame, sea->at(0));
        return maps.take(frame, values);
    };
    constexpr std::uint64_t never = ~std::uint64_t{0};
    gpu::fault::arm(never, VK_ERROR_OUT_OF_DEVICE_MEMORY);
    ASSERT_TRUE(sail()) << "the calm case";
    const std::uint64_t calls = gpu::fault::calls();
    ASSERT_GT(calls, 100u);
    std::uint64_t passed_over = 0;
    for (std::uint64_t n = 1; n <= calls; ++n) {
        gpu::fault::arm(n, VK_ERROR_OUT_OF_DEVICE_MEMORY);
        const Result<void> sailed = sail();
        if (sailed) { // without room for all maps that may be held, or a design of kernels, for which there is another
            ++passed_over;
            continue;
        }
        EXPECT_THAT(sailed.error().message, HasSubstr("VK_ERROR_OUT_OF_DEVICE_MEMORY"));
    }
    gpu::fault::disarm();
    // Of held maps: their buffer, its memory and the view of it.
    EXPECT_LT(passed_over, device_->info().is_cpu() ? 8 : calls / 2);
}

TEST(LocalScene, what_a_server_alone_can_do_is_refused_by_name) {
    const std::pair<std::string, const char*> rows[] = {
        {tests::folder().file("none.toml"), "none.toml"},
        {tests::folder().write("bad.toml", "[sea]\nchoppines = 1\n"), "choppines"},
        {tests::small_gale("weather.toml",
                           "[[weather]]\nat_s = 10\nset = { sea.choppiness = 0.5 }\n"),
         "[[weather]]"},
        {SEAWAY_SOURCE_DIR "/scenes/gerstner_toy.toml", "stylised sines"},
        {tests::folder().write("ask.toml", "[[sea.system]]\ntype = \"swell\"\nspectrum = "
                                           "\"jonswap\"\nsignificant_height_m = 1\n"
                                           "peak_period_s = 8\nfrom_deg = 0\n"
                                           "[accuracy]\npreset = \"query_only\"\n"),
         "questions alone"}};
    for (const auto& [path, what] : rows) {
        const Result<server::RunningSeaPtr> sea = read_local_scene(path);
        ASSERT_FALSE(sea) << path;
        EXPECT_THAT(sea.error().message, HasSubstr(what));
        EXPECT_THAT(sea.error().message, HasSubstr(path));
    }
}

} // namespace
} // namespace seaway::local
