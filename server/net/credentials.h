// SPDX-License-Identifier: Apache-2.0
// Credentials: what of the options is read from files, tokens and certificate together, so that a server
// can read it again while it runs. A value; thread-safe to make.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
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

/// TLS 1.2 and later, with forward secrecy and authenticated encryption alone (no CBC), and without
/// renegotiation. Errors name the file.
Result<Credentials> load_credentials(const NetOptions& options);

/// What load_credentials() reads: the options that name a file, and the files.
struct CredentialFile {
    std::string_view option;
    std::string path;
};
std::vector<CredentialFile> credential_files(const NetOptions& options);

} // namespace seaway::server
