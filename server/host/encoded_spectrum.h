// SPDX-License-Identifier: Apache-2.0
// EncodedSpectrum: the waves of one sea at one accuracy as complete wire messages, made once and shared by all
// sessions that send them. Immutable; share it by pointer.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "sea/basics/field.h"
#include "sea/basics/time.h"

namespace seaway::server {

struct EncodedSpectrum {
    using Message = std::shared_ptr<const std::vector<std::uint8_t>>;

    std::uint32_t epoch = 0;
    /// The glide that ends in this sea: who has its spectrum has this one. 0: none.
    std::uint32_t ends_epoch = 0;
    /// Sea time by which who glides there needs all of it; past: at once.
    sea::TimeUs whole_by_us = std::numeric_limits<sea::TimeUs>::min();
    /// Spectrum, then its chunks in order.
    std::vector<Message> messages;
    std::size_t bytes = 0; ///< of them all
};
/// Seas whose waves there is room for however fine they are: of those that a wish may get at once (limits::spectra_max) most are
/// a tenth of that.
inline constexpr std::size_t finest_spectra_held = 4;
/// Bytes of those of one, whatever the sea: what the wire takes.
inline constexpr std::size_t encoded_spectrum_bytes_max = std::size_t{4608} * 1024;

using EncodedSpectrumPtr = std::shared_ptr<const EncodedSpectrum>;

/// Bounds of 0: the server chooses.
struct SpectrumDemand {
    float error_m = 0;
    float slope_error = 0;
    sea::FieldSet fields = sea::surface_fields;
};

struct GrantedSpectrum {
    float error_m = 0;     ///< bounds of the whole
    float slope_error = 0; ///< limits::error_m_max and more: none
    sea::FieldSet fields = {};
    std::string why = {}; ///< in what this is less than the wish; empty: in nothing
    /// Of the sea that runs, of those that it glides from, and of those that are announced. Of a glide: the waves
    /// that it leads to.
    std::vector<EncodedSpectrumPtr> spectra;
};

} // namespace seaway::server
