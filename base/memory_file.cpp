// SPDX-License-Identifier: Apache-2.0
#include "base/memory_file.h"

#include <atomic>

#include <sys/mman.h>
#include <unistd.h>

namespace seaway {
namespace {

std::atomic<int> files_open = 0;

} // namespace

std::shared_ptr<const MemoryFile> MemoryFile::of(std::span<const std::uint8_t> bytes) {
    if (++files_open > open_max) {
        --files_open;
        return nullptr;
    }
    // Before there is a handle: for this there may be no memory.
    std::shared_ptr<MemoryFile> file;
    try {
        file = std::make_shared<MemoryFile>();
    } catch (...) {
        --files_open;
        throw;
    }
    file->handle_ = ::memfd_create("seaway", MFD_CLOEXEC);
    if (file->handle_ < 0)
        return nullptr;
    while (!bytes.empty()) {
        const ssize_t written = ::write(file->handle_, bytes.data(), bytes.size());
        if (written <= 0)
            return nullptr;
        bytes = bytes.subspan(static_cast<std::size_t>(written));
    }
    return file;
}

MemoryFile::~MemoryFile() {
    if (handle_ >= 0)
        ::close(handle_);
    --files_open;
}

} // namespace seaway
