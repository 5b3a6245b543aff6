// SPDX-License-Identifier: Apache-2.0
// The inner loops of the exact sum (reference.h): plain values, because they are compiled once per
// instruction set and must bring no shared inline code with them.
//
// Two waves (nx, ny) and (-nx, ny) are a pair: along a line of x their sum is
//     even cos(kx x) + odd sin(kx x),   even = h(kx) + h(-kx),   odd = i (h(kx) - h(-kx)),
// whose real and imaginary parts are sums apart. A pair of one wave has the other at zero. Pairs whose nx
// follow each other are summed in eight lanes, which are added up in one order at the end; products and sums
// are rounded one by one. So the result is the same bits with every instruction set.
#pragma once

#include <cstddef>
#include <cstdint>

#include "base/instructions.h"
#include "sea/basics/lagrangian_point.h"
#include "sea/basics/time.h"

namespace seaway::sea {

inline constexpr int sum_lanes = 8;

struct alignas(64) Lanes {
    double at[sum_lanes];
};

/// Of eight waves what they are at any time; zero where there is none.
struct SpectrumBlock {
    Lanes h0[2];          ///< h0(k): [0] real, [1] imaginary
    Lanes h0_opposite[2]; ///< h0(-k)
    Lanes omega_radps;
    alignas(64) Rate rate[sum_lanes];
};

/// Eight pairs.
struct PairSpectrum {
    SpectrumBlock east; ///< nx
    SpectrumBlock west; ///< -nx
};

/// h or dh/dt of eight pairs, nx = 8 b .. 8 b + 7; zero where there is no wave. [0] real, [1] imaginary.
struct PairBlock {
    Lanes even[2];
    Lanes odd[2];
};

/// Blocks of one ny that follow each other. A block without a wave is not held: another run begins
/// after it.
struct WaveRun {
    int ny;            ///< 0 or more: the other half plane is the conjugate of this one
    int first;         ///< nx of the first pair, a multiple of 8
    std::size_t begin; ///< blocks begin .. end - 1
    std::size_t end;
    double ky_radpm;
};

/// cos and sin of eight phases.
struct Turns {
    Lanes cos;
    Lanes sin;
};

/// One tile at one time.
struct TileWaves {
    const WaveRun* runs;
    std::size_t run_count;
    const PairBlock* height;            ///< h
    const PairBlock* rate;              ///< dh/dt
    const Lanes* displacement_over_k_m; ///< coth(kd)/k of each pair
    const Lanes* kx_radpm;              ///< [nx / 8]
};

/// Columns that are summed together, so that a wave is fetched from memory once for all of them.
inline constexpr int columns_together = sum_lanes;

/// Sums over a run for each of these columns: of h, and of the potential whose gradient is the
/// displacement, coth(kd)/k h, and its derivative to x. [0] real, [1] imaginary.
struct ColumnSums {
    Lanes height[2];
    Lanes potential[2];
    Lanes potential_x[2];
};

/// Where a line of y meets these columns.
struct Crossings {
    Lanes east; ///< displacement, m
    Lanes north;
    Lanes up; ///< height, m
};

/// A number for each run.
struct RunTurn {
    double cos;
    double sin;
};

struct WaveSums {
    /// exp(i n phase) for n = 0 .. 8 blocks - 1; phase in turns, 0.64 fixed point: n times it is exact. Each
    /// cosine and sine within 4e-16, what a place is rounded by to fixed point included, for n below 1024.
    void (*turns)(std::uint64_t phase, std::size_t blocks, Turns* out);
    /// h and dh/dt at a time of `count` blocks.
    void (*evolve)(const PairSpectrum* waves, std::size_t count, TimeUs time, PairBlock* height,
                   PairBlock* rate);
    /// Adds what the tile has at a point; east, north: exp(i kx x), exp(i ky y), [n / 8].
    void (*point)(const TileWaves& tile, const Turns* east, const Turns* north,
                  LagrangianPoint& point);
    /// The sums of each run; east: [nx], of each column.
    void (*columns)(const TileWaves& tile, const Turns* east, ColumnSums* sums);
    /// Sums over the runs; north: of each.
    void (*cross)(const TileWaves& tile, const ColumnSums* sums, const RunTurn* north,
                  Crossings& crossings);
};

/// The loops for instructions that this machine has.
const WaveSums& wave_sums(Instructions instructions);

// One a translation unit that is compiled for them.
const WaveSums& wave_sums_portable();
const WaveSums& wave_sums_avx2();
const WaveSums& wave_sums_avx512();

} // namespace seaway::sea
