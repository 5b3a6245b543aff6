// SPDX-License-Identifier: Apache-2.0
#include "base/messages.h"

#include <new>
#include <stdexcept>
#include <system_error>

#include <gtest/gtest.h>

namespace seaway {
namespace {

TEST(Printable, text_stays_as_it_is_in_any_language) {
    for (const char* text : {"", "a.toml:3: x_m = 'y' | [z]", "d\xC3\xBCne.toml", "\xE6\xB5\xB7",
                             "\xF0\x9F\x8C\x8A", "\xC2\xA0"})
        EXPECT_EQ(printable(text), text);
    EXPECT_EQ(printable("two\nlines"), "two lines");
}

TEST(Printable, what_a_terminal_would_obey_is_shown_as_numbers) {
    EXPECT_EQ(printable("\x1b[2J\a\x7f\r\t"), "\\x1b[2J\\x07\\x7f\\x0d\\x09");
    EXPECT_EQ(printable(std::string_view("a\0b", 3)), "a\\x00b");
    // The control characters of ISO 6429 in UTF-8: 0x9b alone begins what ESC [ begins.
    EXPECT_EQ(printable("\xC2\x9B\x32J"), "\\xc2\\x9b2J");
}

TEST(Printable, bytes_that_are_no_utf_8_are_shown_as_numbers) {
    EXPECT_EQ(printable("\xFF\xFE"), "\\xff\\xfe");
    EXPECT_EQ(printable("\x9B"), "\\x9b");
    EXPECT_EQ(printable("\xC0\xAF"), "\\xc0\\xaf") << "longer than it need be";
    EXPECT_EQ(printable("\xE0\x80\xAF"), "\\xe0\\x80\\xaf") << "longer than it need be";
    EXPECT_EQ(printable("\xED\xA0\x80"), "\\xed\\xa0\\x80") << "half of a pair of UTF-16";
    EXPECT_EQ(printable("\xF4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80") << "beyond the last";
    EXPECT_EQ(printable("\xC3"), "\\xc3") << "cut off";
    EXPECT_EQ(printable("\xE6\xB5"), "\\xe6\\xb5") << "cut off";
    EXPECT_EQ(printable("\xC3(\xC3\xBC"), "\\xc3(\xC3\xBC");
}

// Naive: a client that calls itself  x" administrator=true y="  is one, for who reads the log.
TEST(Printable, a_value_of_the_log_ends_where_it_ends) {
    EXPECT_EQ(in_quotes("x\" administrator=true y=\""), "\"x' administrator=true y='\"");
    EXPECT_EQ(in_quotes("two\nlines\x1b"), "\"two lines\\x1b\"");
    EXPECT_EQ(in_quotes(""), "\"\"");
    EXPECT_EQ(in_quotes(std::string(1u << 16, 'x')).size(), (1u << 16) + 2) << "whole";
}

TEST(RunMain, ends_by_the_status_of_its_body_or_by_one_line) {
    EXPECT_EQ(run_main("a", 4, [] { return 7; }), 7);
    testing::internal::CaptureStderr();
    EXPECT_EQ(run_main("a", 4, []() -> int { throw std::bad_alloc(); }), 4);
    EXPECT_EQ(run_main("b", 3, []() -> int { throw std::runtime_error("two\nlines"); }), 3);
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "a: out of memory\nb: two lines\n");
    testing::internal::CaptureStderr();
    const auto without = [](std::errc why) {
        return [why]() -> int { throw std::system_error(std::make_error_code(why)); };
    };
    EXPECT_EQ(run_main("c", 5, without(std::errc::resource_unavailable_try_again)), 5);
    EXPECT_EQ(run_main("d", 6, without(std::errc::no_space_on_device)), 6);
    EXPECT_EQ(testing::internal::GetCapturedStderr(),
              "c: " + std::string(no_further_thread) + "\nd: No space left on device\n");
}

TEST(Printable, is_not_longer_than_a_line_may_be) {
    const std::string shown = printable(std::string(1u << 20, 'x'));
    EXPECT_EQ(shown, std::string(printable_bytes_max, 'x') + " [...]");
    EXPECT_EQ(printable(std::string(printable_bytes_max, 'x')).size(), printable_bytes_max);
}

} // namespace
} // namespace seaway
