// SPDX-License-Identifier: Apache-2.0
// A file of this process that holds the bytes under test, in memory where the machine has such a folder.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

#include <unistd.h>

namespace seaway::tests {

/// A folder of this process; removed at its end.
inline const std::string& scratch_folder() {
    struct Scratch {
        std::string path;
        Scratch() {
            const bool memory = std::filesystem::is_directory("/dev/shm");
            path = (memory ? "/dev/shm" : "/tmp") + ("/seaway-fuzz-" + std::to_string(::getpid()));
            std::filesystem::create_directories(path);
        }
        ~Scratch() {
            std::error_code ignored;
            std::filesystem::remove_all(path, ignored);
        }
    };
    static const Scratch scratch;
    return scratch.path;
}

inline std::string scratch_file(const std::string& name, const std::uint8_t* data,
                                std::size_t size) {
    const std::string path = scratch_folder() + "/" + name;
    std::ofstream(path, std::ios::binary | std::ios::trunc)
        .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
    return path;
}

} // namespace seaway::tests
