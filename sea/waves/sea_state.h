// SPDX-License-Identifier: Apache-2.0
// The sea as a value: what blows, what rolls in, over what depth. SI units and radians; directions
// are where waves go, anticlockwise from east. Made by the scene reader, consumed by realize().
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "sea/basics/constants.h"
#include "sea/basics/dispersion.h"
#include "sea/spectrum/measured.h"
#include "sea/spectrum/spreading.h"
#include "sea/waves/realization.h"
#include "sea/waves/sine_waves.h"

namespace seaway::sea {

enum class SpectrumKind : std::uint8_t { jonswap, tma, pierson_moskowitz, phillips, bretschneider };

/// Waves raised by a wind over a fetch.
struct WindSea {
    SpectrumKind spectrum = SpectrumKind::jonswap; ///< not bretschneider, which has no wind
    double wind_speed_10m_mps = 0.0;               ///< 0 .. 100; 0 is a calm
    /// The wind as it was measured for pierson_moskowitz, where a scene gives it so; then the speed at
    /// 10 m follows from it and the spectrum is made from this one, to the bit.
    std::optional<double> wind_speed_19m5_mps;
    double towards_rad = 0.0;
    double fetch_m = std::numeric_limits<double>::infinity(); ///< jonswap, tma; infinite: grown
    double gamma = 3.3;                                       ///< peak enhancement, 1 .. 20
    double phillips_constant = 8.1e-3;                        ///< phillips: its A, 0 .. 1
    /// phillips, where a scene gives it so; then the constant follows from it, the wind and gravity.
    std::optional<double> significant_height_m;
    bool phillips_upwind = false; ///< phillips: cos^2 in both half planes, as Tessendorf 2001
    SpreadingModel spreading;
};

/// Waves given by height and period, whatever raised them.
struct Swell {
    SpectrumKind spectrum = SpectrumKind::jonswap; ///< jonswap | tma | bretschneider
    double significant_height_m = 0.0;             ///< before the depth factor of tma
    double peak_period_s = 10.0;
    double towards_rad = 0.0;
    double gamma = 3.3;
    SpreadingModel spreading;
};

/// A sea that was measured.
struct MeasuredSea {
    std::shared_ptr<const MeasuredSpectrum> spectrum;
    std::string csv; ///< the table it was read from
    /// What its a1, b1, a2, b2 mean; absent where they say nothing, or nobody said (then
    /// from_clockwise_north).
    std::optional<CoefficientFrame> coefficients;
    double towards_rad = 0.0; ///< these two only where the table has no directions
    SpreadingModel spreading;
};

/// One wave of a tile: eta = amplitude cos(k.X - w t + phase), k = 2 pi (nx, ny) / length.
struct ExplicitMode {
    int nx;
    int ny;
    double amplitude_m;
    double phase_rad;
};

/// Waves given one by one. They live on the cascade of this length, whatever its band.
struct ExplicitModes {
    double length_m = 0.0;
    std::vector<ExplicitMode> modes;
};

using WaveSystem = std::variant<WindSea, Swell, MeasuredSea, ExplicitModes, SineRamps>;

struct SeaState {
    std::uint64_t seed = 0;
    double depth_m = deep_water_m;
    Choppiness choppiness;
    double gravity_mps2 = gravity_default_mps2;
    bool surface_tension = true;
    double loop_period_s = 0.0;     ///< 0: never repeats
    double height_scale = 1.0;      ///< factor on all amplitudes of all systems, 0 .. 10
    double short_wave_fade_m = 0.0; ///< l: Psi is multiplied by exp(-(k l)^2)
    double wavenumber_min_radpm = 0.0;
    double wavenumber_max_radpm = std::numeric_limits<double>::infinity();
    std::vector<WaveSystem> systems; ///< their energies add

    Dispersion dispersion() const {
        return {gravity_mps2, surface_tension ? surface_tension_default_m3ps2 : 0.0, depth_m};
    }
};

} // namespace seaway::sea
