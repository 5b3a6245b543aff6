// SPDX-License-Identifier: Apache-2.0
#include "sea/foam/foam_kernel_impl.h"

namespace seaway::sea {

const FoamKernel& foam_kernel_avx512() {
    return kernel;
}

} // namespace seaway::sea
