// SPDX-License-Identifier: Apache-2.0
#include "protocol/token_file.h"

#include <algorithm>

#include <fmt/format.h>

#include "base/text_file.h"
#include "protocol/limits.h"

namespace seaway::protocol {

Result<std::string> read_token_file(const std::string& path) {
    constexpr std::size_t file_bytes_max = 64 * 1024; // a token and whatever is noted below it
    const Result<std::string> text = read_text_file(path, file_bytes_max);
    if (!text)
        return Error{fmt::format("{}: {}", path, text.error().message)};
    const auto wrong = [&](const std::string& why) {
        return Error{fmt::format("{}: {}", path, why)};
    };
    if (text->starts_with("\xEF\xBB\xBF"))
        return wrong("begins with a byte order mark, which would be part of the token: save it as "
                     "plain text");
    const std::string line = text->substr(0, text->find('\n'));
    const char* spaces = " \t\r";
    const std::size_t first = line.find_first_not_of(spaces);
    if (first == std::string::npos)
        return wrong("the first line is empty, a token is expected");
    const std::string token = line.substr(first, line.find_last_not_of(spaces) - first + 1);
    if (token.size() > limits::hello_text_bytes_max)
        return wrong(fmt::format("the token has {} bytes, allowed are 1 to {}", token.size(),
                                 limits::hello_text_bytes_max));
    const auto odd =
        std::find_if(token.begin(), token.end(), [](char c) { return c < ' ' || c > '~'; });
    if (odd != token.end())
        return wrong(
            fmt::format("byte {} of the token is no plain character (ASCII 32 to 126), and "
                        "could not stand in \"Authorization\"",
                        odd - token.begin() + 1));
    return token;
}

} // namespace seaway::protocol
