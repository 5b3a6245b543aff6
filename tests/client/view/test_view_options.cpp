// SPDX-License-Identifier: Apache-2.0
// The command line of seaway-view: every option reaches its own value, up to its limits and no further.
#include <algorithm>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/text_file.h"
#include "client/link/failure.h"
#include "client/view/look_file.h"
#include "client/view/look_keys.h"
#include "client/view/view_options.h"
#include "gpu/call.h"
#include "tests/support/folder.h"

namespace seaway::client {
namespace {

/// Words with blanks between them, behind what every command line needs.
std::variant<ViewOptions, int> read(const std::string& more,
                                    const std::string& url = "ws://127.0.0.1:9") {
    std::istringstream words("seaway-view " + url + " " + more);
    std::vector<std::string> arguments;
    for (std::string word; words >> word;)
        arguments.push_back(word);
    if (more.find("--out ") == std::string::npos)
        arguments.insert(arguments.end(), {"--out", "a.png"});
    if (more.find("--offscreen") == std::string::npos)
        arguments.insert(arguments.end(), {"--offscreen", "64x48"});
    std::vector<const char*> argv;
    for (const std::string& argument : arguments)
        argv.push_back(argument.c_str());
    return read_view_options(static_cast<int>(argv.size()), argv.data());
}

std::string complaint(const std::string& more) {
    ::testing::internal::CaptureStderr();
    const auto refused = read(more);
    const std::string said = ::testing::internal::GetCapturedStderr();
    return std::holds_alternative<int>(refused) && std::get<int>(refused) == 2 ? said
                                                                               : "taken: " + said;
}

// Pictures of a quality that draws fewer pixels are enlarged, numbers are not.
TEST(ViewOptions, an_exr_is_drawn_at_the_size_that_was_asked_for) {
    for (const Quality& quality : quality_table) {
        const std::string words = "--quality " + std::string(quality.name) + " --out a";
        EXPECT_EQ(std::get<ViewOptions>(read(words + ".exr")).quality.scale, 1) << quality.name;
        EXPECT_EQ(std::get<ViewOptions>(read(words + ".png")).quality.scale, quality.scale);
    }
}

TEST(ViewOptions, every_option_reaches_its_own_value) {
    const auto read_as =
        read("--offscreen 320x200 --frames 7 --camera 11,-22,33,44,-55 --time-of-day 8.5 "
             "--time 123.25 --debug cascade:3 --device some-gpu --token-file t.txt --ca-file c.pem "
             "--timeout 4.5 --path p.csv --fov 35.5 --quality film",
             "wss://127.0.0.1:9");
    ASSERT_TRUE(std::holds_alternative<ViewOptions>(read_as));
    const auto& options = std::get<ViewOptions>(read_as);
    EXPECT_EQ(options.url, "wss://127.0.0.1:9");
    EXPECT_EQ(options.out, "a.png");
    EXPECT_EQ(options.camera.width, 320);
    EXPECT_EQ(options.camera.height, 200);
    EXPECT_EQ(options.frames, 7);
    EXPECT_EQ(options.camera.x_m, 11);
    EXPECT_EQ(options.camera.y_m, -22);
    EXPECT_EQ(options.camera.z_m, 33);
    EXPECT_EQ(options.camera.yaw_deg, 44);
    EXPECT_EQ(options.camera.pitch_deg, -55);
    EXPECT_EQ(options.look.hour, 8.5);
    EXPECT_EQ(options.time_s, std::optional(123.25));
    EXPECT_EQ(options.debug.view, DebugView::cascade);
    EXPECT_EQ(options.debug.cascade, 3);
    EXPECT_EQ(options.device, "some-gpu");
    EXPECT_EQ(options.token_file, "t.txt");
    EXPECT_EQ(options.ca_file, "c.pem");
    EXPECT_EQ(options.timeout_s, 4.5);
    EXPECT_EQ(options.path, "p.csv");
    EXPECT_EQ(options.camera.view_deg, 35.5);
    EXPECT_EQ(options.quality.name, "film");
    EXPECT_FALSE(options.turntable);
    EXPECT_TRUE(std::get<ViewOptions>(read("--turntable")).turntable);
    EXPECT_THAT(complaint("--ca-file c.pem"), ::testing::HasSubstr("no certificate is looked at"));
}

TEST(ViewOptions, frames_of_a_piece_are_those_of_the_whole) {
    const auto options =
        std::get<ViewOptions>(read("--time 10 --first 100 --frames 5 --fps 24000/1001"));
    EXPECT_EQ(options.frame(0), 100);
    EXPECT_EQ(options.frame(4), 104);
    EXPECT_TRUE(options.numbered());
    EXPECT_TRUE(std::get<ViewOptions>(read("--time 10 --first 0")).numbered());
    EXPECT_FALSE(std::get<ViewOptions>(read("--time 10")).numbered());
    EXPECT_EQ(options.rate, (FrameRate{24000, 1001}));
    EXPECT_EQ(std::get<ViewOptions>(read("--fps 23.976")).rate, (FrameRate{23.976, 1}));
    EXPECT_EQ(std::get<ViewOptions>(read("")).rate, (FrameRate{30, 1}));
}

TEST(ViewOptions, a_piece_that_would_not_fit_into_its_film_is_refused) {
    using ::testing::HasSubstr;
    EXPECT_THAT(complaint("--first 3"), HasSubstr("--first needs --time"));
    EXPECT_THAT(complaint("--first 3 --time now"), HasSubstr("--first needs --time"));
    EXPECT_THAT(complaint("--first 3 --time 1 --turntable"), HasSubstr("--first and --turntable"));
    EXPECT_THAT(complaint("--first 999999 --time 1 --frames 2"),
                HasSubstr("--first 999999 --frames 2: frames are numbered 0 .. 999999"));
    EXPECT_EQ(complaint("--first 999998 --time 1 --frames 2"), "taken: ");
}

TEST(FrameRate, frames_do_not_drift_and_are_rounded_once) {
    const FrameRate film{24000, 1001};
    EXPECT_EQ(film.offset_us(24000), 1'001'000'000);
    EXPECT_EQ(film.offset_us(999'999), 41'708'291'625); // 41708.291625 s
    EXPECT_EQ((FrameRate{24, 1}.offset_us(101)), 4'208'333);
    EXPECT_EQ((FrameRate{30, 1}.offset_us(2)), 66'667);
}

TEST(ViewOptions, now_is_no_time_of_its_own) {
    EXPECT_EQ(std::get<ViewOptions>(read("--time now")).time_s, std::nullopt);
    EXPECT_EQ(std::get<ViewOptions>(read("")).time_s, std::nullopt);
}

TEST(ViewOptions, what_is_said_of_the_look_wins_over_its_file) {
    const std::string file = tests::folder().write("options_look.toml", R"([time]
latitude_deg = 54
longitude_deg = 2
utc = 2026-06-21T03:30:00Z
[light]
exposure = "12ev"
exposure_stops = 2
[air]
visibility_km = 9
aerosol_albedo = 0.8
[clouds]
coverage = 0.7
[water]
type = "II"
)");
    const auto look = [&](const std::string& more) {
        return std::get<ViewOptions>(read("--look " + file + more)).look;
    };
    const Look as_it_is = look("");
    EXPECT_EQ(to_toml(as_it_is), to_toml(*read_look(file)));
    EXPECT_EQ(std::get<ViewOptions>(read("--look " + file)).look_path, file);
    const Look over = look(" --visibility 30 --clouds 0.1 --water 5C --exposure 0.02 "
                           "--place -33.9,18.4 --date 2026-12-24T20:15Z");
    EXPECT_EQ(over.air.visibility_m, 30e3);
    EXPECT_EQ(over.air.aerosol_albedo, 0.8) << "of the file, still";
    EXPECT_EQ(over.clouds.coverage, 0.1);
    EXPECT_EQ(over.water, sea::WaterType::coastal_5);
    EXPECT_EQ(over.exposure, (Exposure{Exposure::By::factor, 0.02}));
    ASSERT_TRUE(over.place);
    EXPECT_EQ(over.place->latitude_deg, -33.9);
    EXPECT_EQ(over.place->longitude_deg, 18.4);
    EXPECT_EQ(to_text(over.place->when), "2026-12-24T20:15:00Z");
    EXPECT_EQ(over.exposure_stops, 0) << "of the file's exposure";
    EXPECT_EQ(look(" --exposure auto").exposure, Exposure{});
    EXPECT_EQ(to_text(look(" --date 2027-01-01T00:00Z").place->when), "2027-01-01T00:00:00Z")
        << "at the file's place";
    const Look by_hour = look(" --time-of-day 8");
    EXPECT_FALSE(by_hour.place);
    EXPECT_EQ(by_hour.hour, 8);
    EXPECT_EQ(std::get<ViewOptions>(read("--quality low --density 3.5")).quality.cell_pixels, 3.5);
    ::testing::internal::CaptureStderr();
    EXPECT_EQ(std::get<int>(read("--look /nowhere/look.toml")), 2);
    EXPECT_THAT(::testing::internal::GetCapturedStderr(),
                ::testing::HasSubstr("cannot read look '/nowhere/look.toml'"));
}

// What would change nothing in the picture is refused, both by name.
TEST(ViewOptions, what_would_be_without_effect_is_refused_by_name) {
    for (const char* other : {"--clouds 0.3", "--time-of-day 8",
                              "--place 1,2 --date 2026-06-21T18:30Z", "--date 2026-06-21T18:30Z"}) {
        const std::string said = complaint("--sky h.exr " + std::string(other));
        const std::string name = std::string(other).substr(0, std::string(other).find(' '));
        EXPECT_THAT(said, ::testing::StartsWith("seaway-view: --sky and ")) << other;
        EXPECT_THAT(said, ::testing::HasSubstr(name)) << other;
        EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << said;
    }
    EXPECT_EQ(complaint("--sky h.exr --visibility 9 --water 3C --exposure 12ev"), "taken: ");
    const std::string said = complaint("--out b.exr --exposure 12ev");
    EXPECT_THAT(said, ::testing::HasSubstr("--exposure and --out b.exr"));
    EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << said;
    EXPECT_EQ(complaint("--out b.exr"), "taken: ");
}

// Options win over the file: a sky that options ask for takes away the other kind, and what was of it alone.
TEST(ViewOptions, a_sky_of_options_is_in_place_of_the_files) {
    const std::string computed = tests::folder().write("computed_look.toml", R"([time]
latitude_deg = 54
longitude_deg = 2
utc = 2026-06-21T03:30:00Z
[air]
visibility_km = 9
[clouds]
coverage = 0.7
)");
    const std::string picture = tests::folder().write("picture_look.toml", R"([sky]
environment = "h.exr"
turn_deg = 40
[air]
visibility_km = 9
)");
    const auto look = [](const std::string& words) {
        const auto taken = read("--look " + words);
        EXPECT_TRUE(std::holds_alternative<ViewOptions>(taken)) << words;
        const Look out =
            std::holds_alternative<ViewOptions>(taken) ? std::get<ViewOptions>(taken).look : Look{};
        const Result<Look> back = parse_look(to_toml(out), "l.toml", "");
        EXPECT_TRUE(back && *back == out) << "reads back as the same look: " << words << "\n"
                                          << to_toml(out);
        return out;
    };
    const Look with_picture = look(computed + " --sky other.exr");
    EXPECT_EQ(with_picture.environment, "other.exr");
    EXPECT_EQ(with_picture.air.visibility_m, 9000) << "of the file, still";
    EXPECT_FALSE(with_picture.place);
    EXPECT_EQ(with_picture.clouds, Clouds{});
    for (const char* of_computed :
         {" --clouds 0.2", " --time-of-day 8", " --place 1,2 --date 2026-06-21T18:30Z"}) {
        const Look over = look(picture + of_computed);
        EXPECT_EQ(over.environment, "") << of_computed;
        EXPECT_EQ(over.environment_turn_deg, 0) << of_computed;
        EXPECT_EQ(over.air.visibility_m, 9000) << of_computed;
    }
    EXPECT_EQ(look(picture + " --clouds 0.2").clouds.coverage, 0.2);
    EXPECT_EQ(look(picture + " --sky other.exr").environment_turn_deg, 0) << "of another picture";
    const std::string by_hour = tests::folder().write("hour_look.toml", "[time]\nhour = 7\n");
    EXPECT_EQ(look(by_hour + " --place 1,2 --date 2026-06-21T18:30Z").hour, Look{}.hour)
        << "it follows from place and date";
}

TEST(ViewOptions, the_keys_of_looks_are_printed_with_their_ranges) {
    ::testing::internal::CaptureStdout();
    const char* const argv[] = {"seaway-view", "--list-look"};
    EXPECT_EQ(std::get<int>(read_view_options(2, argv)), 0);
    const std::string said = ::testing::internal::GetCapturedStdout();
    for (const LookKey& row : look_keys())
        EXPECT_THAT(said, ::testing::HasSubstr(fmt::format("{}: {}\n", allowed(row), row.meaning)));
}

struct Limit {
    const char* within;
    const char* beyond;
};

void expect_limits(std::span<const Limit> limits) {
    for (const Limit& limit : limits) {
        EXPECT_TRUE(std::holds_alternative<ViewOptions>(read(limit.within))) << limit.within;
        ::testing::internal::CaptureStderr();
        const auto refused = read(limit.beyond);
        const std::string said = ::testing::internal::GetCapturedStderr();
        ASSERT_TRUE(std::holds_alternative<int>(refused)) << limit.beyond;
        EXPECT_EQ(std::get<int>(refused), 2) << limit.beyond;
        const std::string beyond = limit.beyond;
        const std::string name = beyond.substr(0, beyond.find(' '));
        EXPECT_THAT(said, ::testing::HasSubstr(name == "--time" &&
                                                       said.find("--frames") != std::string::npos
                                                   ? "--frames 32"
                                                   : name))
            << limit.beyond;
        EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << said;
    }
}

TEST(ViewOptions, are_taken_at_their_limits_and_refused_beyond_them) {
    const Limit limits[] = {
        {"--offscreen 16x17", "--offscreen 15x17"},
        {"--fov 1", "--fov 0.99"},
        {"--fov 150", "--fov 150.5"},
        {"--turntable", "--turntable --path p.csv"},
        {"--offscreen 17x16", "--offscreen 17x15"},
        {"--offscreen 16384x16", "--offscreen 16385x16"},
        {"--offscreen 16x16384", "--offscreen 16x16385"},
        {"--offscreen 20x20", "--offscreen 20.5x20"},
        {"--offscreen 20x20", "--offscreen 20x20x"},
        {"--camera 1e7,0,1,0,0", "--camera 1.0001e7,0,1,0,0"},
        {"--camera 0,-1e7,1,0,0", "--camera 0,-1.0001e7,1,0,0"},
        {"--camera 0,0,2e4,0,0", "--camera 0,0,2.0001e4,0,0"},
        {"--camera 0,0,-50,0,0", "--camera 0,0,-50.1,0,0"},
        {"--camera 0,0,1,720,89", "--camera 0,0,1,720,89.01"},
        {"--camera 0,0,1,0,-89", "--camera 0,0,1,0,-89.01"},
        {"--camera 0,0,1,-36000,0", "--camera 0,0,1,1e308,0"},
        {"--camera 1,2,3,4,5", "--camera 1,2,3,4,5,6"},
        {"--camera 1,2,3,4,5", "--camera 1,2,3,4"},
        {"--first 0 --time 1", "--first -1 --time 1"},
        {"--first 999999 --time 1", "--first 1000000 --time 1"},
        {"--fps 1000", "--fps 1000.1"},
        {"--fps 1e-6", "--fps 0"},
        {"--fps 24000/1001", "--fps 24000/1001.5"},
        {"--fps 1000000/1000", "--fps 1000001/1001"},
        {"--fps 1/1000000", "--fps 1/0"},
        {"--fps 30", "--fps nan"},
        {"--frames 1", "--frames 0"},
        {"--frames 1000000", "--frames 1000001"},
        {"--time-of-day 0", "--time-of-day -0.01"},
        {"--time-of-day 24", "--time-of-day 24.01"},
        {"--time 1e12", "--time 1.0000001e12"},
        {"--time -1e12", "--time -1.0000001e12"},
        // Thirty frames a second: the last of 31 is a second later than the first.
        {"--time 999999999999 --frames 31", "--time 999999999999 --frames 32"},
        {"--timeout 0.0001", "--timeout 0"},
        {"--timeout 86400", "--timeout 86400.1"},
        {"--debug cascade:7", "--debug cascade:8"},
    };
    expect_limits(limits);
}

TEST(ViewOptions, of_the_look_are_taken_at_their_limits_and_refused_beyond_them) {
    const Limit limits[] = {
        {"--visibility 0.2", "--visibility 0.199"},
        {"--visibility 280", "--visibility 280.1"},
        {"--clouds 0", "--clouds -0.01"},
        {"--clouds 1", "--clouds 1.01"},
        {"--density 1", "--density 0.99"},
        {"--density 64", "--density 64.1"},
        {"--water 9C", "--water 10C"},
        {"--exposure auto", "--exposure bright"},
        {"--exposure 32ev", "--exposure 33ev"},
        {"--exposure 1e-9", "--exposure 0"},
        {"--place 90,-180 --date 2026-06-21T18:30Z", "--place 91,0 --date 2026-06-21T18:30Z"},
        {"--place -90,180 --date 2026-06-21T18:30Z", "--place 0,181 --date 2026-06-21T18:30Z"},
        {"--place 1,2 --date 2026-06-21T18:30:01Z", "--place 1,2"},
        {"--place 1,2 --date 2026-06-21T18:30:01Z", "--date 2026-06-31T18:30Z --place 1,2"},
        {"--place 1,2 --date 2026-06-21T18:30:01Z",
         "--time-of-day 3 --place 1,2 --date 2026-06-21T18:30:01Z"},
    };
    expect_limits(limits);
}

// What a bench meets on the way: each is told by its own code, also on a server.
TEST(ViewOptions, an_error_has_the_exit_code_of_who_it_is_of) {
    const std::pair<Error, ExitCode> errors[] = {
        {Error("vkQueueSubmit2: device lost"), exit_no_device},
        {Error(VK_ERROR_DEVICE_LOST, "vkQueueSubmit2: device lost"), exit_no_device},
        {failed(Failure::bad_argument, "mip 10"), exit_usage},
        {failed(Failure::lost, "the server is gone"), exit_lost},
        {failed(Failure::cannot_connect, "nobody there"), exit_lost},
        {failed(Failure::deadline, "no answer"), exit_lost},
        {failed(Failure::refused, "no foam"), exit_refused},
        {Error(OutputError::lost, "disk full"), exit_output}};
    for (const auto& [error, code] : errors)
        EXPECT_EQ(exit_code(error, exit_no_device), code) << error.message;
}

} // namespace
} // namespace seaway::client
