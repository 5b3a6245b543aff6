// SPDX-License-Identifier: Apache-2.0
#include "base/disk_room.h"

#include <filesystem>

#include <sys/statvfs.h>

namespace seaway {

bool is_disk_full(const std::string& path) {
    std::error_code unknown;
    const std::filesystem::path whole = std::filesystem::absolute(path, unknown);
    struct statvfs disk {};
    if (statvfs(whole.c_str(), &disk) != 0 && statvfs(whole.parent_path().c_str(), &disk) != 0)
        return false;
    // Some file systems count no names.
    return disk.f_bavail == 0 || (disk.f_files > 0 && disk.f_favail == 0);
}

} // namespace seaway
