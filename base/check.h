// SPDX-License-Identifier: Apache-2.0
// SEAWAY_CHECK: for our own mistakes only. Stays on in release builds: prints the condition, the
// place and a sentence, then aborts. Never use it on bytes from a peer or on a user's input.
#pragma once

#include <string_view>

namespace seaway {

[[noreturn]] void check_failed(const char* condition, const char* file, int line,
                               std::string_view why);

} // namespace seaway

#define SEAWAY_CHECK(condition, why)                                                               \
    do {                                                                                           \
        if (!(condition)) [[unlikely]]                                                             \
            ::seaway::check_failed(#condition, __FILE__, __LINE__, (why));                         \
    } while (false)
