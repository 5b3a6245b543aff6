// SPDX-License-Identifier: Apache-2.0
// Look files: every key reaches its own value, within its range and no further; what is written reads back; what is no
// look is refused in one line that says where.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "client/view/look_file.h"
#include "client/view/look_keys.h"
#include "client/view/view_sky.h"
#include "tests/support/folder.h"
#include "tests/support/read_file.h"

namespace seaway::client {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::string look_error(const std::string& text) {
    const Result<Look> look = parse_look(text, "l.toml", "");
    return look ? "no error" : look.error().message;
}

Look look_of(const std::string& text) {
    const Result<Look> look = parse_look(text, "l.toml", "");
    EXPECT_TRUE(look) << (look ? "" : look.error().message);
    return look ? *look : Look{};
}

TEST(LookFile, an_empty_one_is_the_default_look) {
    EXPECT_EQ(to_toml(look_of("")), to_toml(Look{}));
    EXPECT_EQ(look_of("").hour, 15.5);
    EXPECT_FALSE(look_of("").water);
}

/// Of a computed sky, or of a picture in its place: what is refused beside each other.
bool is_of(const LookKey& row, bool picture) {
    const bool of_picture = row.table == "sky";
    const bool of_computed = row.table == "time" || row.table == "clouds";
    return picture ? !of_computed : !of_picture;
}

/// A value that no other key has, in each number of such a look, at once.
void expect_own_values(bool picture) {
    std::string text, heading;
    std::vector<std::pair<const LookKey*, double>> given;
    for (const LookKey& row : look_keys()) {
        const auto* number = std::get_if<LookNumber>(&row.value);
        if (number == nullptr || !is_of(row, picture))
            continue;
        const double share = 0.1 + 0.03 * static_cast<double>(given.size());
        const double value = number->range.lo + share * (number->range.hi - number->range.lo);
        if (row.table != heading)
            text += fmt::format("[{}]\n", row.table);
        if (row.table != heading && row.table == "sky")
            text += "environment = \"sky.exr\"\n";
        heading = row.table;
        text += fmt::format("{} = {}\n", row.key, value);
        given.emplace_back(&row, value);
    }
    Look look = look_of(text);
    for (const auto& [row, value] : given) {
        const auto& number = std::get<LookNumber>(row->value);
        EXPECT_EQ(number.of(look), value * number.unit) << row->table << "." << row->key;
    }
    EXPECT_EQ(look_of(to_toml(look)), look) << "to the bit: " << text;
    EXPECT_EQ(to_toml(look_of(to_toml(look))), to_toml(look));
}

TEST(LookFile, every_number_reaches_its_own_value_and_reads_back) {
    for (const bool picture : {false, true})
        expect_own_values(picture);
}

TEST(LookFile, every_number_is_taken_at_its_limits_and_refused_beyond_them) {
    for (const LookKey& row : look_keys()) {
        const auto* number = std::get_if<LookNumber>(&row.value);
        if (number == nullptr)
            continue;
        const auto with = [&](double value) {
            const bool of_picture = row.table == "sky";
            return look_error(fmt::format("\n[{}]\n{} = {}\n{}", row.table, row.key, value,
                                          of_picture ? "environment = \"sky.exr\"" : ""));
        };
        EXPECT_EQ(with(number->range.lo), "no error") << row.key;
        EXPECT_EQ(with(number->range.hi), "no error") << row.key;
        const std::string where = fmt::format("l.toml:3: {}.{}: ", row.table, row.key);
        const std::string range =
            fmt::format("allowed: a number {} .. {}", number->range.lo, number->range.hi);
        // What is smaller than a normal number counts as 0 (base/normal_number.h).
        const double below = number->range.lo == 0 ? -std::numeric_limits<double>::min()
                                                   : std::nextafter(number->range.lo, -INFINITY);
        for (const double bad : {below, std::nextafter(number->range.hi, INFINITY), std::nan("")})
            EXPECT_THAT(with(bad), AllOf(HasSubstr(where), HasSubstr(range))) << row.key;
    }
}

TEST(LookFile, what_is_no_number_reaches_its_own_value_too) {
    const Look look = look_of(R"([time]
latitude_deg = 54.2
longitude_deg = -7.9
utc = 2026-06-21T03:10:05Z
[light]
exposure = "13.5ev"
[air]
rayleigh_per_m = [1e-6, 2e-6, 3e-6]
ozone_per_m = [4e-6, 5e-6, 6e-6]
[water]
type = "3C"
bottom_albedo = [0.1, 0.2, 0.3]
)");
    ASSERT_TRUE(look.place);
    EXPECT_EQ(look.place->latitude_deg, 54.2);
    EXPECT_EQ(look.place->longitude_deg, -7.9);
    EXPECT_EQ(to_text(look.place->when), "2026-06-21T03:10:05Z");
    EXPECT_EQ(look.exposure, (Exposure{Exposure::By::exposure_value, 13.5}));
    EXPECT_EQ(look.air.rayleigh_scattering_per_m, glm::dvec3(1e-6, 2e-6, 3e-6));
    EXPECT_EQ(look.air.ozone_absorption_per_m, glm::dvec3(4e-6, 5e-6, 6e-6));
    EXPECT_EQ(look.water, sea::WaterType::coastal_3);
    EXPECT_EQ(look.bottom_albedo, (std::array<double, 3>{0.1, 0.2, 0.3}));
    EXPECT_EQ(to_toml(look_of(to_toml(look))), to_toml(look));
    EXPECT_THAT(to_toml(look), Not(HasSubstr("hour")));
    // A date as text, and without seconds, is the same as TOML's own.
    EXPECT_EQ(to_text(look_of("[time]\nlatitude_deg = 0\nlongitude_deg = 0\n"
                              "utc = \"2026-06-21T03:10Z\"")
                          .place->when),
              "2026-06-21T03:10:00Z");
    EXPECT_EQ(look_of("[light]\nexposure = 0.25").exposure, (Exposure{Exposure::By::factor, 0.25}));
    EXPECT_EQ(look_of("[time]\nhour = 6").hour, 6);
}

TEST(LookFile, what_is_wrong_is_named_with_its_line_and_the_nearest_key) {
    EXPECT_THAT(look_error("[air]\nvisibilty_km = 3"),
                AllOf(HasSubstr("l.toml:2: air.visibilty_km: unknown key"),
                      HasSubstr("the nearest is visibility_km")));
    EXPECT_THAT(look_error("[cloud]\ncoverage = 0.3"),
                HasSubstr("l.toml:1: cloud: unknown key; the nearest is clouds"));
    EXPECT_THAT(look_error("[clouds]\ncoverage = true"), HasSubstr("clouds.coverage: true"));
    EXPECT_THAT(look_error("[water]\ntype = \"10C\""), HasSubstr("water.type: \"10C\""));
    EXPECT_THAT(look_error("[light]\nexposure = \"bright\""),
                AllOf(HasSubstr("l.toml:2: light.exposure"), HasSubstr("auto")));
    EXPECT_THAT(look_error("[light]\nexposure = 0"), HasSubstr("light.exposure: 0"));
    EXPECT_THAT(look_error("[light]\nexposure = \"40ev\""), HasSubstr("-16ev .. 32ev"));
    const std::string place = "[time]\nlatitude_deg = 1\nlongitude_deg = 2\n";
    EXPECT_THAT(look_error("[time]\nlatitude_deg = 91"), HasSubstr("time.latitude_deg: 91"));
    EXPECT_THAT(look_error(place), HasSubstr("time.utc: missing"));
    EXPECT_THAT(look_error("[time]\nutc = 2026-06-21T03:10:05Z"),
                HasSubstr("time.latitude_deg: missing"));
    EXPECT_THAT(look_error(place + "utc = 2026-06-21T03:10:05Z\nhour = 3"),
                HasSubstr("time.hour: not beside a place"));
    for (const char* bad : {"2026-06-21T03:10:05+02:00", "2026-06-21", "2026-06-21T03:10:05",
                            "\"2026-02-30T00:00Z\"", "2051-01-01T00:00:00Z", "7"})
        EXPECT_THAT(look_error(place + "utc = " + bad), HasSubstr("l.toml:4: time.utc: ")) << bad;
}

// A picture of the sky has its own sun and clouds: what would be passed over in silence is refused, both named.
TEST(LookFile, what_a_picture_of_the_sky_makes_void_is_refused_beside_it) {
    const std::string sky = "[sky]\nenvironment = \"h.exr\"\n";
    EXPECT_THAT(look_error(sky + "[clouds]\ncoverage = 0.3"),
                AllOf(HasSubstr("l.toml:3: clouds: "), HasSubstr("sky.environment")));
    EXPECT_THAT(look_error("[time]\nhour = 3\n" + sky),
                AllOf(HasSubstr("l.toml:1: time: "), HasSubstr("sky.environment")));
    EXPECT_THAT(look_error("[sky]\nturn_deg = 20"),
                AllOf(HasSubstr("l.toml:2: sky.turn_deg: "), HasSubstr("environment")));
    EXPECT_EQ(look_error(sky + "turn_deg = 20\n[air]\nvisibility_km = 4\n"
                               "[light]\nsun_strength = 2"),
              "no error")
        << "these change such a sky, too";
}

TEST(LookFile, every_look_is_written_as_one_that_can_be_read_and_counts_the_same) {
    Look look;
    look.hour = 7;
    look.clouds.coverage = 0.4;
    look.environment_turn_deg = 30;
    EXPECT_EQ(look_of(to_toml(look)).hour, 7);
    EXPECT_EQ(look_of(to_toml(look)).environment_turn_deg, 0) << "of no picture";
    look.place = PlaceAndTime{54, 2, *parse_instant("2026-06-21T03:30:00Z")};
    EXPECT_EQ(look_of(to_toml(look)).place, look.place);
    EXPECT_EQ(look_of(to_toml(look)).clouds, look.clouds);
    look.environment = "h.exr";
    const Look with_picture = look_of(to_toml(look));
    EXPECT_EQ(with_picture.environment, "h.exr");
    EXPECT_EQ(with_picture.environment_turn_deg, 30);
    EXPECT_FALSE(with_picture.place);
    EXPECT_EQ(with_picture.clouds, Clouds{});
}

TEST(LookFile, what_is_no_file_of_text_is_refused_in_one_line) {
    const tests::Folder& folder = tests::folder();
    const auto refused = [](const std::string& path) {
        const Result<Look> look = read_look(path);
        const std::string said = look ? "read" : look.error().message;
        EXPECT_THAT(said, AllOf(HasSubstr("cannot read look '" + path + "': "))) << path;
        EXPECT_EQ(said.find('\n'), std::string::npos) << said;
        return said;
    };
    EXPECT_THAT(refused("/nowhere/look.toml"), HasSubstr("no such file"));
    EXPECT_THAT(refused(folder.file("")), HasSubstr("folder"));
    EXPECT_THAT(refused("/dev/zero"), HasSubstr("regular file"));
    const std::string pipe = folder.file("pipe.toml");
    ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
    EXPECT_THAT(refused(pipe), HasSubstr("regular file"));
    const std::string huge = folder.write("huge.toml", "");
    std::filesystem::resize_file(huge, std::uintmax_t{1} << 30); // takes no room on the disk
    EXPECT_THAT(refused(huge), HasSubstr(fmt::format("more than {} bytes", look_text_bytes_max)));
    const std::string garbage = folder.write("garbage.toml", "\x7f"
                                                             "ELF\x02\x01\xff\xfe[[[");
    EXPECT_THAT(read_look(garbage).error().message, HasSubstr(garbage + ":1: byte 0x7f"));
    EXPECT_TRUE(read_look(folder.write("empty.toml", "")));
}

TEST(LookFile, what_is_saved_is_what_is_loaded_and_a_failure_leaves_the_old_file) {
    const std::string path = tests::folder().file("saved.toml");
    Look look;
    look.air.visibility_m = 12'345.678;
    look.clouds.coverage = 1.0 / 3;
    look.water = sea::WaterType::jerlov_1b;
    ASSERT_TRUE(write_look(look, path));
    EXPECT_EQ(to_toml(*read_look(path)), to_toml(look));
    look.hour = 4;
    ASSERT_TRUE(write_look(look, path));
    EXPECT_EQ(read_look(path)->hour, 4);
    const auto why = [&](const std::string& to) {
        const Result<void> written = write_look(look, to);
        return written ? "written" : written.error().message;
    };
    EXPECT_THAT(why("/nowhere/at/all.toml"), HasSubstr("cannot write look '/nowhere/at/all.toml'"));
    EXPECT_THAT(why(tests::folder().file("")), HasSubstr("cannot write look"));
    // Of the test's own: a mistake would put a file in the place of a device of the machine.
    const std::string pipe = tests::folder().file("saved_pipe.toml");
    ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
    EXPECT_THAT(why(pipe), HasSubstr("regular file"));
    EXPECT_THAT(why(""), HasSubstr("no name"));
    EXPECT_FALSE(std::filesystem::exists(path + ".part"));
}

TEST(LookFile, a_picture_of_the_sky_is_looked_for_beside_the_look) {
    const std::string folder = tests::folder().file("skies");
    std::filesystem::create_directory(folder);
    std::ofstream(folder + "/harbour.toml")
        << "[sky]\nenvironment = \"exr/h.exr\"\nturn_deg = 90\n";
    const Result<Look> look = read_look(folder + "/harbour.toml");
    ASSERT_TRUE(look) << look.error().message;
    EXPECT_EQ(look->environment, folder + "/exr/h.exr");
    EXPECT_EQ(look->environment_turn_deg, 90);
    // Saved elsewhere it is the same picture still, and saved beside it has the same short name.
    ASSERT_TRUE(write_look(*look, tests::folder().file("moved.toml")));
    EXPECT_EQ(read_look(tests::folder().file("moved.toml"))->environment, look->environment);
    ASSERT_TRUE(write_look(*look, folder + "/again.toml"));
    EXPECT_THAT(tests::read_file(folder + "/again.toml"),
                HasSubstr("environment = \"exr/h.exr\"\n"));
    EXPECT_THAT(look_error("[sky]\nenvironment = \"\""), HasSubstr("sky.environment: \"\""));
    EXPECT_THAT(look_error("[sky]\nenvironment = 'a\"b'"), HasSubstr("without quotes"));
    Look odd;
    odd.environment = "a\"b.exr";
    const auto why = [&](const std::string& name) {
        odd.environment = name;
        const Result<void> written = write_look(odd, folder + "/odd.toml");
        return written ? "written" : written.error().message;
    };
    // What would be refused when it is read is not written.
    EXPECT_THAT(why("a\"b.exr"), HasSubstr("sky.environment"));
    EXPECT_THAT(why("caf\xe9.exr"), AllOf(HasSubstr("sky.environment"), HasSubstr("UTF-8")));
    EXPECT_THAT(why(folder + "/" + std::string(1021, 'x') + ".exr"),
                AllOf(HasSubstr("sky.environment"), HasSubstr("1 .. 1024 bytes")));
    EXPECT_FALSE(std::filesystem::exists(folder + "/odd.toml"));
    ASSERT_EQ(why(folder + "/" + std::string(1020, 'x') + ".exr"), "written");
    EXPECT_EQ(read_look(folder + "/odd.toml")->environment, odd.environment);
    ASSERT_EQ(why(folder + "/caf\xc3\xa9.exr"), "written");
    EXPECT_EQ(read_look(folder + "/odd.toml")->environment, odd.environment);
}

// EV 15 is full sun: what a meter then looks at is 4.1 kcd/m2, a grey sheet in 71 klx.
TEST(LookFile, exposure_is_what_a_camera_is_set_to) {
    EXPECT_FALSE(fixed_exposure({}));
    EXPECT_NEAR(0.18 / *fixed_exposure({Exposure::By::exposure_value, 15}), 4.096, 1e-9);
    EXPECT_NEAR(*fixed_exposure({Exposure::By::exposure_value, 14}) /
                    *fixed_exposure({Exposure::By::exposure_value, 15}),
                2, 1e-12);
    EXPECT_EQ(*fixed_exposure({Exposure::By::factor, 0.031}), 0.031);
    for (const char* text : {"auto", "14.5ev", "-3ev", "0.02"})
        EXPECT_EQ(to_text(*parse_exposure(text)), text);
}

TEST(LookFile, stops_are_added_to_whatever_exposure_is) {
    Look look;
    EXPECT_EQ(exposure_of(look, 0.3), 0.3);
    look.exposure_stops = 1.5;
    EXPECT_NEAR(exposure_of(look, 0.3), 0.3 * std::exp2(1.5), 1e-15);
    look.exposure = {Exposure::By::factor, 0.04};
    EXPECT_NEAR(exposure_of(look, 0.3), 0.04 * std::exp2(1.5), 1e-15);
    look.exposure = {Exposure::By::exposure_value, 14};
    const double a_stop_less = *fixed_exposure({Exposure::By::exposure_value, 13});
    look.exposure_stops = 1;
    EXPECT_NEAR(exposure_of(look, 0.3), a_stop_less, 1e-12 * a_stop_less);
}

// What a window and --bench show: exposure and bloom of the look, by the light on the sea where it is metered.
TEST(LookFile, a_look_says_how_a_window_and_a_bench_show_it) {
    SkyMaker maker;
    Look look;
    const Result<Sky> sky = sky_of_frame(maker, look, Camera{}, 0);
    ASSERT_TRUE(sky) << sky.error().message;
    const double by_light = exposure_by_light(sky->white_radiance());
    EXPECT_EQ(display_by_light(look, *sky, DebugView::final, 2).exposure, by_light);
    look.exposure = {Exposure::By::factor, 0.04};
    look.exposure_stops = 1;
    look.bloom = 0.25;
    const Display display = display_by_light(look, *sky, DebugView::height, 2);
    EXPECT_EQ(display.exposure, 0.08);
    EXPECT_EQ(display.bloom, 0.25);
    EXPECT_EQ(display.view, DebugView::height);
    EXPECT_EQ(display.significant_height_m, 2);
}

TEST(LookFile, the_page_lists_every_key_with_its_range_and_meaning) {
    const std::string page = tests::read_file(SEAWAY_SOURCE_DIR "/docs/view.md");
    for (const LookKey& row : look_keys()) {
        const std::string line = fmt::format("| `{}` | `{}` | {} | {} |\n", row.table, row.key,
                                             allowed(row), row.meaning);
        EXPECT_TRUE(page.find(line) != std::string::npos) << "docs/view.md lacks: " << line;
    }
}

TEST(LookFile, those_that_come_with_the_project_are_read_and_written_back) {
    int count = 0;
    for (const auto& entry :
         std::filesystem::directory_iterator(std::filesystem::path(SEAWAY_SOURCE_DIR) / "looks")) {
        const Result<Look> look = read_look(entry.path().string());
        ASSERT_TRUE(look) << look.error().message;
        EXPECT_EQ(to_toml(look_of(to_toml(*look))), to_toml(*look)) << entry.path();
        EXPECT_NE(to_toml(*look), to_toml(Look{})) << entry.path();
        ++count;
    }
    EXPECT_EQ(count, 4);
}

TEST(LookFile, the_water_of_a_look_wins_over_that_of_the_sea) {
    SeaFrame frame;
    frame.water = {sea::WaterType::coastal_7, {0.1, 0.2, 0.3}};
    Look look;
    set_water(frame, look);
    EXPECT_EQ(frame.water, (sea::Water{sea::WaterType::coastal_7, {0.1, 0.2, 0.3}}));
    look.water = sea::WaterType::jerlov_2;
    set_water(frame, look);
    EXPECT_EQ(frame.water, (sea::Water{sea::WaterType::jerlov_2, {0.1, 0.2, 0.3}}));
    look.bottom_albedo = {{0.4, 0.5, 0.6}};
    set_water(frame, look);
    EXPECT_EQ(frame.water, (sea::Water{sea::WaterType::jerlov_2, {0.4, 0.5, 0.6}}));
}

} // namespace
} // namespace seaway::client
