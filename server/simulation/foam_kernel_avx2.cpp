// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/foam_kernel_impl.h"

namespace seaway::server {

const FoamKernel& foam_kernel_avx2() {
    return kernel;
}

} // namespace seaway::server
