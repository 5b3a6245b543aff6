// SPDX-License-Identifier: Apache-2.0
#include "protocol/token_file.h"

#include <fstream>

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "protocol/limits.h"

namespace seaway::protocol {
namespace {

std::string file(const std::string& text) {
    const std::string path = ::testing::TempDir() + "token_file";
    std::ofstream(path) << text;
    return path;
}

TEST(TokenFile, gives_its_first_line_without_the_spaces_around_it) {
    EXPECT_EQ(*read_token_file(file("open sesame\nsecond line\n")), "open sesame");
    EXPECT_EQ(*read_token_file(file(" \topen sesame \r\n")), "open sesame");
    EXPECT_EQ(*read_token_file(file("x")), "x");
    const std::string longest(limits::hello_text_bytes_max, 't');
    EXPECT_EQ(*read_token_file(file(longest + "\n")), longest);
}

TEST(TokenFile, refuses_what_no_hello_could_bring) {
    for (const std::string& text : {std::string(), std::string(" \r\nsecond"),
                                    std::string(limits::hello_text_bytes_max + 1, 't')}) {
        const std::string path = file(text);
        const Result<std::string> token = read_token_file(path);
        ASSERT_FALSE(token) << text.size();
        EXPECT_EQ(token.error().message.find(path), 0u) << token.error().message;
    }
    EXPECT_NE(read_token_file(file(std::string(1025, 't'))).error().message.find("1025"),
              std::string::npos);
}

// An editor's byte order mark would be part of the token, which then nobody brings; and what an HTTP
// header cannot carry could come by Hello alone.
TEST(TokenFile, refuses_marks_and_odd_bytes_by_name) {
    for (const auto& [text, words] :
         {std::pair<std::string, const char*>{"\xEF\xBB\xBFopen sesame\n", "byte order mark"},
          {std::string("open\0sesame\n", 12), "byte 5"},
          {"open\tsesame\n", "byte 5"},
          {"\xFF\xFEo\n", "byte 1"},
          {"s\xC3\xA9same\n", "byte 2"},
          {"sesame\x7F\n", "byte 7"}}) {
        const Result<std::string> token = read_token_file(file(text));
        ASSERT_FALSE(token) << text;
        EXPECT_NE(token.error().message.find(words), std::string::npos) << token.error().message;
        EXPECT_EQ(token.error().message.find("sesame"), std::string::npos) << "no secret in it";
    }
    EXPECT_EQ(*read_token_file(file("a~ !z\n\xEF\xBB\xBF")), "a~ !z") << "the first line counts";
}

// Naive: a pipe is waited for until somebody writes, a device is read for ever.
TEST(TokenFile, never_waits_and_never_reads_without_end) {
    const std::string pipe = ::testing::TempDir() + "token_pipe";
    ASSERT_TRUE(::mkfifo(pipe.c_str(), 0600) == 0 || errno == EEXIST);
    for (const std::string& path :
         {pipe, std::string("/dev/zero"), ::testing::TempDir(), std::string("/nonexistent/token")})
        EXPECT_FALSE(read_token_file(path)) << path;
    EXPECT_FALSE(read_token_file(file("token\n" + std::string(1 << 20, 'x'))));
}

} // namespace
} // namespace seaway::protocol
