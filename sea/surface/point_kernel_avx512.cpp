// SPDX-License-Identifier: Apache-2.0
#include "sea/surface/point_kernel_impl.h"

namespace seaway::sea {

const PointKernel& point_kernel_avx512() {
    return kernel_of<16>();
}

} // namespace seaway::sea
