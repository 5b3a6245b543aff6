// SPDX-License-Identifier: Apache-2.0
// The instruction sets that the native synthesizer is built for; one is chosen at run time.
#pragma once

#include <string_view>
#include <vector>

namespace seaway {

enum class Instructions {
    portable, ///< 4 lanes; what every machine of the target has (x86: SSE2)
    avx2,     ///< 8 lanes; AVX2 and FMA
    avx512,   ///< 16 lanes; AVX-512 F, DQ, VL
};

std::string_view name(Instructions instructions);

/// Those that this build holds and this machine runs, slowest first; never empty.
std::vector<Instructions> supported_instructions();

/// The last of them.
Instructions best_instructions();

} // namespace seaway
