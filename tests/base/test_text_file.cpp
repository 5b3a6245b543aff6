// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include <sys/stat.h>

#include "base/csv_table.h"
#include "base/text_file.h"
#include "tests/support/folder.h"

namespace seaway {
namespace {

using ::testing::HasSubstr;

std::string path(const std::string& name) {
    return tests::folder().file(name);
}

TEST(TextFile, is_read_whole_up_to_its_limit_and_refused_one_byte_beyond) {
    const std::string text(200'000, 'x'); // more than one piece
    const std::string file = tests::folder().write("a", text);
    EXPECT_EQ(*read_text_file(file, text.size()), text);
    EXPECT_THAT(read_text_file(file, text.size() - 1).error().message,
                HasSubstr("more than 199999 bytes"));
    EXPECT_EQ(*read_text_file(tests::folder().write("b", ""), 0), "");
}

// A pipe would wait for a writer, /dev/zero would fill the memory before its size is looked at.
TEST(TextFile, what_is_no_regular_file_is_an_error_at_once) {
    const std::string pipe = tests::folder().fresh("pipe");
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    for (const std::string& odd : {pipe, std::string("/dev/zero")}) {
        EXPECT_THAT(read_text_file(odd, 1000).error().message, HasSubstr("a pipe, a device"));
        EXPECT_THAT(check_regular_file(odd).error().message, HasSubstr("a pipe, a device"));
    }
    EXPECT_THAT(read_text_file(path("."), 1000).error().message, HasSubstr("folder"));
    EXPECT_THAT(read_text_file(path("none"), 1000).error().message, HasSubstr("no such file"));
    EXPECT_THAT(check_regular_file(path("none")).error().message, HasSubstr("no such file"));
    EXPECT_TRUE(check_regular_file(tests::folder().write("a", "x")));
}

TEST(TextFile, what_is_written_out_is_there_and_what_is_lost_is_an_error) {
    std::FILE* full = std::fopen("/dev/full", "w");
    ASSERT_NE(full, nullptr);
    const Result<void> lost = write_out(full, "x");
    std::fclose(full);
    ASSERT_FALSE(lost);
    EXPECT_TRUE(lost.error().is(OutputError::lost));
    std::FILE* file = std::fopen(path("out").c_str(), "w");
    ASSERT_NE(file, nullptr);
    EXPECT_TRUE(write_out(file, "some words"));
    EXPECT_EQ(*read_text_file(path("out"), 100), "some words") << "before it is closed";
    std::fclose(file);
}

TEST(CsvTable, a_first_line_of_numbers_is_a_missing_header) {
    EXPECT_THAT(parse_csv("# note\n1,2,3\n4,5,6\n", "t", 10).error().message,
                HasSubstr("t:2: no header"));
    EXPECT_TRUE(parse_csv("a,2\n4,5\n", "t", 10)); // an odd title, but a title
}

TEST(CsvTable, may_begin_with_the_mark_of_utf_8) {
    const auto table = parse_csv("\xef\xbb\xbf# a note\na,b\n1,2\n", "t", 10);
    ASSERT_TRUE(table) << table.error().message;
    EXPECT_EQ(table->columns.front(), "a");
}

TEST(CsvTable, holds_as_many_rows_as_it_may_and_not_one_more) {
    const std::string text = "a,b\n1,2\n# a note is no row\n\n3,4\n5,6\n";
    EXPECT_EQ(parse_csv(text, "t", 3)->rows.size(), 3u);
    const Result<CsvTable> beyond = parse_csv(text, "t", 2);
    ASSERT_FALSE(beyond);
    EXPECT_THAT(beyond.error().message, HasSubstr("t:6: more than 2 rows"));
}

TEST(CsvTable, an_error_of_a_row_names_its_line_of_the_text_notes_and_blank_lines_counted) {
    const Result<CsvTable> table = parse_csv("# note\na,b\n\n1,2\n# note\n3,4\n", "t", 10);
    ASSERT_TRUE(table);
    EXPECT_EQ(table->error(0, "why").message, "t:4: why");
    EXPECT_EQ(table->error(1, "why").message, "t:6: why");
}

TEST(CsvTable, what_is_no_number_is_named_by_line_column_and_value) {
    for (const auto& [row, says] :
         {std::pair("x,2,3", "t:3: a = 'x'"), std::pair("1,nan,3", "t:3: b = 'nan'"),
          std::pair("1,2,", "t:3: c = ''"), std::pair("1,2,0x3", "t:3: c = '0x3'"),
          std::pair("1,2", "t:3: 2 fields, but the header names 3")})
        EXPECT_THAT(parse_csv(std::string("a,b,c\n7,8,9\n") + row + "\n", "t", 10).error().message,
                    HasSubstr(says));
    const Result<CsvTable> table = parse_csv("a, b ,c\r\n1,-2.5,3e2\r\n", "t", 10);
    ASSERT_TRUE(table);
    EXPECT_EQ(table->rows, (std::vector<std::vector<double>>{{1, -2.5, 300}}));
    EXPECT_EQ(table->column("b"), 1u);
    EXPECT_EQ(table->column("c"), 2u);
    EXPECT_EQ(table->column("d"), std::nullopt);
}

TEST(CsvTable, numbers_below_the_smallest_normal_are_zero) {
    const Result<CsvTable> table = parse_csv("a,b,c\n1e-310,-0,1e-300\n", "t", 10);
    ASSERT_TRUE(table);
    EXPECT_EQ(table->rows[0][0], 0);
    EXPECT_FALSE(std::signbit(table->rows[0][1]));
    EXPECT_EQ(table->rows[0][2], 1e-300);
}

TEST(TextFile, a_path_through_a_file_leads_to_no_file) {
    const std::string through = tests::folder().write("plain", "x") + "/below";
    EXPECT_THAT(read_text_file(through, 10).error().message, HasSubstr("no such file"));
    EXPECT_THAT(check_regular_file(through).error().message, HasSubstr("no such file"));
}

} // namespace
} // namespace seaway
