// SPDX-License-Identifier: Apache-2.0
// What the process has in memory and does not use, given back to the system.
#pragma once

#include <cstddef>
#include <span>

namespace seaway {

/// Freed blocks, which would stay in the arenas of their threads (hundreds of MB after a flood), and code that ran at the
/// start: of the compiler of lavapipe's kernels (LLVM's, 46 MB once they are made), and with the first call of drivers (6 MB of those
/// that found no device). It is mapped from its file and comes back page by page where it runs again. Thread-safe. Of the code 10 us, of blocks what malloc_trim takes.
void give_back_spare_memory();

/// Once, before there are threads: what each of them has freed at the end of its arena is given back from a megabyte on. malloc_trim() does
/// not look there but for the first thread, and malloc itself would keep twice the largest block that was ever freed (mallopt(3),
/// "dynamic adjustment"), a megabyte and more a thread. For the process: a library leaves it alone.
void keep_ends_of_arenas_short();

/// Of mapped memory whose content is lost on purpose: the pages that lie wholly within go back, and fresh ones come when it is written next.
void give_back_pages(std::span<std::byte> bytes);

} // namespace seaway
