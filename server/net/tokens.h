// SPDX-License-Identifier: Apache-2.0
// Tokens and other text from peers.
#pragma once

#include <string>
#include <string_view>

namespace seaway::server {

struct Tokens {
    std::string client; ///< empty: not asked for
    std::string admin;  ///< empty: there is no administrator
};

/// In a time that depends on the lengths only. Nothing equals an empty `expected`.
bool tokens_equal(std::string_view given, std::string_view expected);

/// Text from a peer for a log line: at most 120 bytes, what is not plain ASCII and quotes become
/// '?'.
std::string printable(std::string_view text);

} // namespace seaway::server
