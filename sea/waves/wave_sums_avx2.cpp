// SPDX-License-Identifier: Apache-2.0
#include "sea/waves/wave_sums_impl.h"

namespace seaway::sea {

const WaveSums& wave_sums_avx2() {
    return sums_of<4>();
}

} // namespace seaway::sea
