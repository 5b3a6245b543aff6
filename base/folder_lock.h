// SPDX-License-Identifier: Apache-2.0
// A folder that one process at a time works in. The lock ends with the process, however it ends.
#pragma once

#include <string>

#include "base/result.h"

namespace seaway {

class FolderLock {
  public:
    /// Locks `folder`/lock, which is made where it is missing, and the folder itself, so that nobody else comes in
    /// where the file was removed; some network file systems lock no folders. The error says why not, without the
    /// path: that another process holds it, or that the folder cannot be written.
    static Result<FolderLock> take(const std::string& folder);

    ~FolderLock();
    FolderLock(FolderLock&& other) noexcept;
    FolderLock& operator=(FolderLock&&) = delete;
    FolderLock(const FolderLock&) = delete;
    FolderLock& operator=(const FolderLock&) = delete;

  private:
    FolderLock(int file, int folder) : file_(file), folder_(folder) {}
    int file_;
    int folder_;
};

/// What was made, renamed or removed in the folder outlives a loss of power. The error says why not.
Result<void> sync_folder(const std::string& folder);

} // namespace seaway
