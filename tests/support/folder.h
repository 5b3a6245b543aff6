// SPDX-License-Identifier: Apache-2.0
// Files of a test: two runs at once on one machine must not meet in them.
#pragma once

#include <atomic>
#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>

#include <unistd.h>

namespace seaway::tests {

/// A folder of this test process, removed at its end.
class Folder {
  public:
    Folder()
        : path_(std::filesystem::temp_directory_path() /
                ("seaway-tests-" + std::to_string(getpid()))) {
        std::filesystem::create_directories(path_);
    }
    ~Folder() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;

    std::string file(const std::string& name) const { return (path_ / name).string(); }
    /// A name that nobody has asked for.
    std::string fresh(const std::string& name) const {
        static std::atomic<int> count = 0;
        return file(std::to_string(++count) + "-" + name);
    }
    std::string write(const std::string& name, const std::string& text) const {
        std::ofstream(file(name), std::ios::binary) << text;
        return file(name);
    }

  private:
    std::filesystem::path path_;
};

inline Folder& folder() {
    static Folder the_folder;
    return the_folder;
}

} // namespace seaway::tests
