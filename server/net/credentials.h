// SPDX-License-Identifier: Apache-2.0
// Credentials: what of the options is read from files, tokens and certificate together, so that a server
// can read it again while it runs. A value; thread-safe to make.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "server/net/file_read_again.h"
#include "server/net/options.h"
#include "server/net/tokens.h"

namespace boost::asio::ssl {
class context;
}

namespace seaway::server {

struct Credentials {
    Tokens tokens;
    /// Of new connections; a connection keeps what it began with. Null: plain.
    std::shared_ptr<boost::asio::ssl::context> tls;
};

/// A file, and how it went.
struct CredentialFile {
    std::string option; ///< that names it
    std::string path;
    std::optional<std::uint64_t> fingerprint = {};
    std::optional<Error> failed = {};
};

struct CredentialsRead {
    /// Or the first error.
    Result<Credentials> all;
    std::vector<CredentialFile> files; ///< each, in order of the options
};

/// TLS 1.2 and later, with forward secrecy and authenticated encryption alone (no CBC), and without
/// renegotiation. Errors name the file.
CredentialsRead read_credentials(const NetOptions& options);
inline Result<Credentials> load_credentials(const NetOptions& options) {
    return read_credentials(options).all;
}

/// What became of each where all were read again, of which these are in use.
std::vector<FileReadAgain> compare(const std::vector<CredentialFile>& in_use,
                                   const std::vector<CredentialFile>& now);

} // namespace seaway::server
