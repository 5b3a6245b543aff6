// SPDX-License-Identifier: Apache-2.0
// What a client trusts.
#pragma once

#include <memory>
#include <string>

#include "base/result.h"

namespace boost::asio::ssl {
class context;
}

namespace seaway::client {

/// TLS 1.2 and later; the system's certificates, and those of a file (PEM; empty: none). Errors: bad_argument.
Result<std::shared_ptr<boost::asio::ssl::context>> tls_context(const std::string& ca_file);

} // namespace seaway::client
