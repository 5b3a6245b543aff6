// SPDX-License-Identifier: Apache-2.0
#include "sea/waves/sine_waves.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "sea/basics/constants.h"
#include "sea/basics/philox.h"
#include "sea/waves/realize.h"
#include "sea/waves/sine_limits.h"

namespace seaway::sea {

namespace {

/// Counter words that no mode's key has: its cascade would be a tile of 4295 km.
constexpr std::uint32_t sine_stream = 0xFFFFFFFFu;

/// Modified Bessel function I0(x) e^-x by its series; x 0 .. 20.
double scaled_bessel_i0(double x) {
    double term = 1.0;
    double sum = 1.0;
    for (int n = 1; n < 80; ++n) {
        term *= 0.25 * x * x / (n * n);
        sum += term;
    }
    return sum * std::exp(-x);
}

} // namespace

double sine_steps(const SineRamps& ramps) {
    double steps = 0.0;
    for (const SineByHand& wave : ramps.by_hand)
        steps = std::max(steps, ramps.length_m / wave.wavelength_m);
    if (ramps.by_hand.empty())
        steps =
            ramps.length_m / ramps.wavelength_m * std::pow(ramps.wavenumber_ratio, ramps.count - 1);
    return ramps.kind == SineKind::noise ? 4.0 * steps : steps;
}

namespace {

/// A wave as asked for, before it is snapped.
struct Asked {
    double steps; ///< wavelengths a tile
    double towards_rad;
    double amplitude_m;
    double phase_rad;
    double speed_ratio;
    double speed_mps; ///< 0: speed_ratio times that of its wavenumber
};

std::vector<Asked> asked_by_hand(const SineRamps& ramps) {
    // exp(p (sin - 1)) is highest a quarter turn later than a cosine.
    const double turn = ramps.kind == SineKind::exponential ? 0.5 * pi : 0.0;
    std::vector<Asked> waves;
    for (const SineByHand& wave : ramps.by_hand)
        waves.push_back({ramps.length_m / wave.wavelength_m, wave.towards_rad, wave.amplitude_m,
                         wave.phase_rad + turn, 1.0, wave.speed_mps});
    return waves;
}

std::vector<Asked> asked_waves(const SineRamps& ramps, std::uint64_t seed, std::uint32_t system) {
    if (!ramps.by_hand.empty())
        return asked_by_hand(ramps);
    std::vector<Asked> waves;
    double amplitude = ramps.amplitude_m;
    double steps = ramps.length_m / ramps.wavelength_m;
    double speed = 1.0;
    double sum = 0.0;
    for (int i = 0; i < ramps.count; ++i) {
        const PhiloxCounter words = philox4x32_10(
            {static_cast<std::uint32_t>(i), 0, system, sine_stream},
            {static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)});
        const double turn = (words[0] + 0.5) * 0x1p-31 - 1.0; // -1 .. 1
        waves.push_back(
            {steps,
             ramps.towards_rad + i * ramps.direction_step_rad + turn * ramps.direction_spread_rad,
             amplitude, two_pi * ((words[1] + 0.5) * 0x1p-32), speed, 0.0});
        sum += amplitude;
        amplitude *= ramps.amplitude_ratio;
        steps *= ramps.wavenumber_ratio;
        speed *= ramps.speed_ratio;
    }
    if (ramps.normalise && sum > 0.0)
        for (Asked& wave : waves)
            wave.amplitude_m *= ramps.amplitude_m / sum;
    return waves;
}

struct LatticeVector {
    int nx;
    int ny;
};
LatticeVector snapped(const Asked& wave) {
    const double east = std::cos(wave.towards_rad), north = std::sin(wave.towards_rad);
    const int nx = static_cast<int>(std::lround(wave.steps * east));
    const int ny = static_cast<int>(std::lround(wave.steps * north));
    if (nx != 0 || ny != 0)
        return {nx, ny};
    // Longer than the tile: along its nearest side.
    return std::abs(east) >= std::abs(north) ? LatticeVector{east < 0 ? -1 : 1, 0}
                                             : LatticeVector{0, north < 0 ? -1 : 1};
}

/// Octaves keep their direction; their cells are whole numbers, two to a wavelength.
int snapped_cells(const Asked& octave) {
    return std::max(2, static_cast<int>(std::lround(2.0 * octave.steps)));
}

} // namespace

std::vector<SineWave> sine_waves(const SineRamps& ramps, std::uint64_t seed, std::uint32_t system,
                                 const Dispersion& dispersion) {
    std::vector<SineWave> waves;
    for (const Asked& asked : asked_waves(ramps, seed, system)) {
        const auto [nx, ny] = snapped(asked);
        const double k = two_pi / ramps.length_m * std::hypot(nx, ny);
        const double omega =
            asked.speed_mps > 0.0 ? asked.speed_mps * k : dispersion.omega(k) * asked.speed_ratio;
        waves.push_back({nx, ny, asked.amplitude_m, asked.phase_rad, omega});
    }
    return waves;
}

namespace {

double noise_wavenumber(const Asked& octave, double length_m) {
    return pi * snapped_cells(octave) / length_m;
}

} // namespace

double fastest_sine_radps(const SineRamps& ramps, std::uint64_t seed, std::uint32_t system,
                          const Dispersion& dispersion) {
    double fastest = 0.0;
    if (ramps.kind != SineKind::noise) {
        for (const SineWave& wave : sine_waves(ramps, seed, system, dispersion))
            fastest = std::max(fastest, wave.omega_radps);
        return fastest;
    }
    for (const Asked& octave : asked_waves(ramps, seed, system))
        fastest = std::max(fastest, octave.speed_ratio *
                                        dispersion.omega(noise_wavenumber(octave, ramps.length_m)));
    return fastest;
}

SineSnapping sine_snapping(const SineRamps& ramps, std::uint64_t seed, std::uint32_t system) {
    SineSnapping most;
    for (const Asked& asked : asked_waves(ramps, seed, system)) {
        const auto [nx, ny] = snapped(asked);
        const bool noise = ramps.kind == SineKind::noise;
        const double steps = noise ? 0.5 * snapped_cells(asked) : std::hypot(nx, ny);
        const double turn =
            noise ? 0.0 : std::remainder(std::atan2(ny, nx) - asked.towards_rad, two_pi);
        most.wavelength_share =
            std::max(most.wavelength_share, std::abs(asked.steps / steps - 1.0));
        most.direction_rad = std::max(most.direction_rad, std::abs(turn));
    }
    return most;
}

SineField sine_field(const SineRamps& ramps, std::uint64_t seed, std::uint32_t system,
                     const Dispersion& dispersion, double height_scale, TimeUs loop_period_us) {
    SineField field;
    field.kind = ramps.kind;
    field.length_m = ramps.length_m;
    field.sharpness = ramps.sharpness;
    field.drag = ramps.drag;
    const double step = two_pi / ramps.length_m;
    if (ramps.kind == SineKind::noise) {
        std::uint32_t i = 0;
        for (const Asked& asked : asked_waves(ramps, seed, system)) {
            const int cells = snapped_cells(asked);
            const double k = noise_wavenumber(asked, ramps.length_m);
            field.octaves.push_back(
                noise_octave(cells, height_scale * asked.amplitude_m, ramps.length_m,
                             asked.speed_ratio * dispersion.omega(k) / k, asked.towards_rad, seed,
                             system, i++, loop_period_us));
        }
        return field;
    }
    for (const SineWave& wave : sine_waves(ramps, seed, system, dispersion)) {
        const Rate rate = mode_rate(wave.omega_radps, loop_period_us);
        field.waves.push_back({step * wave.nx, step * wave.ny, height_scale * wave.amplitude_m,
                               wave.phase_rad, rate, omega_from_rate(rate), 0});
    }
    return field;
}

double drag_growth(const SineField& field) {
    const double p = field.sharpness;
    // Of exp(p (sin q - 1)): |p^2 cos^2 q - p sin q| times it is at most p (1 + p), and p^2 cos^2 q times it 2 p / e.
    const double second = p * (1.0 + std::min(p, 1.0));
    double growth = 1.0;
    for (const SineField::Wave& wave : field.waves)
        growth *= 1.0 + field.drag * second * std::abs(wave.amplitude_m) *
                            std::hypot(wave.kx_radpm, wave.ky_radpm);
    return growth;
}

ExponentialSine exponential_sine(double sharpness) {
    const double mean = scaled_bessel_i0(sharpness);
    return {mean, scaled_bessel_i0(2.0 * sharpness) - mean * mean};
}

namespace {

/// Amplitudes of the harmonics of exp(p (cos q - 1)) = e^-p (I0(p) + 2 sum In(p) cos n q) (DLMF 10.35.2), from the first one
/// on; In / In-1 by its continued fraction (DLMF 10.33.1).
std::vector<double> exponential_harmonics(double p) {
    constexpr std::size_t count = 32; // of p = 10 the 32nd has 1e-17 of the slope
    std::array<double, count + 1> ratio{};
    for (std::size_t n = count; n >= 1; --n)
        ratio[n] = 1.0 / (2.0 * static_cast<double>(n) / p + (n < count ? ratio[n + 1] : 0.0));
    std::vector<double> amplitudes;
    double scaled = scaled_bessel_i0(p);
    for (std::size_t n = 1; n <= count; ++n) {
        scaled *= ratio[n];
        amplitudes.push_back(2.0 * scaled);
    }
    // Of what is not there nothing is to be summed.
    while (amplitudes.size() > 1 && amplitudes.back() < 1e-10 * amplitudes.front())
        amplitudes.pop_back();
    return amplitudes;
}

} // namespace

std::vector<SineLine> sine_lines(const SineField& field) {
    std::vector<SineLine> lines;
    const bool sharp = field.kind == SineKind::exponential;
    const std::vector<double> harmonics =
        sharp ? exponential_harmonics(field.sharpness) : std::vector<double>{1.0};
    for (const SineField::Wave& wave : field.waves) {
        const double phase_rad = wave.phase_rad - rad_from_turns(wave.phase_offset_turns) -
                                 (sharp ? 0.5 * pi : 0.0); // of a cosine
        double n = 0;
        for (const double harmonic : harmonics) {
            ++n;
            lines.push_back(
                {field.share * harmonic * wave.amplitude_m * std::polar(1.0, n * phase_rad),
                 n * wave.kx_radpm, n * wave.ky_radpm, n * wave.omega_radps});
        }
    }
    for (const NoiseOctave& octave : field.octaves) {
        const double k = noise_slope_cells * octave.cells / field.length_m;
        const double speed = std::hypot(octave.speed_x_mps, octave.speed_y_mps);
        // The slope along the drift is the rms slope over sqrt(2).
        lines.push_back({field.share * octave.amplitude_m * std::sqrt(2.0 * octave.variance),
                         speed > 0.0 ? k * octave.speed_x_mps / speed : k,
                         speed > 0.0 ? k * octave.speed_y_mps / speed : 0.0,
                         speed * k / std::numbers::sqrt2, true});
    }
    return lines;
}

double sine_height_max_m(const SineField& field) {
    double sum = 0.0;
    for (const SineField::Wave& wave : field.waves)
        sum += wave.amplitude_m;
    for (const NoiseOctave& octave : field.octaves)
        sum += 2.0 * octave.amplitude_m; // corners in -1 .. 1, less their mean
    return std::abs(field.share) * sum;
}

namespace {

LagrangianPoint plain_sines_at(const SineField& field, double x_m, double y_m, TimeUs phase_time) {
    LagrangianPoint point;
    const double x = std::fmod(x_m, field.length_m), y = std::fmod(y_m, field.length_m);
    for (const SineField::Wave& wave : field.waves) {
        const double phase =
            wave.kx_radpm * x + wave.ky_radpm * y - wave.turned_rad(phase_time) + wave.phase_rad;
        add_plane_wave(wave, wave.amplitude_m * std::cos(phase), wave.amplitude_m * std::sin(phase),
                       point);
    }
    return point;
}

/// Octaves of noise too, which stand in place of its waves.
LagrangianPoint dragged_sines_at(const SineField& field, double x_m, double y_m,
                                 TimeUs phase_time) {
    const double p = field.sharpness;
    const double mean = exponential_sine(p).mean;
    LagrangianPoint point;
    for (const NoiseOctave& octave : field.octaves)
        add_noise(octave, field.length_m, x_m, y_m, phase_time, point);
    // The dragged position, its gradient over (X, Y) and its rate.
    double x = std::fmod(x_m, field.length_m), y = std::fmod(y_m, field.length_m);
    double x_x = 1.0, x_y = 0.0, y_x = 0.0, y_y = 1.0;
    double x_t = 0.0, y_t = 0.0;
    for (const SineField::Wave& wave : field.waves) {
        const double phase =
            wave.kx_radpm * x + wave.ky_radpm * y - wave.turned_rad(phase_time) + wave.phase_rad;
        const double phase_x = wave.kx_radpm * x_x + wave.ky_radpm * y_x;
        const double phase_y = wave.kx_radpm * x_y + wave.ky_radpm * y_y;
        const double phase_t = wave.kx_radpm * x_t + wave.ky_radpm * y_t - wave.omega_radps;
        const double sine = std::sin(phase);
        const double cosine = std::cos(phase);
        const double value = wave.amplitude_m * std::exp(p * (sine - 1.0));
        const double first = p * cosine * value;
        const double second = (p * cosine * p * cosine - p * sine) * value;
        point.height += value - mean * wave.amplitude_m;
        point.slope_x += first * phase_x;
        point.slope_y += first * phase_y;
        point.height_rate += first * phase_t;
        if (field.drag <= 0.0)
            continue;
        const double k = std::hypot(wave.kx_radpm, wave.ky_radpm);
        const double east = -field.drag * wave.kx_radpm / k;
        const double north = -field.drag * wave.ky_radpm / k;
        x += east * first;
        y += north * first;
        x_x += east * second * phase_x;
        x_y += east * second * phase_y;
        y_x += north * second * phase_x;
        y_y += north * second * phase_y;
        x_t += east * second * phase_t;
        y_t += north * second * phase_t;
    }
    return point;
}

} // namespace

LagrangianPoint sines_at(const SineField& field, double x_m, double y_m, TimeUs phase_time) {
    LagrangianPoint point = field.kind == SineKind::sine
                                ? plain_sines_at(field, x_m, y_m, phase_time)
                                : dragged_sines_at(field, x_m, y_m, phase_time);
    for (double* part : {&point.height, &point.slope_x, &point.slope_y, &point.height_rate})
        *part *= field.share;
    return point;
}

} // namespace seaway::sea
