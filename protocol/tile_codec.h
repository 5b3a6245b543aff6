// SPDX-License-Identifier: Apache-2.0
// Tile codec v1: one square or rectangular part of a float map to bytes and back, with a promised
// bound on the largest error. Quantise to twice the bound, predict (2-D Lorenzo on integers),
// zigzag, byte planes, zstd level 3. Integer exact: the same bytes on every platform. The byte
// layout is in docs/protocol.md.
//
// |decoded - original| <= error for every sample; `error` = 0 is lossless. NaN and infinities are
// refused. Thread-safe: pure functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/result.h"

namespace seaway::protocol {

struct TileShape {
    int width;  ///< 1 .. limits::tile_side_max
    int height; ///< 1 .. limits::tile_side_max
};

/// Encodes `height` rows of `width` samples; row r starts at samples[r * row_stride].
/// error: in the unit of the samples, >= 0 and finite. About 400 MB/s a core.
Result<std::vector<std::uint8_t>> encode_tile(std::span<const float> samples, TileShape shape,
                                              std::size_t row_stride, float error);

/// Encodes samples that are whole steps: each is the product of an integer and `step`, rounded to a float, and `step` has
/// products with integers below 4096 that are exact. They are coded in steps that are an odd number of these, as wide as
/// `error` allows: the bytes that encode_tile() makes of the samples when it comes to that step. Most of its time is zstd's, as there.
Result<std::vector<std::uint8_t>> encode_tile_steps(std::span<const std::int16_t> steps,
                                                    TileShape shape, std::size_t row_stride,
                                                    float step, float error);

/// A tile in two forms that decode to the same samples: by itself, and as the difference to what its receiver expects there.
struct TileForms {
    std::vector<std::uint8_t> whole;
    std::vector<std::uint8_t> difference; ///< empty: there is none
};

/// Both, of samples of which `expected` is known (laid out as `samples`; where it is of no use there is no difference).
/// `decoded`, likewise: what both come to, within `error` of the samples. The whole form is three bits a sample larger than
/// encode_tile's: it tells of what came before, exactly. About 200 MB/s a core.
Result<TileForms> encode_tile_forms(std::span<const float> samples, TileShape shape,
                                    std::size_t row_stride, float error,
                                    std::span<const float> expected, std::span<float> decoded);

/// Is this the difference to something?
bool is_difference(std::span<const std::uint8_t> bytes);

/// Of errors of decode_tile_difference.
enum class TileMiss {
    other_expected, ///< this does not come to the samples that were encoded: something else was expected there
};

/// Decodes a difference; `samples` may be where `expected` is. After an error there is no telling
/// what is in `samples`.
Result<void> decode_tile_difference(std::span<const std::uint8_t> bytes, TileShape shape,
                                    std::size_t row_stride, std::span<const float> expected,
                                    std::span<float> samples);

/// Decodes into `height` rows of `width` samples; row r starts at samples[r * row_stride]. Safe on
/// hostile bytes: returns an error, never reads or writes out of bounds, allocates no more than the
/// shape asks for. About 900 MB/s a core.
Result<void> decode_tile(std::span<const std::uint8_t> bytes, TileShape shape,
                         std::size_t row_stride, std::span<float> samples);

} // namespace seaway::protocol
