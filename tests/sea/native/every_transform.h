// SPDX-License-Identifier: Apache-2.0
// Every size of a transform with every instruction set of this machine, as cases of a test.
#pragma once

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "base/instructions.h"
#include "sea/native/native_transform.h"

namespace seaway::sea {

struct TransformCase {
    Instructions instructions;
    int size;
};

inline std::vector<TransformCase> every_transform() {
    std::vector<TransformCase> cases;
    for (const Instructions instructions : supported_instructions())
        for (int size = NativeTransform::smallest_size; size <= NativeTransform::largest_size;
             size *= 2)
            cases.push_back({instructions, size});
    return cases;
}

/// "avx2_64", as GoogleTest allows it in names.
inline std::string name_of(const ::testing::TestParamInfo<TransformCase>& test) {
    std::string name(seaway::name(test.param.instructions));
    std::erase(name, '-');
    return name + "_" + std::to_string(test.param.size);
}

} // namespace seaway::sea
