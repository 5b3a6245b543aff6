// SPDX-License-Identifier: Apache-2.0
#include "sea/waves/statistics/given_waves.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <map>
#include <utility>
#include <vector>

#include "sea/waves/realize.h"

namespace seaway::sea {

namespace {

struct ModesOfTile {
    double length_m;
    std::map<std::pair<int, int>, std::complex<double>> amplitudes_m;
};

std::vector<ModesOfTile> modes_by_tile(const SeaState& sea) {
    std::vector<ModesOfTile> tiles;
    for (const WaveSystem& system : sea.systems) {
        const auto* modes = std::get_if<ExplicitModes>(&system);
        if (!modes)
            continue;
        auto tile = std::ranges::find_if(tiles, [&](const ModesOfTile& held) {
            return same_tile_length(held.length_m, modes->length_m);
        });
        if (tile == tiles.end())
            tile = tiles.insert(tile, {modes->length_m, {}});
        for (const ExplicitMode& mode : modes->modes)
            tile->amplitudes_m[{mode.nx, mode.ny}] +=
                mode.amplitude_m * std::polar(1.0, mode.phase_rad);
    }
    return tiles;
}

} // namespace

void each_given_wave(const SeaState& sea, const std::function<void(const GivenWave&)>& tell) {
    const Dispersion dispersion = sea.dispersion();
    for (const ModesOfTile& tile : modes_by_tile(sea))
        for (const auto& [at, amplitude_m] : tile.amplitudes_m) {
            const double k = two_pi / tile.length_m * std::hypot(at.first, at.second);
            const double amplitude = sea.height_scale * std::abs(amplitude_m);
            if (k > 0.0 && amplitude > 0.0)
                tell({tile.length_m, 0.5 * amplitude * amplitude, dispersion.omega(k), k,
                      std::atan2(at.second, at.first), false, true});
        }
    for (std::size_t s = 0; s < sea.systems.size(); ++s) {
        const auto* ramps = std::get_if<SineRamps>(&sea.systems[s]);
        if (!ramps)
            continue;
        SineField field = sine_field(*ramps, sea.seed, static_cast<std::uint32_t>(s), dispersion,
                                     sea.height_scale, 0);
        for (NoiseOctave& octave : field.octaves)
            octave.variance = noise_variance;
        for (const SineLine& line : sine_lines(field))
            if (line.variance_m2() > 0.0)
                tell({field.length_m, line.variance_m2(), line.omega_radps,
                      std::hypot(line.kx_radpm, line.ky_radpm),
                      std::atan2(line.ky_radpm, line.kx_radpm), true, !line.octave});
    }
}

} // namespace seaway::sea
