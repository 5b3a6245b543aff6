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

/// Once, before there are threads: where a thread's free() leaves more than a megabyte at the end of its arena, that goes back. malloc_trim() does
/// not look there but for the first thread, and malloc's own limit grows to twice the largest block that it had from the system
/// (mallopt(3), "dynamic adjustment"), so that each thread kept a megabyte and more. For the process, whatever its environment says of malloc: a library leaves it alone.
void keep_ends_of_arenas_short();

/// Memory that was mapped, and whose content may be lost: its whole pages go back, and where it is the process's own, or a file of its own, fresh
/// ones of zeros come when it is used next.
void give_back_pages(std::span<std::byte> bytes);

} // namespace seaway
