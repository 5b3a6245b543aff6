// SPDX-License-Identifier: Apache-2.0
// What a program says on stderr when it gives up: one line, whatever it quotes; and whether anybody reads along.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>

namespace seaway {

/// The text of a file or of a command line as it may be shown on a terminal: control characters and
/// bytes that are no UTF-8 become \x1b, ends of lines become spaces, what is beyond
/// `printable_bytes_max` becomes [...]. All other text, UTF-8 as well, stays as it is.
std::string printable(std::string_view text);
inline constexpr std::size_t printable_bytes_max = 1000;
/// A value of a line of the log: printable and whole, between double quotes; those that it holds become single ones.
std::string in_quotes(std::string_view text);
/// UTF-8 without control characters: printable() changes nothing of it but its length.
bool is_printable(std::string_view text);

/// Prints "PROGRAM: MESSAGE" on stderr, printable. Returns `status`.
int complain(const char* program, int status, std::string_view message);

/// Text for whoever looks at stderr, as progress is. Where it cannot be written, nothing is: fmt::print would throw.
void tell(std::string_view text);

/// What a program's main() does: the status of `body`, or, of what nobody has caught there, memory and threads above all,
/// `status` after one line as complain() prints it.
int run_main(const char* program, int status, const std::function<int()>& body);

/// What is said where std::thread throws std::errc::resource_unavailable_try_again.
inline constexpr std::string_view no_further_thread =
    "the system gives it no further thread: more are needed than a limit of processes leaves "
    "(ulimit -u, TasksMax= of its "
    "unit, pids.max of its group), or memory for their stacks (ulimit -v)";

/// Does somebody look at stderr? Progress is shown to people alone.
bool stderr_is_terminal();

} // namespace seaway
