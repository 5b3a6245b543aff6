// SPDX-License-Identifier: Apache-2.0
// The eight scenes as they looked when somebody last looked at them: a server and seaway-view as their users run them,
// 256 x 144, held against the pictures in tests/data/golden by what an eye would see of the difference.
//
// After a change that is meant to be seen, look at the new pictures and keep them:
//     SEAWAY_GOLDEN=write build/dev/tests/client/view/golden/test_golden
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "tests/client/view/golden/picture_difference.h"
#include "tests/client/view/golden/picture_of_file.h"
#include "tests/support/folder.h"
#include "tests/support/program.h"
#include "tests/support/server_process.h"

namespace seaway::tests {
namespace {

struct View {
    const char* scene;
    const char* camera;
    const char* hour;
};

/// Morning to dusk, from a deck and from the air.
constexpr View views[] = {
    {"calm", "0,0,6,80,-6", "7.5"},
    {"crossing_seas", "0,0,20,135,-12", "10"},
    {"gerstner_toy", "0,0,12,215,-6", "12"},
    {"hurricane", "0,0,25,140,-8", "14"},
    {"measured_buoy", "0,0,8,250,-5", "16.5"},
    {"north_sea_gale", "0,0,12,215,-6", "15.5"},
    {"shallow_lagoon", "0,0,30,200,-35", "13"},
    {"trade_wind_swell", "0,0,400,265,-14", "17.5"},
};

std::string kept(const View& view) {
    return std::string(SEAWAY_SOURCE_DIR "/tests/data/golden/") + view.scene + ".png";
}

/// What the program says when it fails; empty if it drew.
std::string draw(const std::string& url, const View& view, const std::string& path) {
    const std::string arguments =
        url + " --offscreen 256x144 --time 100 --quality default --camera " + view.camera +
        " --time-of-day " + view.hour + " --out " + path + " --timeout 120";
    const Output ran = run_program("seaway-view", arguments);
    return ran.status == 0 ? "" : arguments + ": " + ran.said();
}

class Golden : public testing::TestWithParam<View> {};

TEST_P(Golden, a_scene_looks_as_it_did) {
    const View& view = GetParam();
    ServerProcess server({std::string("scenes/") + view.scene + ".toml", "--listen", "127.0.0.1:0",
                          "--device", "native"});
    const std::string url = server.wait_until_ready();
    ASSERT_FALSE(url.empty());
    const std::string path = folder().file(std::string(view.scene) + ".png");
    ASSERT_EQ(draw(url, view, path), "");
    const char* wish = std::getenv("SEAWAY_GOLDEN");
    if (wish && std::string_view(wish) == "write")
        std::filesystem::copy_file(path, kept(view),
                                   std::filesystem::copy_options::overwrite_existing);
    const client::ShownPicture drawn = read_picture(path), before = read_picture(kept(view));
    ASSERT_EQ(before.width, 256) << kept(view) << " cannot be read";
    ASSERT_EQ(drawn.width, before.width);
    ASSERT_EQ(drawn.height, before.height);
    const PictureDifference found = difference(drawn, before);
    EXPECT_TRUE(found.is_alike()) << "delta E " << found.mean << ", seen in "
                                  << 100 * found.seen_share << " % of blocks";
    RecordProperty("mean_delta_e", std::to_string(found.mean));
}

INSTANTIATE_TEST_SUITE_P(Scenes, Golden, testing::ValuesIn(views),
                         [](const auto& one) { return std::string(one.param.scene); });

/// The rule itself: what an eye would not see passes, what it would see does not.
class GoldenRule : public testing::Test {
  protected:
    const client::ShownPicture gale_ = read_picture(kept(views[5]));

    /// Each byte through `change(byte, x, y, channel)`.
    template <class Change>
    client::ShownPicture changed(const Change& change) const {
        client::ShownPicture other = gale_;
        for (int y = 0; y < gale_.height; ++y)
            for (int x = 0; x < gale_.width; ++x)
                for (std::size_t c = 0; c < 3; ++c) {
                    std::uint8_t& byte =
                        other.rgba[4 * static_cast<std::size_t>(y * gale_.width + x) + c];
                    byte = static_cast<std::uint8_t>(std::clamp(
                        change(static_cast<int>(byte), x, y, static_cast<int>(c)), 0, 255));
                }
        return other;
    }
    int byte_at(int x, int y, int c) const {
        return gale_
            .rgba[4 * static_cast<std::size_t>(std::clamp(y, 0, gale_.height - 1) * gale_.width +
                                               std::clamp(x, 0, gale_.width - 1)) +
                  static_cast<std::size_t>(c)];
    }
};

TEST_F(GoldenRule, passes_what_no_eye_sees) {
    ASSERT_EQ(gale_.width, 256);
    std::mt19937 random(1);
    EXPECT_TRUE(difference(gale_, gale_).is_alike());
    EXPECT_TRUE(difference(gale_, changed([&](int byte, int, int, int) {
                               return byte + static_cast<int>(random() % 9) - 4;
                           }))
                    .is_alike())
        << "noise";
    EXPECT_TRUE(difference(gale_, changed([&](int byte, int x, int y, int) {
                               return (7 * x + 13 * y) % 211 == 0 ? 255 - byte : byte;
                           }))
                    .seen_share < 1)
        << "single pixels count as little as they cover";
}

TEST_F(GoldenRule, sees_a_tint_a_shift_a_darker_sea_and_a_lost_corner) {
    ASSERT_EQ(gale_.width, 256);
    EXPECT_FALSE(difference(gale_, changed([](int byte, int, int, int c) {
                                return c == 2 ? byte + 12 : byte;
                            }))
                     .is_alike())
        << "a tint";
    EXPECT_FALSE(difference(gale_, changed([this](int, int x, int y, int c) {
                                return byte_at(x, y + 6, c);
                            }))
                     .is_alike())
        << "the horizon six pixels higher";
    EXPECT_FALSE(difference(gale_, changed([](int byte, int, int y, int) {
                                return y > 80 ? byte * 85 / 100 : byte;
                            }))
                     .is_alike())
        << "a darker sea";
    EXPECT_FALSE(difference(gale_, changed([](int byte, int x, int y, int) {
                                return x > 224 && y > 120 ? 0 : byte;
                            }))
                     .is_alike())
        << "a lost corner";
}

} // namespace
} // namespace seaway::tests
