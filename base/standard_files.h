// SPDX-License-Identifier: Apache-2.0
// Standard input, output and error of a program that was started without some of them.
#pragma once

namespace seaway {

/// Takes the numbers of those that are closed, so that no socket or file of this program gets one of them and is written to as
/// if it were a terminal. What is read or written there fails as before. And a limit on the size of files (`ulimit -f`) is met as a
/// full disk is: by an error, not by the end of the program. First of all in main().
void hold_standard_files();

} // namespace seaway
