// SPDX-License-Identifier: Apache-2.0
// The inner loop of foam (foam.h): one tick of a history, several instruction sets.
#pragma once

#include <cstddef>

#include "base/instructions.h"

namespace seaway::sea {

/// What one tick needs, in single precision; the terms are those of conditional_breaking().
struct FoamTick {
    float threshold, bias, choppiness_x, choppiness_y, choppiness_xy;
    float variance, difference, shear, curvature;
    float difference_rest, shear_rest, cross_rest, constant_rest;
    float remains, source, added; ///< ratio = ratio * remains + breaking * source + added

    /// Else the strains make no difference, and need not be there.
    bool looks() const { return source != 0.0f; }
    /// All ratios become ratio * remains + added.
    static FoamTick without_strains(float remains, float added) {
        FoamTick tick{};
        tick.remains = remains;
        tick.added = added;
        return tick;
    }
};

struct FoamKernel {
    /// ratio = ratio * remains + breaking(strains) * source + added at `count` points.
    void (*advance)(const FoamTick& tick, const float* strain_xx, const float* strain_yy,
                    const float* strain_xy, float* ratio, std::size_t count);
};

/// The kernel for instructions that this machine has. The values differ by rounding.
const FoamKernel& foam_kernel(Instructions instructions);

// One a translation unit that is compiled for them.
const FoamKernel& foam_kernel_portable();
const FoamKernel& foam_kernel_avx2();
const FoamKernel& foam_kernel_avx512();

} // namespace seaway::sea
