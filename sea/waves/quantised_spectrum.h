// SPDX-License-Identifier: Apache-2.0
// A realised sea in as few numbers as a wanted accuracy needs: h0(k) as whole multiples of a step, in layers of
// blocks of 8 x 8 waves, those first that tell most of the height for their size.
//
// Rounding is noise: eta of it has the variance 2 sum |error of h0|^2, slopes and displacements likewise, times k^2
// and coth^2(kd). What is stated is that sum over the very waves of this sea, those that round to nothing
// included; no law is assumed but that waves of random phases add up to a normal error (sea/basics/deviations.h). Steps
// that are even in k for a height, and even in k h0 for a slope, are the cheapest (reverse water-filling: Cover and
// Thomas, Elements of Information Theory, 10.3.3); for both at once step_m / sqrt(1 + (k length_m)^2), whose
// length_m is tried out.
//
// Pure; thread-safe. Cost: some 2 us a wave.
#pragma once

#include <limits>
#include <vector>

#include "sea/basics/wave_block.h"
#include "sea/waves/realization.h"

namespace seaway::sea {

/// What is wanted is more than so many standard deviations of what is missed: a sea is asked for days, and one more than stated bounds have
/// (bound_sigmas) costs 3 % of the bytes.
inline constexpr double spectrum_sigmas = 6.0;

/// Bounds at any place and time, spectrum_sigmas standard deviations; both above 0, and the second infinite
/// where slopes do not matter.
struct SpectrumAccuracy {
    double height_m =
        0; ///< of a height above a world point where the sea is as steep as it is on average
    double slope = std::numeric_limits<double>::infinity(); ///< along any line
};

struct QuantisedSpectrum {
    SpectrumSteps steps;
    std::vector<WaveBlock>
        blocks; ///< at least one, whose codes may all be 0, of a sea that has any wave
    /// What is missed once the blocks up to and including this one are there.
    std::vector<SpectrumLeft> left;
    SpectrumLeft without;     ///< without any block
    std::vector<double> bits; ///< of each block, roughly
};

/// Of a sea that is nothing but modes (CascadeModes::sines empty: checked).
QuantisedSpectrum quantise(const Realization& sea, const SpectrumAccuracy& wanted);

} // namespace seaway::sea
