// SPDX-License-Identifier: Apache-2.0
// Chains of products and sums that nothing waits for, by each set of instructions: what a core computes at best.
#pragma once

#include <cstddef>

namespace seaway::bench {

struct Sums {
    /// So many rounds of products and sums, of whatever value.
    float (*run)(std::size_t rounds, float factor, float added);
    std::size_t operations; ///< of a round
};

// One a translation unit that is compiled for them.
const Sums& sums_portable();
const Sums& sums_avx2();
const Sums& sums_avx512();

} // namespace seaway::bench
