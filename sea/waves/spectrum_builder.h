// SPDX-License-Identifier: Apache-2.0
// SpectrumBuilder: the inverse of sea/waves/quantised_spectrum.h: blocks of waves, as they come, to a sea that can be
// summed and transformed. Frequencies are not sent: they follow from dispersion and loop by the same
// arithmetic as those of the sea that was realised (mode_rate), to the last place of a double.
//
// For one thread. A block costs some 5 us. What comes from elsewhere is checked here.
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "base/result.h"
#include "sea/basics/wave_block.h"
#include "sea/waves/realization.h"

namespace seaway::sea {

/// The tiles of a sea, and what its frequencies follow from.
struct SpectrumFrame {
    struct Tile {
        CascadeSpec spec;
        Band band;
        bool carries_spectra = true; ///< or waves alone that a scene places (CascadeModes)
    };
    std::vector<Tile> tiles;
    Choppiness choppiness;
    Dispersion dispersion;
    TimeUs loop_period_us = 0;
};

/// Waves of all tiles of a frame, at most: 8 tiles of 1024, 200 MB.
inline constexpr std::size_t spectrum_modes_max = std::size_t{8} << 20;

class SpectrumBuilder {
  public:
    /// A sea without waves. Errors: the tiles have more than spectrum_modes_max points, or a band too fast for rates.
    static Result<SpectrumBuilder> create(const SpectrumFrame& frame, const SpectrumSteps& steps);

    /// Adds a layer of a block. Errors: a cascade that there is not, a wave
    /// beyond its lattice or too fast for a rate.
    Result<void> add(const WaveBlock& block);

    const Realization& sea() const& { return sea_; }
    Realization sea() && { return std::move(sea_); } ///< after which there is none

  private:
    SpectrumBuilder() = default;
    Result<void> put(const WaveBlock& block, int i, int j);

    Dispersion dispersion_;
    SpectrumSteps steps_;
    Realization sea_;
};

} // namespace seaway::sea
