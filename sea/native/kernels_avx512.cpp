// SPDX-License-Identifier: Apache-2.0
#include "sea/native/kernels_impl.h"

namespace seaway::sea::native {

const Kernels* avx512_kernels(int size) {
    return kernels_of<16>(size);
}

} // namespace seaway::sea::native
