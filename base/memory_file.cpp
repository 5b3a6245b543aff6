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
    const int handle = ::memfd_create("seaway", MFD_CLOEXEC);
    if (handle < 0) {
        --files_open;
        return nullptr;
    }
    auto file = std::make_shared<const MemoryFile>(handle);
    while (!bytes.empty()) {
        const ssize_t written = ::write(handle, bytes.data(), bytes.size());
        if (written <= 0)
            return nullptr;
        bytes = bytes.subspan(static_cast<std::size_t>(written));
    }
    return file;
}

MemoryFile::~MemoryFile() {
    ::close(handle_);
    --files_open;
}

} // namespace seaway
