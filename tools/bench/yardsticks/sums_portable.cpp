// SPDX-License-Identifier: Apache-2.0
#define SEAWAY_LANES 4
#include "tools/bench/yardsticks/sums_impl.h"

namespace seaway::bench {

const Sums& sums_portable() {
    return sums;
}

} // namespace seaway::bench
