// SPDX-License-Identifier: Apache-2.0
// MemoryFile: immutable bytes in a file of memory without a name. The system sends them from there to any number of
// sockets without copying them for each.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

namespace seaway {

class MemoryFile {
  public:
    /// So many are there at a time: each is a descriptor, of which the program has 64 besides connections.
    static constexpr int open_max = 32;

    /// Null: there are `open_max`, or the system has no memory or no descriptor for one more. Copies the bytes. Any
    /// thread.
    static std::shared_ptr<const MemoryFile> of(std::span<const std::uint8_t> bytes);

    MemoryFile() = default;
    ~MemoryFile();
    MemoryFile(const MemoryFile&) = delete;
    MemoryFile& operator=(const MemoryFile&) = delete;

    int handle() const { return handle_; }

  private:
    int handle_ = -1;
};

} // namespace seaway
