// SPDX-License-Identifier: Apache-2.0
// How many files and sockets this process may have open at a time. Of the whole process: for main().
#pragma once

#include "base/result.h"
#include "server/net/options.h"

namespace seaway::server {

/// Besides connections: listeners, scene, log, certificate, device, and MemoryFile::open_max files that keyframes are sent out of.
inline constexpr int other_files_max = 64;

/// Raises the limit on open files to what the system allows (setrlimit(2), RLIMIT_NOFILE). An error
/// where that is not enough for the connections of `options`: they would be accepted late or never.
Result<void> raise_open_files(const NetOptions& options);

} // namespace seaway::server
