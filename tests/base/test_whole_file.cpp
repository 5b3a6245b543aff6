// SPDX-License-Identifier: Apache-2.0
// A file is there whole or as it was, and nothing lies beside it.
#include "base/whole_file.h"

#include <filesystem>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "tests/support/folder.h"
#include "tests/support/full_disk.h"
#include "tests/support/read_file.h"

namespace seaway {
namespace {

using ::testing::HasSubstr;

TEST(WholeFile, takes_its_name_when_it_is_whole) {
    const std::string path = tests::folder().file("whole.txt");
    ASSERT_TRUE(write_whole_file(path, "first"));
    EXPECT_EQ(tests::read_file(path), "first");
    const auto while_written = [&](const std::string& beside) -> Result<void> {
        EXPECT_TRUE(write_whole_file(beside, "second"));
        EXPECT_EQ(tests::read_file(path), "first");
        return {};
    };
    ASSERT_TRUE(write_whole_file(path, while_written));
    EXPECT_EQ(tests::read_file(path), "second");
    EXPECT_FALSE(std::filesystem::exists(path + ".part"));
}

TEST(WholeFile, is_as_it_was_when_writing_fails) {
    const std::string path = tests::folder().file("kept.txt");
    ASSERT_TRUE(write_whole_file(path, "before"));
    const std::string much(4096, 'x');
    const Result<void> full =
        tests::on_full_disk(100, [&] { return write_whole_file(path, much); });
    ASSERT_FALSE(full);
    EXPECT_THAT(full.error().message, HasSubstr("File too large"));
    const auto thrower = [](const std::string& beside) -> Result<void> {
        EXPECT_TRUE(write_whole_file(beside, "half"));
        throw std::runtime_error("in the middle");
    };
    EXPECT_THROW((void)write_whole_file(path, thrower), std::runtime_error);
    EXPECT_EQ(tests::read_file(path), "before");
    EXPECT_FALSE(std::filesystem::exists(path + ".part"));
}

// Before an hour of work. Naive: a folder that is not there is found at its end.
TEST(WholeFile, says_beforehand_whether_it_could_be_written_and_leaves_nothing) {
    const std::string path = tests::folder().file("to_come.txt");
    EXPECT_TRUE(check_whole_file(path));
    EXPECT_FALSE(std::filesystem::exists(path));
    EXPECT_FALSE(std::filesystem::exists(path + ".part"));
    ASSERT_TRUE(write_whole_file(path, "before"));
    EXPECT_TRUE(check_whole_file(path));
    EXPECT_EQ(tests::read_file(path), "before");
    EXPECT_THAT(check_whole_file(tests::folder().file("nowhere") + "/x.txt").error().message,
                HasSubstr("No such file"));
}

// Naive: who has left a link under the name of a half file gets another file written over.
TEST(WholeFile, is_not_written_through_a_link) {
    const std::string path = tests::folder().file("linked.txt"),
                      victim = tests::folder().file("victim.txt");
    ASSERT_TRUE(write_whole_file(victim, "mine"));
    std::filesystem::create_symlink(victim, path + ".part");
    ASSERT_TRUE(write_whole_file(path, "new"));
    EXPECT_EQ(tests::read_file(victim), "mine");
    EXPECT_EQ(tests::read_file(path), "new");
    EXPECT_FALSE(std::filesystem::is_symlink(path));
}

TEST(WholeFile, replaces_nothing_but_files) {
    const std::string folder = tests::folder().file("folder");
    std::filesystem::create_directories(folder);
    EXPECT_THAT(write_whole_file(folder, "x").error().message, HasSubstr("is a folder"));
    const std::string path = tests::folder().file("beside.txt");
    ASSERT_EQ(mkfifo((path + ".part").c_str(), 0600), 0);
    EXPECT_THAT(write_whole_file(path, "x").error().message,
                ::testing::AllOf(HasSubstr("beside.txt.part"), HasSubstr("is a pipe")));
    EXPECT_TRUE(std::filesystem::exists(path + ".part"));
}

} // namespace
} // namespace seaway
