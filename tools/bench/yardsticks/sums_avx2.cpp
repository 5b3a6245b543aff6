// SPDX-License-Identifier: Apache-2.0
#define SEAWAY_LANES 8
#include "tools/bench/yardsticks/sums_impl.h"

namespace seaway::bench {

const Sums& sums_avx2() {
    return sums;
}

} // namespace seaway::bench
