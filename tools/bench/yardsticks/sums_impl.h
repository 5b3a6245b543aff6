// SPDX-License-Identifier: Apache-2.0
// The loop of sums.h, SEAWAY_LANES wide: each file that includes this is compiled for its own instructions.
#pragma once

#include "tools/bench/yardsticks/sums.h"

namespace seaway::bench {
namespace {

using Vector [[gnu::vector_size(SEAWAY_LANES * sizeof(float))]] = float;

/// More than a processor has under way, and no more than it has registers for.
constexpr std::size_t chain_count = 12;

float run_chains(std::size_t rounds, float factor, float added) {
    Vector chains[chain_count];
    for (std::size_t i = 0; i < chain_count; ++i)
        chains[i] = Vector{} + static_cast<float>(i);
    for (std::size_t round = 0; round < rounds; ++round)
        for (std::size_t i = 0; i < chain_count; ++i)
            chains[i] = chains[i] * factor + added;
    Vector all = chains[0];
    for (std::size_t i = 1; i < chain_count; ++i)
        all += chains[i];
    return all[0];
}

constexpr Sums sums{&run_chains, 2 * chain_count* SEAWAY_LANES};

} // namespace
} // namespace seaway::bench
