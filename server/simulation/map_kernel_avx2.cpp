// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/map_kernel_impl.h"

namespace seaway::server {

const MapKernel& map_kernel_avx2() {
    return kernel_of<8>();
}

} // namespace seaway::server
