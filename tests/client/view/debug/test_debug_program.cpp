// SPDX-License-Identifier: Apache-2.0
// Views of numbers as users of seaway-view ask for them.
#include <gmock/gmock.h>

#include "tests/client/view/golden/picture_of_file.h"
#include "tests/client/wave_server.h"
#include "tests/support/folder.h"
#include "tests/support/program.h"
#include "tests/support/read_file.h"

namespace seaway::client {
namespace {

using testing::HasSubstr;

tests::Output seaway_view(const std::string& arguments) {
    return tests::run_program("seaway-view", arguments);
}

class DebugProgram : public tests::WaveServer {};

TEST_F(DebugProgram, a_sheet_has_the_size_that_was_asked_for) {
    const std::string path = tests::folder().file("sheet.png");
    const tests::Output ran = seaway_view(
        net->url() + " --offscreen 640x400 --quality low --time 1000.5 --debug all --out " + path);
    ASSERT_EQ(ran.status, 0) << ran.said();
    const ShownPicture sheet = tests::read_picture(path);
    EXPECT_EQ(sheet.width, 640);
    EXPECT_EQ(sheet.height, 400);
}

TEST_F(DebugProgram, numbers_have_no_legend_in_them) {
    const std::string folder = tests::folder().file("numbers");
    const std::string one =
        net->url() + " --offscreen 256x144 --quality low --time 1000.5 --out " + folder;
    ASSERT_EQ(seaway_view(one + "/on.exr --debug slope").status, 0);
    ASSERT_EQ(seaway_view(one + "/off.exr --debug slope:legend=off,gain=7").status, 0);
    EXPECT_TRUE(tests::read_file(folder + "/on.exr") == tests::read_file(folder + "/off.exr"));
    ASSERT_EQ(seaway_view(one + "/on.png --debug slope").status, 0);
    ASSERT_EQ(seaway_view(one + "/off.png --debug slope:legend=off").status, 0);
    EXPECT_FALSE(tests::read_file(folder + "/on.png") == tests::read_file(folder + "/off.png"));
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
        const tests::Output ran = seaway_view(row.arguments);
        EXPECT_EQ(ran.status, row.code) << ran.said();
        EXPECT_EQ(ran.out, "");
        EXPECT_THAT(ran.err, HasSubstr(row.said));
        EXPECT_EQ(ran.error_lines(), 1) << ran.err;
    }
}

} // namespace
} // namespace seaway::client
