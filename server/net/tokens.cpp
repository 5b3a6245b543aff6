// SPDX-License-Identifier: Apache-2.0
#include "server/net/tokens.h"

#include <openssl/crypto.h>

namespace seaway::server {

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
