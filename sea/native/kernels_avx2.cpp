// SPDX-License-Identifier: Apache-2.0
#include "sea/native/kernels_impl.h"

namespace seaway::sea::native {

const Kernels* avx2_kernels(int size) {
    return kernels_of<8>(size);
}

} // namespace seaway::sea::native
