// SPDX-License-Identifier: Apache-2.0
#include "sea/surface/point_kernel_impl.h"

namespace seaway::sea {

const PointKernel& point_kernel_avx2() {
    return kernel_of<8>();
}

} // namespace seaway::sea
