// SPDX-License-Identifier: Apache-2.0
// Tokens in files: what a client brings as Hello.token, and what a server holds it against.
#pragma once

#include <string>

#include "base/result.h"

namespace seaway::protocol {

/// First line of a regular file, without spaces around it: 1 to limits::hello_text_bytes_max bytes of
/// plain ASCII, so that an HTTP header can carry it too. A byte order mark before it is refused.
/// The error is one line that begins with the path.
Result<std::string> read_token_file(const std::string& path);

} // namespace seaway::protocol
