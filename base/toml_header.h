// SPDX-License-Identifier: Apache-2.0
// toml++ as this room includes it, for .cpp files: no exceptions, no assertions.
#pragma once

// toml++ 3.3 meets some malformed texts ("[$") with a failed assertion, or with NDEBUG with
// undefined behaviour. With both off it takes its own error paths; the fuzzer walks them.
#undef NDEBUG
#define TOML_ASSERT(expr) static_assert(true)
#define TOML_EXCEPTIONS 0
#include <toml++/toml.h>
