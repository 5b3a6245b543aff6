// SPDX-License-Identifier: Apache-2.0
// PEM files that users name, read before a library gets them, which would wait for a pipe, or ask for a pass phrase where nobody is.
#pragma once

#include <string>

#include "base/result.h"

namespace seaway {

/// Errors as read_text_file(), of 16 MiB.
Result<std::string> read_pem_file(const std::string& path);

/// Of a private key: one that is encrypted is an error, too.
Result<std::string> read_pem_key_file(const std::string& path);

} // namespace seaway
