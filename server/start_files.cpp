// SPDX-License-Identifier: Apache-2.0
#include "server/start_files.h"

namespace seaway::server {

StartFiles::StartFiles(const Options& options) {
    files_.push_back({"", options.scene,
                      "is read at the start alone; `seaway-ctl load` takes the sea over to a scene "
                      "while it runs",
                      fingerprint_of(options.scene)});
    if (!options.config.empty())
        files_.push_back({"--config", options.config, "is read at the start alone",
                          fingerprint_of(options.config)});
}

std::vector<FileReadAgain> StartFiles::look() const {
    std::vector<FileReadAgain> all;
    for (const File& file : files_) {
        const std::optional<std::uint64_t> now = fingerprint_of(file.path);
        if (!now)
            all.push_back({file.option, file.path, ReadAgain::failed,
                           "cannot be read, and a restart needs it"});
        else if (now == file.fingerprint)
            all.push_back({file.option, file.path, ReadAgain::unchanged});
        else
            all.push_back({file.option, file.path, ReadAgain::needs_restart, file.hint});
    }
    return all;
}

} // namespace seaway::server
