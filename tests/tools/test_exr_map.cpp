// SPDX-License-Identifier: Apache-2.0
// What is there under a name is whole, and of what could not be written nothing is there.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <iterator>
#include <string>
#include <vector>

#include "tests/support/folder.h"
#include "tests/support/full_disk.h"
#include "tools/exr/exr_map.h"

namespace seaway::exr {
namespace {

using ::testing::HasSubstr;

std::ptrdiff_t count_of_files(const std::string& folder) {
    const std::filesystem::directory_iterator files(folder);
    return std::distance(begin(files), end(files));
}

// Naive: the piece that was written so far stays beside it.
TEST(ExrMap, a_file_that_cannot_be_written_or_put_in_its_place_leaves_nothing) {
    const std::string folder = tests::folder().file("exr");
    std::filesystem::create_directories(folder + "/taken.exr/by-a-folder");
    const std::vector<float> values{1.0f, 70000.0f};
    ExrMap map;
    map.width = 2;
    map.height = 1;
    map.channels = {{"height", values}};
    const Result<void> taken = write_exr(folder + "/taken.exr", map);
    ASSERT_FALSE(taken);
    EXPECT_THAT(taken.error().message, HasSubstr("taken.exr"));
    EXPECT_EQ(count_of_files(folder), 1) << "but for what is in the way";
    map.half = true;
    const Result<void> large = write_exr(folder + "/large.exr", map);
    ASSERT_FALSE(large);
    EXPECT_THAT(large.error().message, HasSubstr("beyond 65504"));
    EXPECT_EQ(count_of_files(folder), 1);
    map.half = false;
    EXPECT_TRUE(write_exr(folder + "/large.exr", map));
    EXPECT_EQ(count_of_files(folder), 2);
}

// The last bytes are written when the library closes the file, and it says nothing of them.
TEST(ExrMap, what_does_not_fit_on_the_disk_is_an_error_to_the_last_byte) {
    const std::string folder = tests::folder().file("full");
    std::filesystem::create_directories(folder);
    const std::vector<float> values(32 * 32, 0.5f);
    ExrMap map;
    map.width = map.height = 32;
    map.channels = {{"height", values}};
    const std::string path = folder + "/map.exr";
    ASSERT_TRUE(write_exr(path, map));
    const std::size_t whole = std::filesystem::file_size(path);
    std::filesystem::remove(path);
    for (const std::size_t missing : {std::size_t{1}, std::size_t{64}, whole}) {
        const Result<void> written =
            tests::on_full_disk(whole - missing, [&] { return write_exr(path, map); });
        ASSERT_FALSE(written) << missing;
        EXPECT_THAT(written.error().message, HasSubstr("map.exr"));
        EXPECT_EQ(count_of_files(folder), 0) << missing;
    }
    EXPECT_TRUE(write_exr(path, map));
}

} // namespace
} // namespace seaway::exr
