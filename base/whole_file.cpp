// SPDX-License-Identifier: Apache-2.0
#include "base/whole_file.h"

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "base/text_file.h"
#include "base/undo.h"

namespace seaway {

namespace {

Result<std::string> place_beside(const std::string& path) {
    std::string beside = path + ".part";
    SEAWAY_TRY(check_replaceable(path));
    if (const Result<void> free = check_replaceable(beside); !free)
        return Error{beside + " " + free.error().message};
    std::remove(beside.c_str()); // a link would be written through
    return beside;
}

Result<void> write_bytes(const std::string& path, std::string_view bytes) {
    errno = 0;
    std::ofstream file(path, std::ios::binary);
    file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    file.close();
    if (!file)
        return Error{std::generic_category().message(errno != 0 ? errno : EIO)};
    return {};
}

} // namespace

Result<void> write_whole_file(const std::string& path,
                              const std::function<Result<void>(const std::string&)>& write) {
    SEAWAY_TRY_LET(const std::string beside, place_beside(path));
    Undo part([&] { std::remove(beside.c_str()); });
    SEAWAY_TRY(write(beside));
    std::error_code problem;
    std::filesystem::rename(beside, path, problem);
    if (problem)
        return Error{problem.message()};
    part.keep();
    return {};
}

Result<void> write_whole_file(const std::string& path, std::string_view bytes) {
    return write_whole_file(path,
                            [&](const std::string& beside) { return write_bytes(beside, bytes); });
}

Result<void> check_whole_file(const std::string& path) {
    SEAWAY_TRY_LET(const std::string beside, place_beside(path));
    const Undo part([&] { std::remove(beside.c_str()); });
    return write_bytes(beside, {});
}

} // namespace seaway
