// SPDX-License-Identifier: Apache-2.0
// The effective scene is a scene: whatever the reader takes is written so that it reads back as the
// same waves.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include <fmt/format.h>

#include "sea/scene/scene.h"
#include "tests/support/folder.h"

namespace seaway::sea {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

const std::string root = SEAWAY_SOURCE_DIR;

std::vector<std::string> scene_files() {
    std::vector<std::string> files;
    for (const char* folder : {"/scenes", "/tests/data/odd_scenes", "/tests/data/scenes"})
        for (const auto& entry : std::filesystem::directory_iterator(root + folder))
            if (entry.path().extension() == ".toml")
                files.push_back(entry.path().string());
    return files;
}

void expect_same_waves(const SineField& a, const SineField& b) {
    ASSERT_EQ(a.waves.size(), b.waves.size());
    for (std::size_t w = 0; w < a.waves.size(); ++w) {
        EXPECT_EQ(a.waves[w].kx_radpm, b.waves[w].kx_radpm);
        EXPECT_EQ(a.waves[w].ky_radpm, b.waves[w].ky_radpm);
        EXPECT_EQ(a.waves[w].amplitude_m, b.waves[w].amplitude_m);
        EXPECT_EQ(a.waves[w].phase_rad, b.waves[w].phase_rad);
        EXPECT_EQ(a.waves[w].rate, b.waves[w].rate);
    }
    ASSERT_EQ(a.octaves.size(), b.octaves.size());
    for (std::size_t o = 0; o < a.octaves.size(); ++o) {
        EXPECT_EQ(a.octaves[o].amplitude_m, b.octaves[o].amplitude_m);
        EXPECT_EQ(*a.octaves[o].corners, *b.octaves[o].corners);
        EXPECT_EQ(a.octaves[o].rate_x, b.octaves[o].rate_x);
        EXPECT_EQ(a.octaves[o].rate_y, b.octaves[o].rate_y);
    }
}

void expect_same_sea(const Realization& a, const Realization& b) {
    EXPECT_EQ(a.choppiness.x, b.choppiness.x);
    EXPECT_EQ(a.choppiness.y, b.choppiness.y);
    EXPECT_EQ(a.loop_period_us, b.loop_period_us);
    ASSERT_EQ(a.cascades.size(), b.cascades.size());
    for (std::size_t c = 0; c < a.cascades.size(); ++c) {
        const CascadeModes &one = a.cascades[c], &other = b.cascades[c];
        EXPECT_EQ(one.spec.length_m, other.spec.length_m);
        EXPECT_EQ(one.spec.size, other.spec.size);
        EXPECT_EQ(one.depth_m, other.depth_m);
        EXPECT_TRUE(one.h0 == other.h0) << "cascade " << c;
        EXPECT_TRUE(one.rate == other.rate) << "cascade " << c;
        ASSERT_EQ(one.sines.size(), other.sines.size());
        for (std::size_t s = 0; s < one.sines.size(); ++s)
            expect_same_waves(one.sines[s], other.sines[s]);
    }
}

TEST(EffectiveScene, of_every_scene_there_is_reads_back_as_the_same_modes_bit_for_bit) {
    int read = 0;
    for (const std::string& file : scene_files()) {
        const Result<Scene> scene = read_scene(file);
        if (!scene)
            continue;
        ++read;
        const Result<Scene> again = parse_scene(to_toml(*scene), "written", "/");
        ASSERT_TRUE(again) << file << ": " << again.error().message;
        EXPECT_EQ(to_toml(*again), to_toml(*scene)) << file;
        const Result<Realization> one = realize(*scene), other = realize(*again);
        ASSERT_EQ(one.has_value(), other.has_value()) << file;
        if (one) {
            SCOPED_TRACE(file);
            expect_same_sea(*one, *other);
        }
    }
    EXPECT_GE(read, 30);
}

// Naive: the sixteen tables beside it are counted, and seventeen are written.
TEST(EffectiveScene, a_preset_of_the_sea_counts_among_its_systems) {
    std::string text = "[sea]\npreset = \"wmo:4\"\nfrom_deg = 10\n";
    const std::string swell = "[[sea.system]]\ntype = \"swell\"\nsignificant_height_m = 0.1\n"
                              "peak_period_s = 8\nfrom_deg = 0\n";
    for (int i = 0; i < scene_systems_max - 1; ++i)
        text += swell;
    const Result<Scene> most = parse_scene(text, "s.toml", "");
    ASSERT_TRUE(most) << most.error().message;
    EXPECT_EQ(most->sea.systems.size(), static_cast<std::size_t>(scene_systems_max));
    EXPECT_TRUE(parse_scene(to_toml(*most), "written", ""));
    const Result<Scene> more = parse_scene(text + swell, "s.toml", "");
    ASSERT_FALSE(more);
    EXPECT_THAT(more.error().message,
                AllOf(HasSubstr("s.toml:"), HasSubstr("sea.system"), HasSubstr("16 of them"),
                      HasSubstr("at most 15 beside a preset")));
}

// Each table is within its limit, both together are beyond that of a scene.
TEST(EffectiveScene, longer_than_a_scene_may_be_is_refused_with_its_length) {
    std::string table = "nx,ny,amplitude_m,phase_rad\n";
    for (int i = 0; i < 40'000; ++i)
        table += fmt::format("{},{},0.00012345,1.25\n", i % 200 + 1, i / 200);
    tests::folder().write("modes.csv", table);
    const auto scene_of = [&](int systems) {
        std::string text = "[sea]\n";
        for (int i = 0; i < systems; ++i)
            text += "[[sea.system]]\ntype = \"modes\"\nlength_m = 500\nfile = \"modes.csv\"\n";
        return parse_scene(text, "s.toml", tests::folder().file(""));
    };
    const Result<Scene> one = scene_of(1), two = scene_of(2);
    ASSERT_TRUE(one) << one.error().message;
    EXPECT_TRUE(parse_scene(to_toml(*one), "written", ""));
    ASSERT_FALSE(two);
    EXPECT_THAT(two.error().message,
                AllOf(HasSubstr("s.toml: sea.system: written whole"), HasSubstr("1048576")));
}

} // namespace
} // namespace seaway::sea
