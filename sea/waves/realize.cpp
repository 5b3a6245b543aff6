// SPDX-License-Identifier: Apache-2.0
#include "sea/waves/realize.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "sea/basics/gaussian.h"
#include "sea/waves/directional_spectrum.h"
#include "sea/waves/mode_variances.h"
#include "sea/waves/sine_limits.h"

namespace seaway::sea {

namespace {

/// The lattice indices of a band's waves lie within this many steps of 0 along each axis.
int steps_of_band(const CascadeSpec& spec, const Band& band) {
    return static_cast<int>(
        std::min(std::ceil(band.k_hi_radpm / spec.wavenumber_step_radpm()), 0.5 * spec.size - 1.0));
}

template <class F>
void for_each_mode_of_band(const CascadeSpec& spec, const Band& band, const F& f) {
    const int size = spec.size, steps = steps_of_band(spec, band);
    const double step = spec.wavenumber_step_radpm();
    for (int ny = -steps; ny <= steps; ++ny)
        for (int nx = -steps; nx <= steps; ++nx) {
            const double k = step * std::sqrt(nx * nx + ny * ny);
            if ((nx != 0 || ny != 0) && band.contains(k))
                f(nx, ny, k,
                  static_cast<std::size_t>((ny + size) % size * size + (nx + size) % size));
        }
}

/// Adds the waves of a spectrum to one cascade.
void add_spectrum(const DirectionalSpectrum& spectrum, std::uint64_t seed, std::uint32_t system,
                  CascadeModes& modes) {
    if (spectrum.empty())
        return;
    const std::vector<double> variances = mode_variances(spectrum, modes.spec, modes.band);
    const std::uint32_t tile = cascade_key(modes.spec.length_m);
    for_each_mode_of_band(modes.spec, modes.band, [&](int nx, int ny, double, std::size_t index) {
        if (!(variances[index] > 0.0))
            return;
        const double amplitude = 0.5 * std::sqrt(variances[index]);
        const GaussianPair xi = gaussian_pair({seed, system, tile, nx, ny});
        modes.h0[index] += std::complex(amplitude * xi.real, amplitude * xi.imaginary);
    });
}

} // namespace

/// Omega is computed once for each nx^2 + ny^2.
void fill_rates(CascadeModes& modes, const Dispersion& dispersion, TimeUs loop_period_us) {
    const Band band{modes.longest_radpm(), modes.band.k_hi_radpm};
    const int steps = steps_of_band(modes.spec, band);
    // Within the band's disc, and the corners that are looked at and left.
    std::vector<std::optional<Rate>> rates(static_cast<std::size_t>(2 * steps * steps + 1));
    for_each_mode_of_band(modes.spec, band, [&](int nx, int ny, double k, std::size_t index) {
        std::optional<Rate>& rate = rates[static_cast<std::size_t>(nx * nx + ny * ny)];
        if (!rate)
            rate = mode_rate(dispersion.omega(k), loop_period_us);
        modes.rate[index] = *rate;
    });
}

Rate mode_rate(double omega_radps, TimeUs loop_period_us) {
    SEAWAY_CHECK(omega_radps >= 0.0 && omega_radps <= rate_omega_max_radps,
                 "the reader refuses waves that turn faster than a rate holds");
    if (loop_period_us <= 0)
        return rate_from_omega(omega_radps);
    const auto period = static_cast<double>(loop_period_us);
    const double turns = std::max(1.0, std::round(omega_radps * period / (two_pi * 1e6)));
    // A loop shorter than two microseconds is nobody's; half a turn in each is all that a rate says.
    return static_cast<Rate>(std::min(turns * (0x1p64 / period) + 0.5, 0x1p63));
}

namespace {

/// Explicit and linear stylised waves of one system, in the same words.
struct PlacedModes {
    double length_m;
    std::vector<ExplicitMode> modes;
};

PlacedModes placed(const ExplicitModes& system, const SeaState&, std::uint32_t) {
    return {system.length_m, system.modes};
}

PlacedModes placed(const SineRamps& system, const SeaState& sea, std::uint32_t index) {
    PlacedModes result{system.length_m, {}};
    if (system.kind == SineKind::gerstner)
        for (const SineWave& wave : sine_waves(system, sea.seed, index, sea.dispersion()))
            result.modes.push_back({wave.nx, wave.ny, wave.amplitude_m, wave.phase_rad});
    return result;
}

int largest_step(const PlacedModes& system) {
    int steps = 0;
    for (const ExplicitMode& mode : system.modes)
        steps = std::max({steps, std::abs(mode.nx), std::abs(mode.ny)});
    return steps;
}

/// The largest lattice index of one system's explicit or stylised waves.
int steps_of(const WaveSystem& system, const SeaState& sea, std::uint32_t index) {
    const auto* ramps = std::get_if<SineRamps>(&system);
    if (ramps && ramps->kind != SineKind::gerstner)
        return std::max(static_cast<int>(std::ceil(sine_steps(*ramps))), 1);
    if (ramps)
        return largest_step(placed(*ramps, sea, index));
    const auto* modes = std::get_if<ExplicitModes>(&system);
    return modes ? largest_step(placed(*modes, sea, index)) : 0;
}

/// What a new tile has to hold: the waves of all systems of its length, whatever their order.
int steps_on_tile(const SeaState& sea, double length_m) {
    int steps = 1;
    for (std::size_t s = 0; s < sea.systems.size(); ++s)
        if (same_tile_length(explicit_length_m(sea.systems[s]), length_m))
            steps = std::max(steps, steps_of(sea.systems[s], sea, static_cast<std::uint32_t>(s)));
    return std::min(steps, explicit_steps_max);
}

/// The cascade of this length; if there is none, a new one of fitting size, longest tile first. It
/// owns no band of the spectra.
Result<CascadeModes*> tile_for(Realization& realization, const SeaState& sea, double length_m,
                               int steps) {
    for (CascadeModes& cascade : realization.cascades)
        if (same_tile_length(cascade.spec.length_m, length_m)) {
            if (steps > cascade.spec.size / 2 - 1)
                return Error{fmt::format("explicit waves reach lattice index {}, but the cascade "
                                         "of length_m = {} has size = {} and holds {} at most",
                                         steps, length_m, cascade.spec.size,
                                         cascade.spec.size / 2 - 1)};
            return &cascade;
        }
    if (steps > explicit_steps_max)
        return Error{fmt::format("explicit waves reach lattice index {}; allowed: at most {}",
                                 steps, explicit_steps_max)};
    steps = steps_on_tile(sea, length_m);
    const CascadeSpec spec{length_m, explicit_tile_size(steps)};
    const auto points = static_cast<std::size_t>(spec.size) * static_cast<std::size_t>(spec.size);
    const double step = spec.wavenumber_step_radpm();
    CascadeModes tile;
    tile.spec = spec;
    tile.band = {0.5 * step, (steps + 0.5) * std::sqrt(2.0) * step};
    tile.h0.resize(points);
    tile.rate.resize(points);
    tile.carries_spectra = false;
    auto after = realization.cascades.begin();
    while (after != realization.cascades.end() && after->spec.length_m > length_m)
        ++after;
    return &*realization.cascades.insert(after, std::move(tile));
}

void place(CascadeModes& tile, const ExplicitMode& mode, const SeaState& sea,
           TimeUs loop_period_us) {
    const int size = tile.spec.size;
    const auto at = [size](int nx, int ny) {
        return static_cast<std::size_t>((ny + size) % size * size + (nx + size) % size);
    };
    const double k = tile.spec.wavenumber_step_radpm() *
                     std::sqrt(static_cast<double>(mode.nx * mode.nx + mode.ny * mode.ny));
    const Rate rate = mode_rate(sea.dispersion().omega(k), loop_period_us);
    tile.rate[at(mode.nx, mode.ny)] = rate;
    tile.rate[at(-mode.nx, -mode.ny)] = rate;
    tile.placed_from_radpm = std::min(tile.placed_from_radpm, k);
    const double amplitude = 0.5 * sea.height_scale * mode.amplitude_m; // may be negative
    tile.given.resize(tile.h0.size());
    tile.given[at(mode.nx, mode.ny)] = 1;
    tile.h0[at(mode.nx, mode.ny)] +=
        std::complex(amplitude * std::cos(mode.phase_rad), amplitude * std::sin(mode.phase_rad));
}

Result<void> add_placed(Realization& realization, const PlacedModes& system, const SeaState& sea) {
    const int steps = largest_step(system);
    if (steps == 0)
        return {};
    const Result<CascadeModes*> tile = tile_for(realization, sea, system.length_m, steps);
    if (!tile)
        return tile.error();
    for (const ExplicitMode& mode : system.modes)
        place(**tile, mode, sea, realization.loop_period_us);
    return {};
}

Result<void> add_sine_field(Realization& realization, const SineRamps& ramps, const SeaState& sea,
                            std::uint32_t index) {
    const Result<CascadeModes*> tile =
        tile_for(realization, sea, ramps.length_m, steps_of(ramps, sea, index));
    if (!tile)
        return tile.error();
    // No octave of noise has a longer one than this, either.
    (*tile)->placed_from_radpm =
        std::min((*tile)->placed_from_radpm, 0.5 * (*tile)->spec.wavenumber_step_radpm());
    SineField field = sine_field(ramps, sea.seed, index, sea.dispersion(), sea.height_scale,
                                 realization.loop_period_us);
    field.number = static_cast<int>((*tile)->sines.size());
    (*tile)->sines.push_back(std::move(field));
    return {};
}

Result<void> add_explicit(Realization& realization, const SeaState& sea) {
    for (std::size_t s = 0; s < sea.systems.size(); ++s) {
        const auto index = static_cast<std::uint32_t>(s);
        Result<void> added;
        if (const auto* modes = std::get_if<ExplicitModes>(&sea.systems[s]))
            added = add_placed(realization, placed(*modes, sea, index), sea);
        else if (const auto* ramps = std::get_if<SineRamps>(&sea.systems[s]))
            added = ramps->kind == SineKind::gerstner
                        ? add_placed(realization, placed(*ramps, sea, index), sea)
                        : add_sine_field(realization, *ramps, sea, index);
        if (!added)
            return Error{fmt::format("sea.system[{}]: {}", s + 1, added.error().message)};
    }
    return {};
}

} // namespace

double explicit_length_m(const WaveSystem& system) {
    if (const auto* modes = std::get_if<ExplicitModes>(&system))
        return modes->length_m;
    if (const auto* ramps = std::get_if<SineRamps>(&system))
        return ramps->length_m;
    return 0.0;
}

bool same_tile_length(double held_m, double wanted_m) {
    return std::abs(held_m - wanted_m) < 1e-9 * wanted_m;
}

int explicit_tile_size(int steps) {
    int size = 64;
    while (band_end_share_of_nyquist * size / 2 < steps)
        size *= 2;
    return size;
}

namespace {

/// With the waves of these spectra, one a system, or of none.
Result<Realization> realize_with(const std::vector<DirectionalSpectrum>& spectra,
                                 const SeaState& sea, std::span<const CascadeSpec> cascades) {
    Result<std::vector<Band>> bands = assign_bands(cascades);
    if (!bands)
        return bands.error();
    Realization realization;
    realization.choppiness = sea.choppiness;
    realization.loop_period_us = us_from_seconds(sea.loop_period_s);
    for (std::size_t c = 0; c < cascades.size(); ++c) {
        const auto points =
            static_cast<std::size_t>(cascades[c].size) * static_cast<std::size_t>(cascades[c].size);
        CascadeModes& modes = realization.cascades.emplace_back();
        modes.spec = cascades[c];
        modes.band = (*bands)[c];
        modes.h0.resize(points);
        modes.rate.resize(points);
        for (std::size_t s = 0; s < spectra.size(); ++s)
            add_spectrum(spectra[s], sea.seed, static_cast<std::uint32_t>(s), modes);
    }
    SEAWAY_TRY(add_explicit(realization, sea));
    for (CascadeModes& modes : realization.cascades) {
        modes.depth_m = sea.depth_m;
        if (modes.carries_spectra) // from its longest wave on, which may be one that was placed
            fill_rates(modes, sea.dispersion(), realization.loop_period_us);
    }
    return realization;
}

} // namespace

Result<Realization> realize(const SeaState& sea, std::span<const CascadeSpec> cascades) {
    std::vector<DirectionalSpectrum> spectra;
    for (const WaveSystem& system : sea.systems)
        spectra.emplace_back(system, sea);
    return realize_with(spectra, sea, cascades);
}

std::optional<WaveLaw> wave_law(const SeaState& sea, const Realization& realization) {
    const auto has_sines = [](const CascadeModes& modes) { return !modes.sines.empty(); };
    if (std::ranges::any_of(realization.cascades, has_sines))
        return std::nullopt;
    return WaveLaw{sea.dispersion(), realization.loop_period_us};
}

Result<Realization> realize_clocks(const SeaState& sea, std::span<const CascadeSpec> cascades) {
    SEAWAY_TRY_LET(Realization clocks, realize_with({}, sea, cascades));
    for (CascadeModes& modes : clocks.cascades)
        modes.h0 = {};
    return clocks;
}

} // namespace seaway::sea
