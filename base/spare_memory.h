// SPDX-License-Identifier: Apache-2.0
// What the process has in memory and does not use, given back to the system.
#pragma once

namespace seaway {

/// Freed blocks, which would stay in the arenas of their threads (hundreds of MB after a flood), and code that ran at the
/// start: of the compiler of lavapipe's kernels (LLVM's, 46 MB once they are made), and with the first call of drivers (6 MB of those
/// that found no device). It is mapped from its file and comes back page by page where it runs again. Thread-safe. Of the code 10 us, of blocks what malloc_trim takes.
void give_back_spare_memory();

} // namespace seaway
