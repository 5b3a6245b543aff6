// SPDX-License-Identifier: Apache-2.0
// The quantised waves of a sea as wire messages. Pure; thread-safe. Cost: some 2 us a wave.
#pragma once

#include <limits>
#include <memory>

#include "sea/basics/dispersion.h"
#include "sea/waves/quantised_spectrum.h"
#include "sea/waves/realization.h"
#include "server/host/encoded_spectrum.h"

namespace seaway::server {

/// A sea as far as its spectrum goes.
struct SpectrumSource {
    std::uint32_t epoch = 0;
    sea::RealizationPtr waves = {};
    sea::Dispersion dispersion = {};
    double height_error_m = 0;
    std::uint32_t ends_epoch = 0;                                      ///< EncodedSpectrum
    sea::TimeUs whole_by_us = std::numeric_limits<sea::TimeUs>::min(); ///< likewise
};

/// Null: larger than the wire takes.
std::unique_ptr<EncodedSpectrum> encode_spectrum(const SpectrumSource& sea,
                                                 const sea::QuantisedSpectrum& waves);

} // namespace seaway::server
