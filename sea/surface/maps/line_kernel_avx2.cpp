// SPDX-License-Identifier: Apache-2.0
#include "sea/surface/maps/line_kernel_impl.h"

namespace seaway::sea {

float* transform_lines_avx2(const LineTransform& transform, float* data, float* other) {
    return Lines<8>::transform(transform, data, other);
}

} // namespace seaway::sea
