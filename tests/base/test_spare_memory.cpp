// SPDX-License-Identifier: Apache-2.0
// What goes back to the system, of memory as drivers have it: the process's own, or a file's without a name.
#include "base/spare_memory.h"

#include <algorithm>
#include <cstddef>
#include <span>

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

namespace seaway {
namespace {

constexpr std::size_t pages = 8;

/// Some pages, each byte 7; of a file, or of the process alone.
class Mapped {
  public:
    explicit Mapped(int file = -1)
        : all_(static_cast<std::byte*>(::mmap(nullptr, pages * page(), PROT_READ | PROT_WRITE,
                                              file < 0 ? MAP_PRIVATE | MAP_ANONYMOUS : MAP_SHARED,
                                              file, 0)),
               pages * page()) {
        std::ranges::fill(all_, std::byte{7});
    }
    Mapped(const Mapped&) = delete;
    ~Mapped() { ::munmap(all_.data(), all_.size()); }

    static std::size_t page() { return static_cast<std::size_t>(::sysconf(_SC_PAGESIZE)); }
    std::span<std::byte> all() const { return all_; }
    /// How many bytes are still 7.
    std::size_t left() const {
        return static_cast<std::size_t>(std::ranges::count(all_, std::byte{7}));
    }

  private:
    const std::span<std::byte> all_;
};

TEST(SpareMemory, whole_pages_within_go_back_and_what_lies_around_them_stays) {
    const Mapped memory;
    const std::size_t page = Mapped::page();
    give_back_pages(memory.all().subspan(page / 2, 4 * page));
    EXPECT_EQ(memory.left(), (pages - 3) * page) << "of four pages' length three are whole";
    EXPECT_EQ(memory.all()[page / 2], std::byte{7});
    EXPECT_EQ(memory.all()[page], std::byte{0});
    EXPECT_EQ(memory.all()[4 * page], std::byte{7});
}

TEST(SpareMemory, less_than_a_page_stays) {
    const Mapped memory;
    const std::size_t page = Mapped::page();
    give_back_pages(memory.all().subspan(1, 2 * page - 2));
    give_back_pages({});
    EXPECT_EQ(memory.left(), pages * page);
}

// Naive: of a mapping that is shared the pages leave the process and stay in memory.
TEST(SpareMemory, what_is_a_file_without_a_name_gives_its_pages_up) {
    const int file = ::memfd_create("spare", 0);
    ASSERT_GE(file, 0);
    ASSERT_EQ(::ftruncate(file, static_cast<off_t>(pages * Mapped::page())), 0);
    const auto held_bytes = [file] {
        struct stat of {};
        EXPECT_EQ(::fstat(file, &of), 0);
        return static_cast<std::size_t>(of.st_blocks) * 512;
    };
    const Mapped memory(file);
    ASSERT_EQ(held_bytes(), pages * Mapped::page());
    give_back_pages(memory.all().first(6 * Mapped::page()));
    EXPECT_EQ(held_bytes(), 2 * Mapped::page());
    EXPECT_EQ(memory.left(), 2 * Mapped::page());
    ::close(file);
}

} // namespace
} // namespace seaway
