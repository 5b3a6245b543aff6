// SPDX-License-Identifier: Apache-2.0
#include "base/folder_lock.h"

#include <cerrno>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

namespace seaway {

Result<FolderLock> FolderLock::take(const std::string& folder) {
    const std::string path = folder + "/lock";
    const int file = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0640);
    if (file < 0)
        return Error{std::string("its file `lock` cannot be written: ") + std::strerror(errno)};
    FolderLock lock(file);
    if (flock(file, LOCK_EX | LOCK_NB) == 0)
        return lock;
    if (errno == EWOULDBLOCK)
        return Error{"another process works in it"};
    return Error{std::string("its file `lock` cannot be locked: ") + std::strerror(errno)};
}

FolderLock::~FolderLock() {
    if (file_ >= 0)
        close(file_);
}

FolderLock::FolderLock(FolderLock&& other) noexcept : file_(std::exchange(other.file_, -1)) {}

Result<void> sync_folder(const std::string& folder) {
    const int file = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    const bool fine = file >= 0 && fsync(file) == 0;
    const int why = errno;
    if (file >= 0)
        close(file);
    if (!fine)
        return Error{std::strerror(why)};
    return {};
}

} // namespace seaway
