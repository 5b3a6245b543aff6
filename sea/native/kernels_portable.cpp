// SPDX-License-Identifier: Apache-2.0
#include "sea/native/kernels_impl.h"

namespace seaway::sea::native {

const Kernels* portable_kernels(int size) {
    return kernels_of<4>(size);
}

} // namespace seaway::sea::native
