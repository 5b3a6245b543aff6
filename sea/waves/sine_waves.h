// SPDX-License-Identifier: Apache-2.0
// Stylised seas: sums of a few sine, Gerstner or exponential-sine waves, or of octaves of noise,
// whose amplitude, wavenumber, speed and direction run along ramps (fractal sums) or stand in a
// list; exponential ones optionally with each wave dragged along by the ones before it.
//
// All wave vectors are snapped to the lattice of one tile, so the sea stays periodic. Gerstner
// waves are linear and move sideways as water does: they become modes. The others move up and down
// only, which no mode of a choppy sea does: height(X,t) is evaluated point by point, with exact
// derivatives (through the drag's chain rule) and with mean level zero (traps T52-T54).
//
// Pure functions; thread-safe.
#pragma once

#include <complex>
#include <cstdint>
#include <vector>

#include "sea/basics/dispersion.h"
#include "sea/basics/lagrangian_point.h"
#include "sea/basics/time.h"
#include "sea/waves/noise.h"

namespace seaway::sea {

enum class SineKind : std::uint8_t { sine, gerstner, exponential, noise };

/// One wave of a list in physical units.
struct SineByHand {
    double wavelength_m; ///< 0.01 .. 1e6
    double amplitude_m;  ///< 0 .. 100
    double towards_rad;  ///< as given; the wave vector is snapped to the tile
    double phase_rad;    ///< eta = amplitude cos(k.X - w t + phase); of exp(p (cos - 1)) likewise
    double speed_mps = 0.0; ///< 0: that of its wavenumber
};

/// The ramps as a scene gives them. Wave i = 0 .. count-1 has
///   amplitude  amplitude_m * amplitude_ratio^i      (all scaled to add up to amplitude_m if
///                                                    `normalise`)
///   wavenumber 2 pi / wavelength_m * wavenumber_ratio^i, snapped to the tile
///   speed      that of its wavenumber * speed_ratio^i (not gerstner)
///   direction  towards_rad + i direction_step_rad + up to direction_spread_rad either way, drawn
///              for each wave
/// Or `by_hand`, which stands in place of all these.
struct SineRamps {
    SineKind kind = SineKind::gerstner;
    double length_m = 256.0;        ///< the tile, 0.1 .. 1e6
    int count = 12;                 ///< 1 .. 64; noise 1 .. 16
    double amplitude_m = 1.0;       ///< 0 .. 100
    double wavelength_m = 64.0;     ///< of the longest wave
    double amplitude_ratio = 0.82;  ///< 0.01 .. 1
    double wavenumber_ratio = 1.18; ///< 1 .. 4
    double speed_ratio = 1.0;       ///< 0.1 .. 10
    double towards_rad = 0.0;
    double direction_step_rad = 0.0;   ///< -pi .. pi
    double direction_spread_rad = 0.5; ///< 0 .. pi
    bool normalise = true;
    double sharpness = 1.0; ///< p of exp(p (sin - 1)), exponential only, 0.1 .. 10
    /// Exponential only: the next waves are where a wave has dragged the point to, back along its way by this times what it rises
    /// by a radian of its phase. 0 .. 2
    double drag = 0.0;
    std::vector<SineByHand> by_hand; ///< sine, gerstner (without speeds), exponential
};

/// Lattice steps that a ramp may reach: tiles stay affordable.
inline constexpr int sine_steps_max = 200;
inline constexpr int sines_by_hand_max = 256;

/// Largest lattice index of the waves, as the size of their tile follows from it; above
/// sine_steps_max the reader refuses them. Noise counts four times: within half a wavelength it
/// turns as sharply as waves four times shorter.
double sine_steps(const SineRamps& ramps);

struct SineWave {
    int nx;
    int ny;
    double amplitude_m;
    double phase_rad;
    double omega_radps;
};

/// The waves of ramps or list; directions and phases of ramps are drawn from (seed, system, i).
/// Not of noise.
std::vector<SineWave> sine_waves(const SineRamps& ramps, std::uint64_t seed, std::uint32_t system,
                                 const Dispersion& dispersion);

/// By how much snapping to the tile changes the waves at most.
struct SineSnapping {
    double wavelength_share = 0.0; ///< |snapped / asked - 1|
    double direction_rad = 0.0;
};
SineSnapping sine_snapping(const SineRamps& ramps, std::uint64_t seed, std::uint32_t system);

/// A stylised sea that is evaluated point by point, on its tile.
struct SineField {
    struct Wave {
        double kx_radpm;
        double ky_radpm;
        double amplitude_m;
        double phase_rad;
        Rate rate;
        double omega_radps; ///< what `rate` stands for
        /// That a change of frequency on the way has left, 0.64 fixed point (sea/waves/transition.h).
        std::uint64_t phase_offset_turns = 0;

        /// By how much it has turned since time 0, wrapped.
        double turned_rad(TimeUs phase_time) const {
            return rad_from_turns(phase_turns(rate, phase_time) + phase_offset_turns);
        }
    };
    SineKind kind = SineKind::exponential; ///< not gerstner
    int number = 0;                        ///< of its tile's stylised systems, from 0
    double length_m = 0.0;
    double sharpness = 1.0;
    double drag = 0.0;
    /// Of all it adds, in a glide: smaller waves would drag others less.
    double share = 1.0;
    std::vector<Wave> waves;
    std::vector<NoiseOctave> octaves; ///< noise, in place of waves
};

/// Not of gerstner.
SineField sine_field(const SineRamps& ramps, std::uint64_t seed, std::uint32_t system,
                     const Dispersion& dispersion, double height_scale, TimeUs loop_period_us);

/// By how much a place may be moved, or a rounding grow, where each wave drags those that follow: the product of 1 + drag times its
/// largest second derivative. 1 without drag.
double drag_growth(const SineField& field);
/// Beyond it sums in double precision would say nothing.
inline constexpr double drag_growth_max = 1e6;

/// Height, its slopes and its rate at a point; the displacement is zero. `phase_time` as
/// Realization::phase_time gives it. About 0.1 us a wave, 0.03 us an octave.
LagrangianPoint sines_at(const SineField& field, double x_m, double y_m, TimeUs phase_time);

/// What a plane sine adds to a point where amplitude times cosine of its phase is `rise_m`, and
/// amplitude times sine `fall_m`.
inline void add_plane_wave(const SineField::Wave& wave, double rise_m, double fall_m,
                           LagrangianPoint& point) {
    point.height += rise_m;
    point.slope_x -= wave.kx_radpm * fall_m;
    point.slope_y -= wave.ky_radpm * fall_m;
    point.height_rate += wave.omega_radps * fall_m;
}

/// A wave, a harmonic of a sharp one, or an octave, as statistics see it, at one wavenumber, frequency and direction.
struct SineLine {
    /// Re(amplitude exp(i (k.x - w t))), t the phase time: lines of one k and w add up by it.
    std::complex<double> amplitude_m;
    double kx_radpm; ///< of an octave: of its rms slope, towards where it drifts
    double ky_radpm;
    double omega_radps;
    bool octave = false; ///< has a variance and no phase

    double variance_m2() const { return 0.5 * std::norm(amplitude_m); }
};
/// Drag moves waves about but hardly changes their height: it is left out.
std::vector<SineLine> sine_lines(const SineField& field);

/// A bound of |height|, m.
double sine_height_max_m(const SineField& field);

/// Mean of exp(p (sin q - 1)) over q, and its variance.
struct ExponentialSine {
    double mean;
    double variance;
};
ExponentialSine exponential_sine(double sharpness);

} // namespace seaway::sea
