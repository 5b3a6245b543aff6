// SPDX-License-Identifier: Apache-2.0
// What became of a file of the options when a running server was asked to read its files again: one line of the log
// for each, which names the file and never what stands in it. Values; thread-safe.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace seaway::server {

enum class ReadAgain {
    read_again,      ///< and what stands in it now holds
    unchanged,       ///< it says what it said
    failed,          ///< `why`; what it said before holds
    kept,            ///< it says something else, but another one failed, and all are taken or none
    needs_restart,   ///< it says something else, and is read at the start alone
    next_connection, ///< it says something else, and holds from the next connection on
};
std::string_view name(ReadAgain outcome);

struct FileReadAgain {
    std::string option; ///< that names it; a scene has none
    std::string path;
    ReadAgain outcome;
    std::string why = {};

    /// event=file_read_again option="--tls-key" file="key.pem" outcome=failed why="..."
    std::string line() const;
};

/// Tells one content of a file from another, and nothing of what it is; none: it cannot be read.
std::optional<std::uint64_t> fingerprint_of(const std::string& path);

} // namespace seaway::server
