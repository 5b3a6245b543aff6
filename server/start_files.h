// SPDX-License-Identifier: Apache-2.0
// StartFiles: what is read at the start alone, scene and file of options, and whether a restart would find something
// else. A value.
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

    /// As they are now: unchanged, needs_restart, or failed where a restart would not find one.
    std::vector<FileReadAgain> look() const;

  private:
    struct File {
        std::string option;
        std::string path;
        std::string hint;
        std::optional<std::uint64_t> fingerprint;
    };
    std::vector<File> files_;
};

} // namespace seaway::server
