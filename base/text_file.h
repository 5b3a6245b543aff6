// SPDX-License-Identifier: Apache-2.0
// Files that users name, read with a limit; and the promise that what was printed has been written.
#pragma once

#include <cstddef>
#include <cstdio>
#include <string>
#include <string_view>

#include "base/result.h"

namespace seaway {

/// The whole of a regular file of at most `bytes_max` bytes. Never waits and never holds more than
/// the limit: pipes, devices, sockets and folders are errors, and reading stops one byte beyond the
/// limit. The error says why, without the path: "no such file", "is a pipe, a device or a socket;
/// a regular file is needed", "has more than 1048576 bytes", ...
Result<std::string> read_text_file(const std::string& path, std::size_t bytes_max);

/// For readers that go through a file line by line: the same errors, before the file is opened.
Result<void> check_regular_file(const std::string& path);

/// A file that is about to be written: an error if something else than a regular file has its name.
/// libpng and others remove what they could not write whole, and with rights enough a device too.
Result<void> check_replaceable(const std::string& path);

/// Writes out what std::cout, fmt::print and stdio hold for standard output. An error if any of it
/// was lost (disk full, reader gone): a program that prints an answer must not exit with 0 then.
Result<void> finish_standard_output();

/// Writes to a stream and flushes it, for who prints as it goes on. The same error, of the kind
/// OutputError::lost: nobody reads on.
enum class OutputError { lost = 1 };
Result<void> write_out(std::FILE* out, std::string_view text);

/// For the end of main(): `status`; or, where that is 0 but output was lost, `lost_status`, with one
/// line on stderr in the program's name.
int status_after_output(const char* program, int status, int lost_status);

} // namespace seaway
