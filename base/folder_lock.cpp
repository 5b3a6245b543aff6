// SPDX-License-Identifier: Apache-2.0
#include "base/folder_lock.h"

#include <cerrno>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

namespace seaway {
namespace {

constexpr int alone = LOCK_EX | LOCK_NB;

} // namespace

Result<FolderLock> FolderLock::take(const std::string& folder) {
    const std::string path = folder + "/lock";
    const int file = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0640);
    if (file < 0)
        return Error{std::string("its file `lock` cannot be written: ") + std::strerror(errno)};
    FolderLock lock(file, open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    const bool has_file = flock(file, alone) == 0;
    const int why = errno;
    const bool is_held = flock(lock.folder_, alone) != 0 && errno == EWOULDBLOCK;
    if (has_file && !is_held)
        return lock;
    if (is_held || why == EWOULDBLOCK)
        return Error{"another process works in it"};
    return Error{std::string("its file `lock` cannot be locked: ") + std::strerror(why)};
}

FolderLock::~FolderLock() {
    for (const int held : {file_, folder_})
        if (held >= 0)
            close(held);
}

FolderLock::FolderLock(FolderLock&& other) noexcept
    : file_(std::exchange(other.file_, -1)), folder_(std::exchange(other.folder_, -1)) {}

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
