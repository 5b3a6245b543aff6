// SPDX-License-Identifier: Apache-2.0
#define SEAWAY_LANES 16
#include "tools/bench/yardsticks/sums_impl.h"

namespace seaway::bench {

const Sums& sums_avx512() {
    return sums;
}

} // namespace seaway::bench
