// SPDX-License-Identifier: Apache-2.0
#include "sea/surface/map_kernel_impl.h"

namespace seaway::sea {

const MapKernel& map_kernel_portable() {
    return kernel_of<4>();
}

} // namespace seaway::sea
