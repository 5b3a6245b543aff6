// SPDX-License-Identifier: Apache-2.0
#include "server/net/tokens.h"

#include <fstream>

#include <fmt/format.h>
#include <openssl/crypto.h>

namespace seaway::server {

Result<std::string> read_token(const std::string& file) {
    std::ifstream in(file);
    std::string line;
    if (!in || !std::getline(in, line))
        return Error{fmt::format("{}: no token can be read from this file", file)};
    const char* spaces = " \t\r";
    const std::size_t first = line.find_first_not_of(spaces);
    if (first == std::string::npos)
        return Error{fmt::format("{}: the first line is empty, a token is expected", file)};
    return line.substr(first, line.find_last_not_of(spaces) - first + 1);
}

bool tokens_equal(std::string_view given, std::string_view expected) {
    return !expected.empty() && given.size() == expected.size() &&
           CRYPTO_memcmp(given.data(), expected.data(), given.size()) == 0;
}

std::string printable(std::string_view text) {
    std::string out(text.substr(0, 120));
    for (char& c : out)
        if (c < ' ' || c > '~' || c == '"')
            c = '?';
    return out;
}

} // namespace seaway::server
