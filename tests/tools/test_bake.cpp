// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

#include "sea/basics/field.h"
#include "sea/surface/inverse.h"
#include "sea/waves/statistics/moments.h"
#include "tests/tools/bake_fixture.h"

namespace seaway {
namespace {

using namespace tests_of_bake;
using testing::ExrFile;
using ::testing::HasSubstr;
using tests::Output;

TEST(Bake, maps_are_the_direct_sum_at_the_nodes) {
    const std::string out = tests::folder().file("exact");
    const Output ran = run_bake("--out " + out +
                                " --frames 2 --fps 8 --start 12.34 --size 64 "
                                "--fields all");
    ASSERT_EQ(ran.status, 0) << ran.err;
    EXPECT_THAT(ran.out, HasSubstr("baked 2 frames into 4 files"));
    EXPECT_THAT(ran.out, HasSubstr("frames/s"));

    const sea::Realization all = sea::realize(small_scene()).value();
    for (int c = 0; c < 2; ++c) {
        sea::Realization one = all;
        one.cascades = {all.cascades[static_cast<std::size_t>(c)]};
        const double spacing_m = one.cascades[0].spec.spacing_m();
        const sea::DirectSum sum(std::make_shared<const sea::Realization>(one));
        for (int frame = 0; frame < 2; ++frame) {
            ExrFile file(out + "/cascade" + std::to_string(c) + ".0000" + std::to_string(frame) +
                         ".exr");
            ASSERT_EQ(file.size(), 64);
            const sea::DirectSum::Moment now = sum.at_time(12'340'000 + frame * 125'000);
            // 1e-5 of four times the rms of a field, as for heights 1e-5 Hs.
            for (const sea::FieldInfo& field : sea::field_table) {
                if (field.field == sea::Field::foam)
                    continue;
                const std::vector<float> map = file.values(std::string(field.name));
                double worst = 0, squares = 0;
                for (int i = 0; i < 200; ++i) {
                    const int x = (i * 37) % 64, y = (i * 53 + i / 7) % 64;
                    const sea::LagrangianPoint p = now.at(x * spacing_m, y * spacing_m);
                    const double exact = sea::is_linear(field.field)
                                             ? sea::value_of(p, field.field)
                                             : sea::jacobian(p, all.choppiness);
                    const auto baked =
                        static_cast<double>(map[static_cast<std::size_t>(y * 64 + x)]);
                    worst = std::max(worst, std::abs(baked - exact));
                    squares += exact * exact;
                }
                EXPECT_LE(worst, 1e-5 * 4 * std::sqrt(squares / 200))
                    << field.name << " of cascade " << c << ", frame " << frame;
            }
        }
    }
}

TEST(Bake, attributes_say_what_one_has_to_know) {
    const std::string out = tests::folder().file("attributes");
    ASSERT_EQ(run_bake("--out " + out +
                       " --frames 2 --fps 8 --start 100 --size 64 "
                       "--fields height,foam --compression zip")
                  .status,
              0);
    ExrFile file(out + "/cascade1.00001.exr");
    EXPECT_TRUE(file.has("height"));
    EXPECT_TRUE(file.has("foam"));
    EXPECT_FALSE(file.has("slope_x"));
    EXPECT_FALSE(file.has("strain_xx")); // foam's inputs are not asked for
    EXPECT_EQ(file.number("seaway.length_m"), 83.0);
    EXPECT_EQ(file.number("seaway.cascade"), 1.0);
    EXPECT_EQ(file.number("seaway.frame"), 1.0);
    EXPECT_EQ(file.number("seaway.time_s"), 100.125);
    EXPECT_EQ(file.text("seaway.time_us"), "100125000");
    EXPECT_EQ(file.number("seaway.tick_s"), 0.125);
    EXPECT_EQ(file.number("seaway.choppiness_x"), 1.2);
    EXPECT_EQ(file.number("seaway.choppiness_y"), 0.8);
    EXPECT_EQ(file.text("software"), "seaway-bake " SEAWAY_VERSION);
    EXPECT_EQ(file.text("seaway.scene"), tests::folder().file("bake.toml"));
    EXPECT_EQ(file.text("seaway.rows"), "south to north");
    // The text in the file makes the same sea again.
    const sea::Scene scene = sea::parse_scene(file.text("seaway.scene_toml"), "exr", ".").value();
    EXPECT_EQ(scene.cascades[1].size, 64);
    const sea::Realization again = sea::realize(scene).value();
    EXPECT_EQ(again.cascades[1].h0, sea::realize(small_scene()).value().cascades[1].h0);
    double variance = 0;
    for (const sea::CascadeModes& modes : again.cascades)
        for (const std::complex<double>& h0 : modes.h0)
            variance += 2 * std::norm(h0);
    EXPECT_NEAR(file.number("seaway.hs_m"), 4 * std::sqrt(variance), 1e-9);

    double mean = 0;
    for (const float ratio : file.values("foam")) {
        ASSERT_TRUE(std::isfinite(ratio) && ratio >= 0);
        mean += static_cast<double>(ratio) / (64 * 64);
    }
    EXPECT_GT(file.number("seaway.foam_mean"), 0.0);
    EXPECT_NEAR(mean, 1.0, 0.5); // one small tile at one moment holds a dozen crests
}

TEST(Bake, attributes_tell_the_sea_that_was_asked_for_from_the_one_that_was_drawn) {
    const std::string out = tests::folder().file("statistics");
    ASSERT_EQ(run_bake("--out " + out + " --frames 1 --fps 1 --size 64 --fields height").status, 0);
    ExrFile file(out + "/cascade0.00000.exr");
    const sea::Scene scene = small_scene();
    const sea::SeaSummary summary = sea::summarize(scene.sea, sea::realize(scene).value());
    EXPECT_EQ(file.number("seaway.requested_hs_m"), summary.requested.significant_height_m);
    EXPECT_EQ(file.number("seaway.requested_tp_s"), summary.requested.peak_period_s);
    EXPECT_EQ(file.number("seaway.hs_m"), summary.realised.significant_height_m);
    EXPECT_EQ(file.number("seaway.tp_s"), summary.realised.peak_period_s);
    EXPECT_EQ(file.number("seaway.tz_s"), summary.realised.zero_crossing_period_s);
    EXPECT_EQ(file.number("seaway.tm01_s"), summary.realised.mean_period_s);
    // From east anticlockwise, where waves go, to a bearing, where they come from.
    const auto from_deg = [](const sea::SeaStatistics& s) {
        return std::fmod(270 - s.mean_towards_rad * 180 / sea::pi + 720, 360.0);
    };
    EXPECT_NEAR(file.number("seaway.mean_from_deg"), from_deg(summary.realised), 1e-9);
    EXPECT_GT(std::abs(from_deg(summary.realised) - from_deg(summary.requested)), 0.01);
    EXPECT_NE(summary.requested.peak_period_s, summary.realised.peak_period_s) << "told apart";
}

// A frame of 1/24 s is no whole number of microseconds: what it is rounded by must not add up.
TEST(Bake, frames_lie_at_their_times_to_the_microsecond_without_drift) {
    const std::string out = tests::folder().file("times");
    const std::string same = " --frames 25 --fps 24 --start 100 --size 64 --fields height";
    ASSERT_EQ(run_bake("--out " + out + same).status, 0);
    for (const auto& [frame, time_us] : {std::pair("01", "100041667"), {"24", "101000000"}})
        EXPECT_EQ(ExrFile(out + "/cascade1.000" + frame + ".exr").text("seaway.time_us"), time_us);
}

/// The whole sea of small_scene() at a time.
TEST(Bake, summed_tile_is_the_sea_of_all_cascades) {
    const std::string out = tests::folder().file("summed");
    ASSERT_EQ(run_bake("--out " + out +
                       " --frames 1 --fps 8 --start 31 --size 64 --summed "
                       "--fields height,displacement_x,slope_y,jacobian,foam")
                  .status,
              0);
    ExrFile file(out + "/sea.00000.exr");
    ASSERT_EQ(file.size(), 64);
    EXPECT_EQ(file.number("seaway.length_m"), 401.0);
    EXPECT_EQ(file.text("seaway.repeats"), "no"); // 401 is no multiple of 83
    const sea::DirectSum sum = small_sea();
    const sea::DirectSum::Moment now = sum.at_time(31'000'000);
    const std::vector<float> height = file.values("height"), east = file.values("displacement_x"),
                             slope = file.values("slope_y"), jacobian = file.values("jacobian");
    // Splines miss 1 % of the finest waves of a tile of 83 m sampled by 64 points, which hold a
    // few per cent of the slope: 2e-3 of Hs, and ten times that where derivatives count.
    double squares = 0;
    for (const float h : height)
        squares += static_cast<double>(h) * static_cast<double>(h);
    const double hs = 4 * std::sqrt(squares / (64 * 64));
    ASSERT_GT(hs, 1.0);
    for (int i = 0; i < 300; ++i) {
        const int x = (i * 37) % 64, y = (i * 53 + i / 7) % 64;
        const auto node = static_cast<std::size_t>(y * 64 + x);
        const sea::LagrangianPoint p = now.at(x * 401.0 / 64, y * 401.0 / 64);
        EXPECT_NEAR(height[node], p.height, 2e-3 * hs);
        EXPECT_NEAR(east[node], p.displacement_x, 2e-3 * hs);
        EXPECT_NEAR(slope[node], p.slope_y, 0.02);
        EXPECT_NEAR(jacobian[node], sea::jacobian(p, {1.2, 0.8}), 0.04);
    }
    double mean = 0;
    for (const float coverage : file.values("foam")) {
        ASSERT_TRUE(coverage >= 0 && coverage <= 1);
        mean += static_cast<double>(coverage) / (64 * 64);
    }
    EXPECT_GT(mean, 0.0);
}

TEST(Bake, summed_tile_is_as_fine_as_its_finest_cascade) {
    for (const auto& [first, second] : {std::pair{64, 128}, std::pair{128, 64}}) {
        const std::string scene = tests::folder().write(
            "sizes.toml", "[sea]\n[[cascade]]\nlength_m = 401\nsize = " + std::to_string(first) +
                              "\n[[cascade]]\nlength_m = 83\nsize = " + std::to_string(second) +
                              "\n");
        const std::string out = tests::folder().file("sizes");
        const Output ran = tests::run_program("seaway-bake", scene + " --out " + out +
                                                                 " --frames 1 --fps 1 --summed "
                                                                 "--fields height");
        ASSERT_EQ(ran.status, 0) << ran.err;
        EXPECT_EQ(ExrFile(out + "/sea.00000.exr").size(), 128) << first << ", then " << second;
    }
}

TEST(Bake, rgb_is_where_a_point_goes_in_the_frame_of_the_reader) {
    const std::string names = tests::folder().file("names");
    const std::string rgb = tests::folder().file("rgb");
    const std::string same = " --frames 1 --fps 24 --size 64 ";
    ASSERT_EQ(
        run_bake("--out " + names + same + "--fields height,displacement_x,displacement_y,foam")
            .status,
        0);
    ASSERT_EQ(
        run_bake("--out " + rgb + same + "--channels rgb --up y --top north --fields height,foam")
            .status,
        0);
    ExrFile named(names + "/cascade1.00000.exr"), moved(rgb + "/cascade1.00000.exr");
    EXPECT_FALSE(moved.has("height"));
    EXPECT_EQ(moved.text("seaway.axes"), "east, up, south");
    EXPECT_EQ(moved.text("seaway.rows"), "north to south");
    const std::vector<float> height = named.values("height"), dx = named.values("displacement_x"),
                             dy = named.values("displacement_y"), foam = named.values("foam");
    const std::vector<float> r = moved.values("R"), g = moved.values("G"), b = moved.values("B"),
                             a = moved.values("A");
    for (std::size_t y = 0; y < 64; ++y)
        for (std::size_t x = 0; x < 64; ++x) {
            const std::size_t from = y * 64 + x, to = (63 - y) * 64 + x;
            ASSERT_EQ(r[to], 1.2f * dx[from]);
            ASSERT_EQ(g[to], height[from]);
            ASSERT_EQ(b[to], -(0.8f * dy[from]));
            ASSERT_EQ(a[to], foam[from]);
        }
}

TEST(Bake, the_jacobian_of_the_summed_sea_is_the_determinant_of_its_strains) {
    const std::string out = tests::folder().file("determinant");
    ASSERT_EQ(run_bake("--out " + out +
                       " --frames 1 --fps 8 --start 31 --size 64 --summed "
                       "--fields strain_xx,strain_yy,strain_xy,jacobian")
                  .status,
              0);
    ExrFile file(out + "/sea.00000.exr");
    const std::vector<float> xx = file.values("strain_xx"), yy = file.values("strain_yy"),
                             xy = file.values("strain_xy"), jacobian = file.values("jacobian");
    double largest = 0;
    for (std::size_t i = 0; i < xx.size(); ++i) {
        ASSERT_NEAR(jacobian[i], (1 + 1.2 * xx[i]) * (1 + 0.8 * yy[i]) - 1.2 * 0.8 * xy[i] * xy[i],
                    1e-6);
        largest = std::max(largest, std::abs(static_cast<double>(xy[i])));
    }
    EXPECT_GT(0.4 * largest * largest, 1e-4) << "the last term is seen";
}

// North first, in 16 bits as in 32.
TEST(Bake, half_maps_are_turned_as_others_are) {
    const std::string south = tests::folder().file("south"), north = tests::folder().file("north");
    const std::string same = " --frames 1 --fps 24 --size 64 --fields height --half --out ";
    ASSERT_EQ(run_bake("--top south" + same + south).status, 0);
    ASSERT_EQ(run_bake("--top north" + same + north).status, 0);
    const std::vector<float> a = ExrFile(south + "/cascade0.00000.exr").values("height"),
                             b = ExrFile(north + "/cascade0.00000.exr").values("height");
    for (std::size_t y = 0; y < 64; ++y)
        for (std::size_t x = 0; x < 64; ++x)
            ASSERT_EQ(a[y * 64 + x], b[(63 - y) * 64 + x]);
    EXPECT_NE(a[0], b[0]);
}

TEST(Bake, what_is_said_of_files_is_what_lies_there) {
    const std::string out = tests::folder().file("counted");
    const Output ran = run_bake("--out " + out + " --frames 3 --fps 24 --size 64 --mesh ply");
    ASSERT_EQ(ran.status, 0) << ran.err;
    int files = 0;
    double bytes = 0;
    for (const auto& entry : std::filesystem::directory_iterator(out)) {
        ++files;
        bytes += static_cast<double>(entry.file_size());
    }
    EXPECT_EQ(files, 3 * 2 * 2) << "maps and a mesh of each cascade and frame";
    int frames = 0, said = 0;
    double megabytes = 0;
    ASSERT_EQ(std::sscanf(ran.out.c_str(), "baked %d frames into %d files, %lf MB", &frames, &said,
                          &megabytes),
              3)
        << ran.out;
    EXPECT_EQ(frames, 3);
    EXPECT_EQ(said, files);
    EXPECT_NEAR(megabytes, 1e-6 * bytes, 0.051);
}

// Losslessly, but for the bytes: a file says how it is packed.
TEST(Bake, every_packing_is_the_one_that_was_asked_for) {
    const std::pair<const char*, Imf::Compression> packings[] = {{"none", Imf::NO_COMPRESSION},
                                                                 {"rle", Imf::RLE_COMPRESSION},
                                                                 {"zip", Imf::ZIP_COMPRESSION},
                                                                 {"piz", Imf::PIZ_COMPRESSION}};
    std::vector<float> first;
    for (const auto& [name, packing] : packings) {
        const std::string out = tests::folder().file(std::string("packed_") + name);
        ASSERT_EQ(run_bake("--out " + out + " --frames 1 --fps 24 --size 64 --fields height " +
                           "--compression " + name)
                      .status,
                  0);
        ExrFile file(out + "/cascade0.00000.exr");
        EXPECT_EQ(file.packing(), packing) << name;
        if (first.empty())
            first = file.values("height");
        EXPECT_EQ(file.values("height"), first) << name;
    }
}

TEST(Bake, half_keeps_eleven_bits) {
    const std::string floats = tests::folder().file("floats");
    const std::string halves = tests::folder().file("halves");
    const std::string same = " --frames 1 --fps 24 --size 64 --fields height";
    ASSERT_EQ(run_bake("--out " + floats + same).status, 0);
    ASSERT_EQ(run_bake("--half --out " + halves + same).status, 0);
    ExrFile exact(floats + "/cascade0.00000.exr");
    ExrFile rounded(halves + "/cascade0.00000.exr");
    EXPECT_EQ(exact.type("height"), Imf::FLOAT);
    EXPECT_EQ(rounded.type("height"), Imf::HALF);
    const std::vector<float> a = exact.values("height"), b = rounded.values("height");
    for (std::size_t i = 0; i < a.size(); ++i)
        ASSERT_NEAR(b[i], a[i], std::abs(a[i]) * 0x1p-11f + 1e-7f);
}

/// Ended by a signal as soon as it has made its first file; after a minute in any case. `timeout` sends it twice.
Output signalled(const char* signal, const std::string& out, const std::string& more) {
    const std::string scene = tests::folder().write("bake.toml", scene_text);
    const std::string kill = "sh -c 'timeout -s KILL 60 \"$@\" & while [ ! -e " + out +
                             "/cascade0.00000.exr ] && kill -0 $!; do sleep 0.02; done; kill -" +
                             signal + " $!; wait $!' sh";
    return tests::run_program(
        "seaway-bake", scene + " --out " + out + " --frames 100000 --fps 24 " + more, {}, kill);
}

// Naive: it ends in the middle of a file, whose piece lies there for good.
TEST(Bake, a_signal_ends_it_between_two_files) {
    for (const auto& [signal, number, field] :
         {std::tuple{"INT", SIGINT, "height"}, {"TERM", SIGTERM, "foam"}}) {
        const std::string out = tests::folder().file(std::string("signalled_") + signal);
        const Output ran =
            signalled(signal, out, std::string("--compression zip --fields ") + field);
        EXPECT_EQ(ran.status, 128 + number) << ran.err;
        EXPECT_THAT(ran.err, HasSubstr("seaway-bake: stopped by a signal: "));
        EXPECT_THAT(ran.err, HasSubstr(" of 100000 frames are whole; --first "));
        int whole_frames = -1, first = -1, frames = -1;
        EXPECT_EQ(std::sscanf(ran.err.c_str(),
                              "seaway-bake: stopped by a signal: %d of 100000 frames are whole; "
                              "--first %d --frames %d goes on",
                              &whole_frames, &first, &frames),
                  3);
        EXPECT_EQ(first, whole_frames) << "the frame after them";
        EXPECT_EQ(first + frames, 100000) << "as far as it was asked to";
        for (const auto& entry : std::filesystem::directory_iterator(out)) {
            ASSERT_EQ(entry.path().extension(), ".exr") << entry.path();
            ExrFile whole(entry.path().string());
            EXPECT_EQ(whole.values(field).size(), 256u * 256u);
        }
    }
}

TEST(Bake, mistakes_are_one_helpful_line_and_a_code) {
    const std::string out = "--out " + tests::folder().file("none") + " ";
    const auto refuses = [](const Output& ran, int status, const std::string& part) {
        EXPECT_EQ(ran.status, status) << ran.err;
        EXPECT_TRUE(ran.error_lines() == 1 && ran.err.find(part) != ran.err.npos) << ran.err;
    };
    refuses(run_bake(out + "--frames 1 --fps 24 --fields height,slop_x"), 2, "slop_x");
    refuses(run_bake(out + "--frames 1 --fps 24 --size 100"), 2, "--size");
    refuses(run_bake(out + "--frames 1 --fps 24 --compression jpeg"), 2, "jpeg");
    refuses(run_bake(out + "--frames 1 --fps 24 --up x"), 2, "--up");
    refuses(run_bake(out + "--frames 1 --fps 24 --up y"), 2, "--up y is of");
    refuses(run_bake(out + "--frames 1 --fps 24 --channels rgb --fields height,slope_x"), 2,
            "no slope_x of --fields");
    refuses(run_bake(out + "--frames 1 --fps 24 --mesh stl"), 2, "stl");
    refuses(run_bake(out + "--frames 0 --fps 24"), 2, "--frames 0");
    for (const char* rate :
         {"0", "-1", "nan", "1000.5", "24000/0", "24000/1001.5", "24/", "2000001/2001"})
        refuses(run_bake(out + "--frames 1 --fps " + rate), 2,
                std::string("--fps ") + rate + ": above 0");
    refuses(run_bake(out + "--frames 2 --first 999999 --fps 24"), 2,
            "--first 999999 --frames 2: frames are numbered 0 .. 999999");
    refuses(run_bake(out + "--frames 2 --first -1 --fps 24"), 2, "--first -1");
    refuses(run_bake(out + "--frames 1 --fps 24 --size 2048"), 2, "size 2048; the native device");
    // The last frame may lie at the end of time, and not beyond it.
    const std::string late = "--fps 1 --size 64 --fields height --start 999999999 --frames ";
    EXPECT_EQ(run_bake("--out " + tests::folder().file("late") + " " + late + "2").status, 0);
    refuses(run_bake(out + late + "3"), 2, "frames from 999999999 to 1000000001 s");
    // Frames beyond all times, and even beyond what counts them.
    for (const char* times : {"1e-9", "1e-12", "1e-300", "1 --start 1e9", "1 --start nan"})
        refuses(run_bake(out + "--frames 3 --size 64 --fps " + times), 2, "-1e+09 .. 1e+09");
    refuses(run_bake("--out /dev/null/maps --frames 1 --fps 24 --size 64"), 4, "/dev/null/maps");
    refuses(run_bake(out + "--frames 1 --fps 24 --device no-such-device"), 3, "no-such-device");
    const std::string changing = tests::folder().write(
        "changing.toml", scene_text + "[[weather]]\nat_s = 3600\nset = { sea.depth_m = 20 }\n");
    refuses(tests::run_program("seaway-bake", changing + " " + out + "--frames 1 --fps 24"), 2,
            "[[weather]]");
    const std::string missing = "missing.toml " + out + "--frames 1 --fps 24";
    refuses(tests::run_program("seaway-bake", missing), 2, "missing.toml");
    EXPECT_FALSE(std::filesystem::exists(tests::folder().file("none") + "/cascade0.00000.exr"));
}

} // namespace
} // namespace seaway
