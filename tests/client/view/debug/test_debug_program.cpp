// SPDX-License-Identifier: Apache-2.0
// Views of numbers as users of seaway-view ask for them.
#include <array>
#include <cstdio>
#include <fstream>
#include <iterator>

#include <gmock/gmock.h>
#include <png.h>

#include "tests/client/wave_server.h"
#include "tests/support/folder.h"

namespace seaway::client {
namespace {

using testing::HasSubstr;

struct Said {
    int code = -1;
    std::string text; ///< stdout and stderr
};

Said seaway_view(const std::string& arguments) {
    Said said;
    FILE* pipe = popen((SEAWAY_BIN_DIR "/seaway-view " + arguments + " 2>&1").c_str(), "r");
    std::array<char, 256> line{};
    while (fgets(line.data(), line.size(), pipe) != nullptr)
        said.text += line.data();
    said.code = WEXITSTATUS(pclose(pipe));
    return said;
}

std::string contents(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

class DebugProgram : public tests::WaveServer {};

TEST_F(DebugProgram, a_sheet_has_the_size_that_was_asked_for) {
    const std::string path = tests::folder().file("sheet.png");
    const Said said = seaway_view(
        net->url() + " --offscreen 640x400 --quality low --time 1000.5 --debug all --out " + path);
    ASSERT_EQ(said.code, 0) << said.text;
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    ASSERT_NE(png_image_begin_read_from_file(&image, path.c_str()), 0);
    EXPECT_EQ(image.width, 640u);
    EXPECT_EQ(image.height, 400u);
    png_image_free(&image);
}

TEST_F(DebugProgram, numbers_have_no_legend_in_them) {
    const std::string folder = tests::folder().file("numbers");
    const std::string one =
        net->url() + " --offscreen 256x144 --quality low --time 1000.5 --out " + folder;
    ASSERT_EQ(seaway_view(one + "/on.exr --debug slope").code, 0);
    ASSERT_EQ(seaway_view(one + "/off.exr --debug slope:legend=off,gain=7").code, 0);
    EXPECT_TRUE(contents(folder + "/on.exr") == contents(folder + "/off.exr"));
    ASSERT_EQ(seaway_view(one + "/on.png --debug slope").code, 0);
    ASSERT_EQ(seaway_view(one + "/off.png --debug slope:legend=off").code, 0);
    EXPECT_FALSE(contents(folder + "/on.png") == contents(folder + "/off.png"));
}

TEST_F(DebugProgram, what_this_sea_or_server_does_not_have_is_said_in_a_line) {
    const std::string one = net->url() + " --offscreen 256x144 --quality low --time 1000.5 --out " +
                            tests::folder().file("x");
    struct Row {
        std::string arguments;
        int code;
        const char* said;
    };
    const Row rows[] = {
        {one + ".png --debug slope:7", 2, "--debug slope:cascade=7: cascade 7: this sea has"},
        {one + ".png --debug map_slope:mip=10", 2, "levels 0.."},
        {one + ".exr --debug all", 2, "--debug all --out"},
        {one + ".png --debug all --bench 3", 2, "--debug all and --bench"},
        {net->url() + " --debug all", 2, "--debug all is of pictures in files"},
        {one + ".png --debug slope:mip=1", 2, "slope has no key 'mip'; its keys are cascade="},
    };
    for (const Row& row : rows) {
        const Said said = seaway_view(row.arguments);
        EXPECT_EQ(said.code, row.code) << said.text;
        EXPECT_THAT(said.text, HasSubstr(row.said));
        EXPECT_EQ(std::count(said.text.begin(), said.text.end(), '\n'), 1) << said.text;
    }
}

} // namespace
} // namespace seaway::client
