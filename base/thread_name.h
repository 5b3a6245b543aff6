// SPDX-License-Identifier: Apache-2.0
// Names of threads, for `top -H`, perf and gdb.
#pragma once

namespace seaway {

/// This thread's name: 15 letters at most, "sea-" first, for a host's threads have names of their own.
void name_thread(const char* name) noexcept;

} // namespace seaway
