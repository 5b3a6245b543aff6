// SPDX-License-Identifier: Apache-2.0
#include "sea/surface/point_kernel_impl.h"

namespace seaway::sea {

const PointKernel& point_kernel_portable() {
    return kernel_of<4>();
}

} // namespace seaway::sea
