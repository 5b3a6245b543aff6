// SPDX-License-Identifier: Apache-2.0
#include "server/start_files.h"

#include <utility>

namespace seaway::server {

StartFiles::StartFiles(const Options& options) : journal_(options.journal) {
    const std::string lost = "cannot be read, and a restart needs it";
    files_.push_back({"", options.scene, ReadAgain::needs_restart,
                      "is read at the start alone; `seaway-ctl load` takes the sea over to a scene "
                      "while it runs",
                      lost, fingerprint_of(options.scene)});
    if (!options.config.empty())
        files_.push_back({"--config", options.config, ReadAgain::needs_restart,
                          "is read at the start alone", lost, fingerprint_of(options.config)});
    for (const auto& [option, path] :
         {std::pair{"--journal-credentials", &journal_.credentials_file},
          {"--journal-tls-ca", &journal_.tls_ca_file},
          {"--journal-tls-cert", &journal_.tls_cert_file},
          {"--journal-tls-key", &journal_.tls_key_file}})
        if (!path->empty())
            files_.push_back({option, *path, ReadAgain::next_connection,
                              "is read whenever a connection to NATS is made; the one that is open "
                              "goes on",
                              "cannot be read, and the next connection to NATS needs it",
                              fingerprint_of(*path)});
}

std::vector<FileReadAgain> StartFiles::look() const {
    std::vector<FileReadAgain> all;
    const Result<void> journal = check_journal_place(journal_);
    const auto is_broken = [&journal](const File& file) {
        if (journal || file.option.empty())
            return false;
        const std::string& why = journal.error().message;
        const std::string it = file.option + " " + file.path;
        return why.find(it + ":") != std::string::npos || why.starts_with(it + " with ");
    };
    for (const File& file : files_) {
        const std::optional<std::uint64_t> now = fingerprint_of(file.path);
        if (!now)
            all.push_back({file.option, file.path, ReadAgain::failed, file.lost});
        else if (is_broken(file))
            all.push_back({file.option, file.path, ReadAgain::failed, journal.error().message});
        else if (now == file.fingerprint)
            all.push_back({file.option, file.path, ReadAgain::unchanged});
        else
            all.push_back({file.option, file.path, file.changed, file.hint});
    }
    return all;
}

} // namespace seaway::server
