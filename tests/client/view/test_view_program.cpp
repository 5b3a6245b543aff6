// SPDX-License-Identifier: Apache-2.0
// seaway-view as its users run it, against the real net server over a sea of known waves.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>

#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/client.h"
#include "client/view/renderer.h"
#include "client/view/sea/sea_source.h"
#include "client/view/sky/sky.h"
#include "tests/client/wave_server.h"
#include "tests/support/folder.h"
#include "tests/support/program.h"
#include "tests/support/read_file.h"

namespace seaway::client {
namespace {

using tests::Output;

Output run(const std::string& arguments) {
    return tests::run_program("seaway-view", arguments);
}

Picture read_exr(const std::string& path, int width, int height) {
    const auto texels = static_cast<std::size_t>(width * height);
    Picture picture{width, height, std::vector<float>(4 * texels, 1.0f)};
    Imf::InputFile file(path.c_str());
    Imf::FrameBuffer buffer;
    for (std::size_t c = 0; c < 3; ++c)
        buffer.insert(std::string("RGB").substr(c, 1).c_str(),
                      Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(picture.rgba.data() + c),
                                 4 * sizeof(float),
                                 4 * sizeof(float) * static_cast<std::size_t>(width)));
    file.setFrameBuffer(buffer);
    file.readPixels(0, height - 1);
    return picture;
}

TEST(ViewProgram, lists_its_debug_views) {
    const Output outcome = run("--list-debug");
    EXPECT_EQ(outcome.status, 0);
    for (const char* name : {"final", "height", "normal", "jacobian", "foam", "cascade"})
        EXPECT_THAT(outcome.said(), testing::HasSubstr(name));
}

TEST(ViewProgram, a_full_disk_behind_standard_output_is_an_error) {
    EXPECT_EQ(run("--list-debug >/dev/full").status, 1);
    EXPECT_EQ(run("--help >/dev/full").status, 1);
}

TEST(ViewProgram, says_in_one_line_what_is_wrong_with_a_command_line) {
    const std::string fine = "ws://127.0.0.1:1 --offscreen 64x48 --out /tmp/x.png ";
    const std::pair<std::string, const char*> rows[] = {
        {"ws://127.0.0.1:1 --out x.png", "--offscreen"},
        {"ws://127.0.0.1:1 --frames 3", "--frames is of pictures in files"},
        {"ws://127.0.0.1:1 --time 12", "--time is of pictures in files"},
        {"ws://127.0.0.1:1 --bench 3", "--bench is of pictures in files"},
        {fine + "--bench 3", "--out and --bench"},
        {"ws://127.0.0.1:1 --offscreen 64x48 --bench 3 --frames 2", "--frames and --bench"},
        {"ws://127.0.0.1:1 --offscreen 64x48 --bench 3 --path way.csv", "--path and --bench"},
        {"ws://127.0.0.1:1 --offscreen 64x48 --bench 3 --turntable", "--turntable and --bench"},
        {"ws://127.0.0.1:1 --window 8x8", "--window 8x8"},
        {fine + "--window 640x480", "--offscreen and --window"},
        {"ws://127.0.0.1:1 --offscreen 64x --out x.png", "64x"},
        {"ws://127.0.0.1:1 --offscreen 64x48 --out x.jpg", "x.jpg"},
        {fine + "--camera 1,2,3", "1,2,3"},
        {fine + "--path /nonexistent.csv", "/nonexistent.csv"},
        {"ws://127.0.0.1:1 --turntable", "--turntable is of pictures in files"},
        {fine + "--camera 1,2,-51,0,0", "Z"},
        {fine + "--debug nothing", "nothing"},
        {fine + "--time-of-day 25", "25"},
        {fine + "--time 1e13", "between -1e+12 and 1e+12"},
        {fine + "--time 1e12 --frames 60", "--frames 60"},
        {fine + "--timeout nan", "--timeout"},
        {fine + "--token-file ''", "--token-file"},
        {fine + "--debug \"$(printf '\\033[31m')\"", "\\x1b[31m"},
        {"http://127.0.0.1:1 --offscreen 64x48 --out x.png", "http"},
    };
    for (const auto& [arguments, what] : rows) {
        const Output outcome = run(arguments);
        EXPECT_EQ(outcome.status, 2) << arguments;
        EXPECT_EQ(outcome.out, "");
        EXPECT_EQ(outcome.error_lines(), 1) << outcome.err;
        EXPECT_THAT(outcome.err, testing::HasSubstr(what));
    }
}

TEST(ViewProgram, says_when_there_is_no_server) {
    const Output outcome = run("ws://127.0.0.1:1 --offscreen 64x48 --out /tmp/x.png");
    EXPECT_EQ(outcome.status, 5);
    EXPECT_EQ(outcome.out, "");
    EXPECT_EQ(outcome.error_lines(), 1) << outcome.err;
}

TEST(ViewProgram, an_exr_has_the_size_that_was_asked_for_in_every_quality) {
    tests::WaveSea sea;
    const auto net = tests::serve(sea);
    ASSERT_TRUE(net);
    for (const char* quality : {"low", "default"}) {
        const std::string path = tests::folder().file(std::string(quality) + ".exr");
        const Output outcome = run(net->url() + " --offscreen 96x64 --time 1000.5 --quality " +
                                   quality + " --out " + path);
        ASSERT_EQ(outcome.status, 0) << outcome.said();
        EXPECT_EQ(read_exr(path, 96, 64).rgba.size(), 4u * 96 * 64);
    }
}

TEST(ViewProgram, draws_frames_from_streamed_tiles_at_the_height_of_the_true_sea) {
    tests::WaveSea sea;
    const auto net = tests::serve(sea);
    ASSERT_TRUE(net);
    const std::filesystem::path folder = tests::folder().file("frames");
    const Output outcome =
        run(net->url() + " --offscreen 96x64 --frames 2 --time 1000.5 --debug place" +
            " --camera 300,-200,8,70,-35 --out " + folder.string() + "/##.exr");
    ASSERT_EQ(outcome.status, 0) << outcome.said();
    for (int frame = 0; frame < 2; ++frame) {
        const Picture places =
            read_exr((folder / ("0" + std::to_string(frame) + ".exr")).string(), 96, 64);
        const sea::TimeUs time_us = 1'000'500'000 + frame * 1'000'000 / 30;
        const sea::DirectSum sum(tests::few_waves());
        const sea::DirectSum::Moment moment = sum.at_time(time_us);
        for (std::size_t i = 96 * 20; i < 96 * 64; i += 97) {
            const double x = 300 + static_cast<double>(places.rgba[4 * i]);
            const double y = -200 + static_cast<double>(places.rgba[4 * i + 1]);
            // Codec 0.5 mm a cascade, its rates, interpolation, flat triangles: together below 1
            // cm.
            EXPECT_NEAR(static_cast<double>(places.rgba[4 * i + 2]), moment.at(x, y).height, 0.01)
                << "frame " << frame << " pixel " << i;
        }
    }
}

/// Numbers to a PNG, by the same last pass: of pictures of one size.
class Developer {
  public:
    Developer(int width, int height)
        : renderer_(Renderer::create(*device_, width, height).value()) {}
    bool develop(const Picture& picture, const Display& display, const std::string& path) {
        const Result<ShownPicture> shown = renderer_.develop(picture, display);
        return shown && write_png(*shown, path);
    }

  private:
    const std::unique_ptr<gpu::Device> device_ = gpu::Device::create({}).value();
    Renderer renderer_;
};

// A film does not flicker: what the first frame was metered at serves all, however another is lit.
TEST(ViewProgram, a_film_is_exposed_as_its_first_frame) {
    tests::WaveSea sea;
    const auto net = tests::serve(sea);
    ASSERT_TRUE(net);
    const std::filesystem::path folder = tests::folder().file("film");
    const std::string film = net->url() + " --offscreen 64x48 --frames 4 --time 1000.5" +
                             " --time-of-day 16.5 --camera 30,-20,2,70,-15 --out " +
                             folder.string();
    ASSERT_EQ(run(film + "/##.exr").status, 0);
    ASSERT_EQ(run(film + "/##.png").status, 0);
    const double white = Sky(sun_direction(16.5)).white_radiance();
    Developer developer(64, 48);
    double first = 0;
    for (int frame = 0; frame < 4; ++frame) {
        const std::string name = (folder / ("0" + std::to_string(frame))).string();
        const Picture radiance = read_exr(name + ".exr", 64, 48);
        const double own = metered_exposure(radiance, white);
        first = frame == 0 ? own : first;
        const auto expected = [&](double exposure) {
            const std::string path = tests::folder().file("expected.png");
            EXPECT_TRUE(developer.develop(radiance, {DebugView::final, exposure, 1}, path));
            return tests::read_file(path);
        };
        EXPECT_EQ(tests::read_file(name + ".png") == expected(first), true) << frame;
        EXPECT_NE(frame == 3 && expected(first) == expected(own), true)
            << "else this test sees nothing";
    }
}

/// ms, as a bench says them.
struct Benched {
    double passes = 0; ///< together
    double frame = 0;
};
Benched benched(const std::string& said) {
    Benched found;
    std::istringstream lines(said);
    for (std::string line; std::getline(lines, line);) {
        std::istringstream words(line);
        std::string name;
        double ms = 0;
        words >> name >> ms;
        for (const std::string_view pass : Renderer::pass_names)
            if (name == pass)
                found.passes += ms;
        if (name == "frame")
            found.frame = ms;
    }
    return found;
}

// What a frame costs, pass by pass, by the device's own clock: together no more than the frame took.
TEST(ViewProgram, a_bench_says_what_each_pass_takes) {
    tests::WaveSea sea;
    const auto net = tests::serve(sea);
    ASSERT_TRUE(net);
    Output outcome{};
    Benched ms;
    // On a processor drawing is nearly all of a frame; what else is there is little on a GPU, too, but that may be idle in between. One
    // frame that was held up makes the mean of five by far the longest, so of a few times once is enough.
    for (int i = 0; i < 3 && ms.passes <= 0.02 * ms.frame; ++i) {
        outcome =
            run(net->url() + " --offscreen 320x180 --time 1000.5 --quality default --bench 5");
        ASSERT_EQ(outcome.status, 0) << outcome.said();
        ms = benched(outcome.said());
    }
    EXPECT_GT(ms.passes, 0.02 * ms.frame);
    EXPECT_LT(ms.passes, 2 * ms.frame) << "medians of passes against the mean of frames";
    EXPECT_THAT(outcome.said(), testing::HasSubstr("frames/s"));
    for (const std::string_view pass : Renderer::pass_names)
        EXPECT_THAT(outcome.said(), testing::HasSubstr(std::string(pass))) << pass;
}

// The camera goes where the file says, frame by frame: below it lies the place that it names.
TEST(ViewProgram, a_path_moves_the_camera_from_frame_to_frame) {
    tests::WaveSea sea;
    const auto net = tests::serve(sea);
    ASSERT_TRUE(net);
    const std::string file = tests::folder().file("path.csv");
    std::ofstream(file)
        << "t_s,x_m,y_m,z_m,yaw_deg,pitch_deg\n0,0,0,40,0,-89\n0.0333333,0,0,80,0,-89\n";
    const std::string out = tests::folder().file("path");
    const Output drawn =
        run(net->url() + " --offscreen 64x48 --frames 2 --time 1000.5 --debug place --path " +
            file + " --out " + out + "/##.exr");
    ASSERT_EQ(drawn.status, 0) << drawn.said();
    const auto width_m = [&](const char* name) {
        const Picture place = read_exr(out + name, 64, 48);
        return static_cast<double>(place.pixel(63, 24)[0] - place.pixel(0, 24)[0]);
    };
    // Twice as high, twice as much of the sea; waves of a metre move what is seen by so much.
    EXPECT_NEAR(width_m("/01.exr") / width_m("/00.exr"), 2, 0.1);
}

// Heights are shown on the scale of the sea that is seen.
TEST(ViewProgram, a_picture_of_heights_has_the_scale_of_its_sea) {
    tests::WaveSea sea;
    const auto net = tests::serve(sea);
    ASSERT_TRUE(net);
    const std::string path = tests::folder().file("heights");
    const std::string one = net->url() + " --offscreen 64x48 --time 1000.5 --debug height" +
                            " --camera 30,-20,9,70,-30 --out " + path;
    ASSERT_EQ(run(one + ".exr").status, 0);
    ASSERT_EQ(run(one + ".png").status, 0);
    const auto client = Client::connect({.url = net->url()});
    ASSERT_TRUE(client) << client.error().message;
    const Result<SeaFrame> frame = sea_frame_at(**client, 1'000'500'000, 10);
    ASSERT_TRUE(frame) << frame.error().message;
    const double hs_m = frame->significant_height_m;
    EXPECT_NEAR(hs_m, 4 * std::sqrt(0.5 * (0.64 + 0.09 + 0.0016 + 0.0009)), 0.02);
    const std::string expected = tests::folder().file("expected_heights.png");
    ASSERT_TRUE(Developer(64, 48).develop(read_exr(path + ".exr", 64, 48),
                                          {DebugView::height, 1, hs_m}, expected));
    EXPECT_EQ(tests::read_file(path + ".png") == tests::read_file(expected), true);
}

// Half of a level picture is sky, which has no height: 0 there is no number.
TEST(ViewProgram, an_exr_of_heights_says_that_the_sky_has_none) {
    tests::WaveSea sea;
    const auto net = tests::serve(sea);
    ASSERT_TRUE(net);
    const std::string path = tests::folder().file("level.exr");
    const Output drawn =
        run(net->url() + " --offscreen 64x48 --time 1000.5 --camera 30,-20,9,70,0 --out " + path +
            " --debug height");
    ASSERT_EQ(drawn.status, 0) << drawn.said();
    EXPECT_EQ(drawn.said().find("--exposure"), std::string::npos)
        << "of light alone: " << drawn.said();
    std::vector<float> alpha(64 * 48);
    Imf::InputFile file(path.c_str());
    Imf::FrameBuffer buffer;
    buffer.insert("A", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(alpha.data()), sizeof(float),
                                  64 * sizeof(float)));
    file.setFrameBuffer(buffer);
    file.readPixels(0, 47);
    for (std::size_t x = 0; x < 64; ++x) {
        EXPECT_EQ(alpha[x], 0.0f) << x;
        EXPECT_EQ(alpha[64 * 47 + x], 1.0f) << x;
    }
    const auto* time = file.header().findTypedAttribute<Imf::StringAttribute>("seaway.time_us");
    ASSERT_NE(time, nullptr);
    EXPECT_EQ(time->value(), "1000500000");
    const auto* view = file.header().findTypedAttribute<Imf::StringAttribute>("seaway.debug");
    ASSERT_NE(view, nullptr);
    EXPECT_EQ(view->value(), "height");
}

/// The same waves with foam, all of it as many times the mean as its keyframe is seconds old, and a tenth
/// of its cascade; and a sea state in which no two figures are equal.
class FoamySea : public tests::WaveSea {
  public:
    FoamySea() { offered = drawn_fields; }
    std::vector<server::SharedBytes> sea_state_messages() const override {
        protocol::MessageReader reader(protocol::Sender::server);
        const auto first = WaveSea::sea_state_messages().front();
        protocol::SeaStateValues state =
            protocol::values(*reader.read(*first).value()->body_as_SeaState());
        state.choppiness_x = 0.9;
        state.choppiness_y = 1.1;
        state.foam_mean = 0.03;
        state.foam_threshold = 0.55;
        state.depth_m = 7.5;
        state.water = {sea::WaterType::coastal_5, {0.125, 0.25, 0.5}};
        state.cascades[0].k_lo_radpm = 0.01;
        return {std::make_shared<const protocol::Bytes>(protocol::sea_state(state))};
    }
    static float ratio(const sea::Keyframe& keyframe) {
        return static_cast<float>(sea::seconds_from_us(keyframe.time_us)) +
               0.1f * static_cast<float>(keyframe.cascade);
    }
    void fetch(server::FetchRequest request, Fetched done) override {
        const sea::FieldSet wanted = request.demand.fields;
        request.demand.fields = wanted & sea::surface_fields;
        WaveSea::fetch(std::move(request), [&](Result<server::FetchedPart> made) {
            std::vector<server::KeyframeTiles> out;
            for (const server::KeyframeTiles& tiles : made->tiles) {
                auto own = std::make_shared<sea::Keyframe>(*tiles.keyframe);
                std::vector<float> errors = tiles.codec_error;
                if (wanted.contains(sea::Field::foam)) { // the last of all fields
                    own->fields |= sea::FieldSet{sea::Field::foam};
                    own->values.insert(own->values.end(), own->plane_size(), ratio(*own));
                    errors.push_back(0.001f);
                }
                out.push_back({own, errors, tiles.quality});
            }
            done(server::FetchedPart{std::move(out)});
        });
    }
};

TEST(SeaSource, a_frame_has_every_figure_of_its_sea_and_the_foam_of_both_keyframes) {
    FoamySea sea;
    const auto net = tests::serve(sea);
    ASSERT_TRUE(net);
    const auto client = Client::connect({.url = net->url()});
    ASSERT_TRUE(client) << client.error().message;
    const sea::TimeUs time_us = 3'130'000;
    const Result<SeaFrame> frame = sea_frame_at(**client, time_us, 10);
    ASSERT_TRUE(frame) << frame.error().message;
    EXPECT_EQ(frame->time_us, time_us);
    EXPECT_EQ(frame->choppiness.x, 0.9);
    EXPECT_EQ(frame->choppiness.y, 1.1);
    EXPECT_EQ(frame->foam_mean, 0.03);
    EXPECT_EQ(frame->foam_threshold, 0.55);
    EXPECT_EQ(frame->depth_m, 7.5);
    EXPECT_EQ(frame->water, (sea::Water{sea::WaterType::coastal_5, {0.125, 0.25, 0.5}}));
    EXPECT_EQ(frame->significant_height_m, 2.42);
    const sea::TimeUs before_us[] = {3'000'000, 3'100'000}, after_us[] = {3'200'000, 3'200'000};
    const double length_m[] = {160, 29};
    ASSERT_EQ(frame->cascades.size(), 2u);
    for (std::size_t c = 0; c < 2; ++c) {
        const CascadeFrame& cascade = frame->cascades[c];
        EXPECT_EQ(cascade.spec.length_m, length_m[c]);
        EXPECT_EQ(cascade.spec.size, tests::wave_map_size);
        EXPECT_EQ(cascade.band.k_lo_radpm,
                  c == 0 ? 0.01 : tests::few_waves()->cascades[1].band.k_lo_radpm);
        EXPECT_GT(cascade.band.k_hi_radpm, 0.1);
        EXPECT_EQ(cascade.keyframes.before->time_us(), before_us[c]);
        EXPECT_EQ(cascade.keyframes.after->time_us(), after_us[c]);
        ASSERT_TRUE(cascade.foam_before && cascade.foam_after);
        EXPECT_EQ(cascade.foam_before->time_us, before_us[c]);
        EXPECT_EQ(cascade.foam_after->time_us, after_us[c]);
        for (const sea::KeyframePtr& foam : {cascade.foam_before, cascade.foam_after})
            EXPECT_NEAR(foam->plane(sea::Field::foam)[7], FoamySea::ratio(*foam), 0.0011f);
    }
}

class SeaWithoutCascades : public tests::WaveSea {
  public:
    std::vector<server::SharedBytes> sea_state_messages() const override {
        protocol::SeaStateValues state;
        state.epoch = epoch;
        return {std::make_shared<const protocol::Bytes>(protocol::sea_state(state))};
    }
};

TEST(SeaSource, of_a_sea_without_cascades_there_is_no_frame) {
    SeaWithoutCascades sea;
    const auto net = tests::serve(sea);
    ASSERT_TRUE(net);
    const auto client = Client::connect({.url = net->url()});
    ASSERT_TRUE(client) << client.error().message;
    const Result<SeaFrame> frame = sea_frame_at(**client, 3'130'000, 10);
    ASSERT_FALSE(frame);
    EXPECT_NE(frame.error().message.find("0 cascades; 1 to "), std::string::npos)
        << frame.error().message;
}

} // namespace
} // namespace seaway::client
