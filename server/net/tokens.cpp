// SPDX-License-Identifier: Apache-2.0
#include "server/net/tokens.h"

#include <utility>

#include <openssl/crypto.h>

#include "protocol/token_file.h"

namespace seaway::server {

Result<Tokens> load_tokens(const NetOptions& options) {
    Tokens tokens;
    for (const auto& [file, token] : {std::pair(&options.client_token_file, &tokens.client),
                                      std::pair(&options.admin_token_file, &tokens.admin)})
        if (!file->empty()) {
            SEAWAY_TRY_LET(*token, protocol::read_token_file(*file));
        }
    return tokens;
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
