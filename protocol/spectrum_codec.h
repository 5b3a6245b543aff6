// SPDX-License-Identifier: Apache-2.0
// Spectrum codec v1: blocks of waves to bytes and back (docs/protocol.md, "Bytes of SpectrumChunk.payload").
// Integers are exact, whatever version of zstd wrote or reads them. Thread-safe.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/result.h"
#include "protocol/messages.h"
#include "sea/basics/wave_block.h"

namespace seaway::protocol {

/// 1 to limits::spectrum_blocks_max blocks, whose numbers fit into a byte (checked): 60 MB/s of codes.
Bytes encode_spectrum(std::span<const sea::WaveBlock> blocks);

/// The inverse. An error says what is wrong with bytes that come from elsewhere; which cascades and lattices
/// there are is for who knows the sea. Never more than 1 MB of memory, zstd's included.
Result<std::vector<sea::WaveBlock>> decode_spectrum(std::span<const std::uint8_t> bytes);

} // namespace seaway::protocol
