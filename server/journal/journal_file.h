// SPDX-License-Identifier: Apache-2.0
// The file of a journal as it lies there, before SQLite touches it. Errors say what is wrong of it, without its name;
// JournalError::unreachable where that passes.
#pragma once

#include <cstdint>
#include <string>

#include "base/result.h"

namespace seaway::server {

/// "Seaw", in the header of the file (sqlite.org/fileformat2.html, offset 68).
inline constexpr std::int32_t journal_application_id = 0x53656177;
inline constexpr std::int32_t journal_version = 2;

/// An error that is gone when one comes again: of a disk that does not answer, of limits that others use up.
bool passes(int system_error);

/// Who wrote it.
Result<void> check_journal_header(const std::string& path);
/// Where the journal itself is gone, what lies beside it would be played into a new one.
Result<void> check_no_rest(const std::string& path);

} // namespace seaway::server
