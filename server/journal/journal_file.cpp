// SPDX-License-Identifier: Apache-2.0
#include "server/journal/journal_file.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <system_error>

#include <fmt/format.h>

#include "base/text_file.h"
#include "server/journal/journal.h"

namespace seaway::server {

bool passes(int system_error) {
    for (const int one : {EIO, EMFILE, ENFILE, ENOMEM, ESTALE, EROFS, EDQUOT, ENOSPC, EINTR})
        if (system_error == one)
            return true;
    return false;
}

Result<void> check_journal_header(const std::string& path) {
    std::error_code none;
    if (std::filesystem::symlink_status(path, none).type() == std::filesystem::file_type::symlink)
        return Error{"is a link: two folders with one journal would be two writers"};
    SEAWAY_TRY(check_regular_file(path));
    unsigned char header[100] = {};
    errno = 0;
    std::ifstream file(path, std::ios::binary);
    file.read(reinterpret_cast<char*>(header), sizeof header);
    const int failed = errno; // at the end of a short file there is none
    constexpr char magic[] = "SQLite format 3";
    if (file.gcount() != sizeof header && failed != 0) {
        Error error{std::error_code(failed, std::generic_category()).message()};
        if (passes(failed))
            error.kind = JournalError::unreachable;
        return error;
    }
    if (file.gcount() != sizeof header || std::memcmp(header, magic, sizeof magic) != 0)
        return Error{"is no journal of Seaway, or was cut off; it is left as it is"};
    const auto number = [&header](int at) {
        return static_cast<std::int32_t>(std::uint32_t{header[at]} << 24 | header[at + 1] << 16 |
                                         header[at + 2] << 8 | header[at + 3]);
    };
    if (number(68) != journal_application_id)
        return Error{"belongs to another program; it is left as it is"};
    if (number(60) != journal_version && number(60) != 1)
        return Error{fmt::format("was written by another version of Seaway (its layout is {}, this "
                                 "one reads {}); it is left as it is",
                                 number(60), journal_version)};
    return {};
}

Result<void> check_no_rest(const std::string& path) {
    for (const char* part : {"-wal", "-shm", "-journal"})
        if (std::error_code none; std::filesystem::symlink_status(path + part, none).type() !=
                                  std::filesystem::file_type::not_found)
            return Error{
                fmt::format("is missing, but its {} is there: bring back the journal that it "
                            "belongs to, or give another folder",
                            path.substr(path.rfind('/') + 1) + part)};
    return {};
}

} // namespace seaway::server
