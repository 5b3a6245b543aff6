// SPDX-License-Identifier: Apache-2.0
#include "sea/waves/wave_sums_impl.h"

namespace seaway::sea {

const WaveSums& wave_sums_avx512() {
    return sums_of<8>();
}

} // namespace seaway::sea
