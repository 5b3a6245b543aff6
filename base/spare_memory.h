// SPDX-License-Identifier: Apache-2.0
// What the process has in memory and does not use, given back to the system.
#pragma once

namespace seaway {

/// Freed blocks, which would stay in the arenas of their threads (hundreds of MB after a flood), and the code of the
/// compiler of lavapipe's kernels (LLVM's, 46 MB once they are made): it is mapped from its file and comes back page by
/// page where a kernel is compiled again. Thread-safe. Of the code 10 us, of blocks what malloc_trim takes.
void give_back_spare_memory();

} // namespace seaway
