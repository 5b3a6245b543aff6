// SPDX-License-Identifier: Apache-2.0
// Programs that are given less memory than a scene takes.
#include <string>

#include <gtest/gtest.h>

#include "base/messages.h"
#include "base/processors.h"
#include "tests/support/program.h"

namespace seaway::tests {
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
    // KiB. Stacks are small, or a machine of many processors has no memory for those of its threads.
    const std::string given = "ulimit -c 0; ulimit -s 512; ulimit -v 150000;";
    const Output inspected = run_program("seaway-inspect", scene, {}, given);
    EXPECT_EQ(inspected.status, 2);
    EXPECT_EQ(inspected.err, "seaway-inspect: out of memory\n");
    const Output baked = run_program(
        "seaway-bake", scene + " --frames 1 --fps 1 --out " + folder().file("baked"), {}, given);
    EXPECT_EQ(baked.status, 4);
    EXPECT_EQ(baked.err, "seaway-bake: out of memory\n");
}

// Naive: "Resource temporarily unavailable", of which nobody knows what to do.
TEST(ScarceMemory, threads_that_have_no_stack_are_named) {
    // The pool of a machine with one processor has no thread but its caller.
    const std::string given = "ulimit -c 0; ulimit -s 1000000; ulimit -v 900000;";
    const Output baked = run_program(
        "seaway-bake",
        SEAWAY_SOURCE_DIR "/scenes/calm.toml --device native --frames 1 --fps 1 --out " +
            folder().file("threads"),
        {}, given);
    if (usable_processors() > 1) {
        EXPECT_EQ(baked.status, 4);
        EXPECT_EQ(baked.err, "seaway-bake: " + std::string(no_further_thread) + "\n");
    } else {
        EXPECT_EQ(baked.status, 0) << baked.err;
    }
}

} // namespace
} // namespace seaway::tests
