// SPDX-License-Identifier: Apache-2.0
// Programs that are given less memory than a scene takes.
#include <gtest/gtest.h>

#include "tests/tools/program.h"

namespace seaway::testing {
namespace {

/// A scene of three tiles as large as tiles may be: 200 MB of waves and more, where 150 are given.
std::string large_scene() {
    std::string text = "[sea]\nseed = 5\n[[sea.system]]\ntype = \"wind\"\nspectrum = \"jonswap\"\n"
                       "wind_speed_10m_mps = 12\nfetch_m = 50e3\nfrom_deg = 270\n";
    for (const char* length_m : {"900.0", "130.0", "17.0"})
        text += std::string("[[cascade]]\nlength_m = ") + length_m + "\nsize = 2048\n";
    return folder().write("large.toml", text);
}

// Naive: nobody catches it, and the program dies of SIGABRT and leaves a core.
TEST(ScarceMemory, ends_a_program_by_one_line_and_its_exit_code) {
    const std::string scene = large_scene();
    const std::string given = "ulimit -c 0; ulimit -v 150000;"; // KiB
    const Output inspected = run_program("seaway-inspect", scene, {}, given);
    EXPECT_EQ(inspected.status, 2);
    EXPECT_EQ(inspected.err, "seaway-inspect: out of memory\n");
    const Output baked = run_program(
        "seaway-bake", scene + " --frames 1 --fps 1 --out " + folder().file("baked"), {}, given);
    EXPECT_EQ(baked.status, 4);
    EXPECT_EQ(baked.err, "seaway-bake: out of memory\n");
}

} // namespace
} // namespace seaway::testing
