// SPDX-License-Identifier: Apache-2.0
// StartFiles: what the network does not read again when it is asked to, and whether it says something else by now: scene and
// file of options, which are read at the start alone, and the journal's files, which each connection to NATS reads. A value.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "server/net/file_read_again.h"
#include "server/options.h"

namespace seaway::server {

class StartFiles {
  public:
    explicit StartFiles(const Options& options);

    /// As they are now: unchanged, needs_restart or next_connection, or failed where that would not find one.
    std::vector<FileReadAgain> look() const;

  private:
    struct File {
        std::string option;
        std::string path;
        ReadAgain changed; ///< outcome
        std::string hint;
        std::string lost; ///< where it cannot be read
        std::optional<std::uint64_t> fingerprint;
    };
    std::vector<File> files_;
    JournalPlace journal_;
};

} // namespace seaway::server
