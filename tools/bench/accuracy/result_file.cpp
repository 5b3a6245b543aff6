// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/accuracy/result_file.h"

#include <filesystem>

#include <fmt/format.h>

#include "base/whole_file.h"

namespace seaway::bench {

namespace {

Result<void> of_file(const std::string& path, const Result<void>& done) {
    return done ? Result<void>()
                : Result<void>(Error{fmt::format("{}: {}", path, done.error().message)});
}

} // namespace

Result<void> check_result(const std::string& path) {
    std::error_code failed; // what is wrong with the folder is what is wrong with the file
    std::filesystem::create_directories(std::filesystem::path(path).parent_path(), failed);
    return of_file(path, check_whole_file(path));
}

Result<void> write_result(const std::string& path, std::string_view text) {
    return of_file(path, write_whole_file(path, text));
}

} // namespace seaway::bench
