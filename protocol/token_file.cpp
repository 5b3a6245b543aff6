// SPDX-License-Identifier: Apache-2.0
#include "protocol/token_file.h"

#include <fmt/format.h>

#include "base/text_file.h"
#include "protocol/limits.h"

namespace seaway::protocol {

Result<std::string> read_token_file(const std::string& path) {
    constexpr std::size_t file_bytes_max = 64 * 1024; // a token and whatever is noted below it
    const Result<std::string> text = read_text_file(path, file_bytes_max);
    if (!text)
        return Error{fmt::format("{}: {}", path, text.error().message)};
    const std::string line = text->substr(0, text->find('\n'));
    const char* spaces = " \t\r";
    const std::size_t first = line.find_first_not_of(spaces);
    if (first == std::string::npos)
        return Error{fmt::format("{}: the first line is empty, a token is expected", path)};
    const std::string token = line.substr(first, line.find_last_not_of(spaces) - first + 1);
    if (token.size() > limits::hello_text_bytes_max)
        return Error{fmt::format("{}: the token has {} bytes, allowed are 1 to {}", path,
                                 token.size(), limits::hello_text_bytes_max)};
    return token;
}

} // namespace seaway::protocol
