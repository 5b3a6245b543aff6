// SPDX-License-Identifier: Apache-2.0
// SpectrumStore: the waves of a sea as wire messages, once for each of a few accuracies, kept for as long as the
// sea is one of the newest four. What a client wishes for gets the coarsest accuracy that keeps it, what is finer than
// all the finest; 0 the sea's own height_error_m, and the finest slopes.
//
// Thread-safe; one caller at a time makes something, the others wait. Cost where nothing is held: some 4 us a wave, of a
// gale 0.1 s.
#pragma once

#include <array>
#include <compare>
#include <limits>
#include <map>
#include <mutex>
#include <span>

#include "base/result.h"
#include "sea/basics/dispersion.h"
#include "sea/waves/realization.h"
#include "server/host/encoded_spectrum.h"

namespace seaway::server {

/// Bounds on heights, in shares of the sea's height_error_m. A client that has the waves adds nothing to them, and may want
/// finer ones than tiles give.
inline constexpr std::array<double, 7> height_rungs{0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0};
/// The one of the sea's own.
inline constexpr std::size_t own_height_rung = 2;
/// Bounds on slopes; the last rung has none.
inline constexpr std::array<double, 5> slope_rungs{0.005, 0.01, 0.02, 0.05,
                                                   std::numeric_limits<double>::infinity()};

/// A sea as far as its spectrum goes.
struct SpectrumSource {
    std::uint32_t epoch = 0;
    sea::RealizationPtr waves = {};
    sea::Dispersion dispersion = {};
    double height_error_m = 0;
    std::uint32_t ends_epoch = 0;                                      ///< EncodedSpectrum
    sea::TimeUs whole_by_us = std::numeric_limits<sea::TimeUs>::min(); ///< likewise
};

class SpectrumStore {
  public:
    /// Errors, of kind Refusal: not_offered for a sea of stylised waves, which are no modes, and for one whose
    /// spectrum is larger than the wire takes at every accuracy.
    Result<GrantedSpectrum> grant(const SpectrumSource& sea, const SpectrumDemand& wish);
    /// Of several seas, the first of which is the one that runs; bounds are the largest of them. One of the others that
    /// has no spectrum is named and left out.
    Result<GrantedSpectrum> grant(std::span<const SpectrumSource> seas, const SpectrumDemand& wish);

  private:
    struct Rung {
        std::size_t height = 0; ///< of height_rungs
        std::size_t slope = 0;  ///< of slope_rungs
        auto operator<=>(const Rung&) const = default;
    };
    struct Made {
        EncodedSpectrumPtr spectrum; ///< null: larger than the wire takes
        double slope_error = 0;
    };

    const Made& made(const SpectrumSource& sea, const Rung& rung);

    std::mutex mutex_;
    std::map<std::uint32_t, std::map<Rung, Made>> made_; ///< by epoch
};

} // namespace seaway::server
