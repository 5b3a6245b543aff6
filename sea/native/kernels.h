// SPDX-License-Identifier: Apache-2.0
// Between native_transform/native_runner and the kernels: plain values only, because kernels are
// compiled once per instruction set and must bring no shared inline code with them.
//
// A synthesis has two passes. Everything real has a Hermitian spectrum, so kx >= 0 suffices.
//   columns: for a block of neighbouring kx (one a lane) evolve all ky, then transform along y,
//            once per *base spectrum* b(k) = (1, ky, 1/k, ky/k or ky^2/k) times h or dh/dt.
//            Powers of kx are constant along a column, so fields that differ by them share a base.
//   rows:    for two neighbouring y the half spectra A, B of a base give C = A + i B on all kx;
//            a field is C times i^s kx^p weight, one complex transform along x; row y is its real
//            part and row y + 1 its imaginary part. No field is transformed that nobody wants.
#pragma once

#include <cstddef>
#include <cstdint>

namespace seaway::sea::native {

/// What the columns are evolved to: h or dh/dt, as it is or over k.
inline constexpr int source_count = 4;
enum Source { source_h, source_h_over_k, source_rate, source_rate_over_k };

/// source * 3 + power of ky (0, 1, 2).
inline constexpr int base_count = source_count * 3;

/// One column block: it holds waves at ky = -reach .. reach, one record each.
struct Block {
    std::size_t first; ///< index of its first record among those of all blocks
    int reach;         ///< -1: no wave in this block
};

/// Floats a lane and record: h0(k) + conj h0(-k) (re, im), i (conj h0(-k) - h0(k)) (re, im), and
/// the rate as one 64-bit word. [record][stream][lane].
inline constexpr int record_streams = 6;

/// One transform length: n = r2 n1 + n2 in, k1 + r1 k2 out.
struct Plan {
    const float* cos; ///< cos(2 pi n2 k1 / N), [k1][n2]
    const float* sin;
};

struct ColumnPass {
    const Block* blocks;
    const float* records;
    const float* over_k;   ///< 1/k, [record][lane]
    const float* omega;    ///< angular frequency, rad/s, [record][lane]
    int block_count;       ///< blocks with waves; they are the first ones
    std::uint64_t time_us; ///< modulo 2^64
    const float* ky[3];    ///< ky^p, [n], rad/m
    Plan plan;
    std::uint32_t sources;  ///< bits of Source
    std::uint32_t bases;    ///< bits of base
    float* lines;           ///< out: [y][base among those wanted][re, im][line_pitch]
    std::size_t line_pitch; ///< floats; at least size/2 + 16
};

/// Maps at least this large are stored past the caches when they can be: fetching their lines only
/// to overwrite them costs a third of the whole synthesis.
inline constexpr int smallest_streamed_size = 512;
/// Lines of smaller maps than these are in a cache anyway.
inline constexpr int smallest_prefetched_size = 256;

struct RowField {
    int base;           ///< index among the bases wanted
    const float* scale; ///< weight kx^p, [n]; null: 1
    bool imaginary;     ///< times i
    float* out;         ///< [y][x]; null: kept for the Jacobian only
    int scratch_row;    ///< which of three scratch rows then
    bool streamed;      ///< store past the caches
};

struct RowPass {
    const float* lines;
    std::size_t line_pitch;
    int base_count;
    std::uint32_t odd_bases; ///< bits of bases wanted with an odd power of ky
    int columns; ///< kx below this were computed; followed by at least one row of zero lanes
    Plan plan;
    const RowField* fields; ///< ordered by base
    int field_count;
    float* jacobian;     ///< [y][x] or null; then these are the strains among the fields:
    int strain[3];       ///< xx, yy, xy
    float choppiness[2]; ///< x, y
};

/// Kernels for one size and instruction set.
struct Kernels {
    int size;
    int lanes;                  ///< kx a column block
    int r1, r2;                 ///< factors of `size`
    std::size_t scratch_floats; ///< per worker
    void (*columns)(const ColumnPass&, int block, float* scratch);
    /// Rows y_begin .. y_end - 1, both even.
    void (*rows)(const RowPass&, int y_begin, int y_end, float* scratch);
    /// a b + c as the compiler of this file makes it where no Fused is called (vector.h): the product
    /// must be rounded. Tests ask.
    float (*product_then_sum)(float a, float b, float c);
};

const Kernels* portable_kernels(int size);
#if defined(SEAWAY_X86)
const Kernels* avx2_kernels(int size);
const Kernels* avx512_kernels(int size);
#endif

} // namespace seaway::sea::native
