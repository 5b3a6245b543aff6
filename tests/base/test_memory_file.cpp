// SPDX-License-Identifier: Apache-2.0
#include "base/memory_file.h"

#include <new>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include "tests/support/allocations.h"

namespace seaway {
namespace {

TEST(MemoryFile, holds_what_it_was_made_of) {
    std::vector<std::uint8_t> bytes(300'000);
    std::iota(bytes.begin(), bytes.end(), std::uint8_t{0});
    const std::shared_ptr<const MemoryFile> file = MemoryFile::of(bytes);
    ASSERT_TRUE(file);
    std::vector<std::uint8_t> back(bytes.size() + 1);
    EXPECT_EQ(::pread(file->handle(), back.data(), back.size(), 0),
              static_cast<ssize_t>(bytes.size()));
    back.pop_back();
    EXPECT_EQ(back, bytes);
}

// Each is a descriptor, and connections need those.
TEST(MemoryFile, there_are_so_many_at_a_time_and_no_more) {
    const std::vector<std::uint8_t> bytes(10, 7);
    std::vector<std::shared_ptr<const MemoryFile>> files;
    for (int i = 0; i < MemoryFile::open_max; ++i)
        ASSERT_TRUE(files.emplace_back(MemoryFile::of(bytes))) << i;
    EXPECT_FALSE(MemoryFile::of(bytes));
    files.pop_back();
    EXPECT_TRUE(MemoryFile::of(bytes)) << "one that has gone has left its place";
}

// Naive: what could not be made keeps its place, and after 32 of them nothing is sent from a file any more.
TEST(MemoryFile, one_for_which_there_is_no_memory_leaves_no_place_taken) {
    const std::vector<std::uint8_t> bytes(10, 7);
    for (int i = 0; i <= MemoryFile::open_max; ++i) {
        const tests::NoMemoryOnce none(0);
        EXPECT_THROW((void)MemoryFile::of(bytes), std::bad_alloc);
    }
    EXPECT_TRUE(MemoryFile::of(bytes));
}

} // namespace
} // namespace seaway
