// SPDX-License-Identifier: Apache-2.0
// What a NativeTransform holds; shared by its maker and the runner.
#pragma once

#include <vector>

#include "base/aligned_floats.h"
#include "sea/native/kernels.h"
#include "sea/native/native_transform.h"

namespace seaway::sea::native {

/// A field as the kernels make it: which base spectrum, and which power of kx.
struct FieldRecipe {
    int base;
    int kx_power;
};
FieldRecipe recipe(const FieldInfo& info);

struct TransformState {
    const Kernels* kernels = nullptr;
    Choppiness choppiness;
    std::vector<Block> blocks; ///< with waves
    AlignedFloats records;     ///< as ColumnPass takes them
    AlignedFloats over_k;      ///< CascadeModes::displacement_over_k
    AlignedFloats omega;
    AlignedFloats tables; ///< [table][size]: see the offsets
    Plan plan;
    const float* ky[3];
    const float* scale[field_count]; ///< weight kx^p by n; null where that is 1
};

} // namespace seaway::sea::native
