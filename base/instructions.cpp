// SPDX-License-Identifier: Apache-2.0
#include "base/instructions.h"

namespace seaway {

std::string_view name(Instructions instructions) {
    switch (instructions) {
    case Instructions::portable:
        return "portable";
    case Instructions::avx2:
        return "AVX2";
    case Instructions::avx512:
        return "AVX-512";
    }
    return "unknown";
}

std::vector<Instructions> supported_instructions() {
    std::vector<Instructions> found{Instructions::portable};
#if defined(SEAWAY_X86)
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
        found.push_back(Instructions::avx2);
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512vl"))
        found.push_back(Instructions::avx512);
#endif
    return found;
}

Instructions best_instructions() {
    return supported_instructions().back();
}

} // namespace seaway
