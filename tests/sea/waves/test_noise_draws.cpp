// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "sea/waves/noise.h"
#include "sea/waves/realize.h"
#include "sea/waves/sine_waves.h"
#include "sea/waves/statistics/moments.h"

namespace seaway::sea {
namespace {

// Octaves of the same cells would be one pattern that is seen again and again.
TEST(Noise, every_octave_system_and_seed_draws_corners_of_its_own) {
    SineRamps ramps;
    ramps.kind = SineKind::noise;
    ramps.length_m = 64;
    ramps.wavelength_m = 16;
    ramps.wavenumber_ratio = 1;
    ramps.count = 3;
    std::vector<std::vector<double>> drawn;
    for (const auto& [seed, system] :
         {std::pair<std::uint64_t, std::uint32_t>(3, 0), {3, 1}, {4, 0}, {3 + (1ull << 32), 0}})
        for (const NoiseOctave& octave :
             sine_field(ramps, seed, system, Dispersion{}, 1.0, 0).octaves) {
            EXPECT_EQ(octave.cells, 8);
            drawn.push_back(*octave.corners);
        }
    ASSERT_EQ(drawn.size(), 12u);
    for (std::size_t a = 0; a < drawn.size(); ++a)
        for (std::size_t b = 0; b < a; ++b)
            EXPECT_NE(drawn[a], drawn[b]) << a << ", " << b;
}

// Noise repeats after whole cells, two to a wavelength, and keeps its way; a wave has a whole number of
// crests along each axis. 100 m of 30 m: 20/3 cells become 7, the next octave's 34/3 become 11.
TEST(Noise, what_repeating_changes_is_counted_by_cells_and_never_turns_it) {
    SineRamps ramps;
    ramps.length_m = 100;
    ramps.wavelength_m = 30;
    ramps.wavenumber_ratio = 1.7;
    ramps.towards_rad = 0.4;
    ramps.direction_spread_rad = 0;
    ramps.kind = SineKind::noise;
    for (const auto& [count, share] : {std::pair(1, 1 / 21.0), {2, 1 / 21.0}, {3, 1 / 21.0}}) {
        ramps.count = count;
        const SineSnapping moved = sine_snapping(ramps, 1, 0);
        EXPECT_NEAR(moved.wavelength_share, share, 1e-12) << count;
        EXPECT_EQ(moved.direction_rad, 0) << count;
    }
    ramps.wavelength_m = 48; // 25/6 cells become 4; then 85/12 become 7: the first moves most
    EXPECT_NEAR(sine_snapping(ramps, 1, 0).wavelength_share, 25 / 24.0 - 1, 1e-12);
    ramps.wavelength_m = 30;
    ramps.kind = SineKind::sine;
    ramps.count = 1; // 10/3 steps at 0.4 rad become 3 east and 1 north
    const SineSnapping moved = sine_snapping(ramps, 1, 0);
    EXPECT_NEAR(moved.wavelength_share, 10 / 3.0 / std::sqrt(10.0) - 1, 1e-12);
    EXPECT_NEAR(moved.direction_rad, 0.4 - std::atan2(1, 3), 1e-12);
}

// Requested and realised: sines that move nothing sideways have a direction all the same.
TEST(Sines, the_summary_says_where_stylised_waves_go) {
    for (const SineKind kind : {SineKind::sine, SineKind::exponential}) {
        SineRamps ramps;
        ramps.kind = kind;
        ramps.length_m = 500;
        ramps.wavelength_m = 20;
        ramps.count = 1;
        ramps.amplitude_m = 0.5;
        ramps.towards_rad = 0.4;
        ramps.direction_spread_rad = 0;
        SeaState sea;
        sea.systems = {ramps};
        const CascadeSpec tile{500.0, 128};
        const Realization realization = *realize(sea, {&tile, 1});
        const SeaSummary summary = summarize(sea, realization);
        // 25 steps a tile: an angle is right to a fiftieth.
        EXPECT_NEAR(summary.requested.mean_towards_rad, 0.4, 0.03);
        EXPECT_NEAR(summary.realised.mean_towards_rad, summary.requested.mean_towards_rad, 1e-9);
    }
}

} // namespace
} // namespace seaway::sea
