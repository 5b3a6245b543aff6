// SPDX-License-Identifier: Apache-2.0
#include "sea/waves/spectrum_builder.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include <fmt/format.h>

#include "sea/waves/realize.h"
#include "sea/waves/sine_limits.h"

namespace seaway::sea {

namespace {

Result<void> holds_rate(double omega_radps) {
    if (omega_radps <= rate_omega_max_radps)
        return {};
    return Error{
        fmt::format("a wave of {} rad/s, {} is the most", omega_radps, rate_omega_max_radps)};
}

} // namespace

Result<SpectrumBuilder> SpectrumBuilder::create(const SpectrumFrame& frame,
                                                const SpectrumSteps& steps) {
    std::size_t points = 0;
    for (const SpectrumFrame::Tile& tile : frame.tiles)
        points +=
            static_cast<std::size_t>(tile.spec.size) * static_cast<std::size_t>(tile.spec.size);
    if (points > spectrum_modes_max)
        return Error{fmt::format("tiles of {} points together, a spectrum has {} at most", points,
                                 spectrum_modes_max)};
    SpectrumBuilder builder;
    builder.dispersion_ = frame.dispersion;
    builder.steps_ = steps;
    builder.sea_.choppiness = frame.choppiness;
    builder.sea_.loop_period_us = frame.loop_period_us;
    for (const SpectrumFrame::Tile& tile : frame.tiles) {
        CascadeModes& modes = builder.sea_.cascades.emplace_back();
        modes.spec = tile.spec;
        modes.band = tile.band;
        modes.depth_m = frame.dispersion.depth_m;
        modes.h0.resize(static_cast<std::size_t>(tile.spec.size) *
                        static_cast<std::size_t>(tile.spec.size));
        modes.rate.resize(modes.h0.size());
        modes.carries_spectra = tile.carries_spectra;
        if (!tile.carries_spectra)
            continue;
        SEAWAY_TRY(holds_rate(frame.dispersion.omega(
            std::min(tile.band.k_hi_radpm, std::numbers::sqrt2 * tile.spec.nyquist_radpm()))));
        fill_rates(modes, frame.dispersion, frame.loop_period_us);
    }
    return builder;
}

Result<void> SpectrumBuilder::add(const WaveBlock& block) {
    if (block.cascade < 0 || static_cast<std::size_t>(block.cascade) >= sea_.cascades.size())
        return Error{fmt::format("waves of cascade {}, the sea has {}", block.cascade,
                                 sea_.cascades.size())};
    for (int j = 0; j < WaveBlock::side; ++j)
        for (int i = 0; i < WaveBlock::side; ++i)
            SEAWAY_TRY(put(block, i, j));
    return {};
}

Result<void> SpectrumBuilder::put(const WaveBlock& block, int i, int j) {
    const auto place = 2 * static_cast<std::size_t>(j * WaveBlock::side + i);
    const int real = block.codes[place], imaginary = block.codes[place + 1];
    CascadeModes& modes = sea_.cascades[static_cast<std::size_t>(block.cascade)];
    const int size = modes.spec.size;
    const int nx = WaveBlock::side * block.bx + i, ny = WaveBlock::side * block.by + j;
    const bool there = std::abs(nx) < size / 2 && std::abs(ny) < size / 2 && (nx != 0 || ny != 0);
    if (!there) {
        if (real == 0 && imaginary == 0)
            return {};
        return Error{
            fmt::format("a wave ({}, {}), which a lattice of {} does not have", nx, ny, size)};
    }
    const auto at = [size](int x, int y) {
        return static_cast<std::size_t>((y + size) % size * size + (x + size) % size);
    };
    if (real == 0 && imaginary == 0)
        return {};
    const std::size_t index = at(nx, ny);
    const double k_radpm =
        modes.spec.wavenumber_step_radpm() * std::sqrt(static_cast<double>(nx * nx + ny * ny));
    const double omega_radps = dispersion_.omega(k_radpm);
    SEAWAY_TRY(holds_rate(omega_radps));
    const double step = steps_.of(k_radpm, block.shift);
    modes.h0[index] += std::complex(step * real, step * imaginary);
    modes.rate[index] = modes.rate[at(-nx, -ny)] = mode_rate(omega_radps, sea_.loop_period_us);
    if (block.given) {
        modes.given.resize(modes.h0.size());
        modes.given[index] = 1;
    }
    return {};
}

} // namespace seaway::sea
