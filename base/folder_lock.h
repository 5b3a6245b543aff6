// SPDX-License-Identifier: Apache-2.0
// A folder that one process at a time works in. The lock ends with the process, however it ends.
#pragma once

#include <string>

#include "base/result.h"

namespace seaway {

class FolderLock {
  public:
    /// Locks `folder`/lock, which is made where it is missing. The error says why not, without the path: that
    /// another process holds it, or that the folder cannot be written.
    static Result<FolderLock> take(const std::string& folder);

    ~FolderLock();
    FolderLock(FolderLock&& other) noexcept;
    FolderLock& operator=(FolderLock&&) = delete;
    FolderLock(const FolderLock&) = delete;
    FolderLock& operator=(const FolderLock&) = delete;

  private:
    explicit FolderLock(int file) : file_(file) {}
    int file_;
};

/// What was made, renamed or removed in the folder outlives a loss of power. The error says why not.
Result<void> sync_folder(const std::string& folder);

} // namespace seaway
