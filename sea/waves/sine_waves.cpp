// SPDX-License-Identifier: Apache-2.0
#include "sea/waves/sine_waves.h"

#include <algorithm>
#include <cmath>

#include "sea/basics/constants.h"
#include "sea/basics/philox.h"
#include "sea/waves/realize.h"

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
    return ramps.length_m / ramps.wavelength_m * std::pow(ramps.wavenumber_ratio, ramps.count - 1);
}

std::vector<SineWave> sine_waves(const SineRamps& ramps, std::uint64_t seed, std::uint32_t system,
                                 const Dispersion& dispersion) {
    std::vector<SineWave> waves;
    double amplitude = ramps.amplitude_m;
    double steps = ramps.length_m / ramps.wavelength_m;
    double speed = 1.0;
    double sum = 0.0;
    for (int i = 0; i < ramps.count; ++i) {
        const PhiloxCounter words = philox4x32_10(
            {static_cast<std::uint32_t>(i), 0, system, sine_stream},
            {static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)});
        const double turn = (words[0] + 0.5) * 0x1p-31 - 1.0; // -1 .. 1
        const double direction = ramps.towards_rad + turn * ramps.direction_spread_rad;
        int nx = static_cast<int>(std::lround(steps * std::cos(direction)));
        const int ny = static_cast<int>(std::lround(steps * std::sin(direction)));
        if (nx == 0 && ny == 0)
            nx = 1; // longer than the tile: its fundamental
        const double k = two_pi / ramps.length_m * std::sqrt(nx * nx + ny * ny);
        waves.push_back({nx, ny, amplitude, two_pi * ((words[1] + 0.5) * 0x1p-32),
                         dispersion.omega(k) * speed});
        sum += amplitude;
        amplitude *= ramps.amplitude_ratio;
        steps *= ramps.wavenumber_ratio;
        speed *= ramps.speed_ratio;
    }
    if (ramps.normalise && sum > 0.0)
        for (SineWave& wave : waves)
            wave.amplitude_m *= ramps.amplitude_m / sum;
    return waves;
}

SineField sine_field(const SineRamps& ramps, const std::vector<SineWave>& waves,
                     double height_scale, TimeUs loop_period_us) {
    SineField field{ramps.length_m, ramps.sharpness, ramps.drag, {}};
    const double step = two_pi / ramps.length_m;
    for (const SineWave& wave : waves) {
        const Rate rate = mode_rate(wave.omega_radps, loop_period_us);
        field.waves.push_back({step * wave.nx, step * wave.ny, height_scale * wave.amplitude_m,
                               wave.phase_rad, rate, omega_from_rate(rate)});
    }
    return field;
}

ExponentialSine exponential_sine(double sharpness) {
    const double mean = scaled_bessel_i0(sharpness);
    return {mean, scaled_bessel_i0(2.0 * sharpness) - mean * mean};
}

LagrangianPoint sines_at(const SineField& field, double x_m, double y_m, TimeUs phase_time) {
    const double p = field.sharpness;
    const double mean = exponential_sine(p).mean;
    LagrangianPoint point;
    // The dragged position, its gradient over (X, Y) and its rate.
    double x = std::fmod(x_m, field.length_m), y = std::fmod(y_m, field.length_m);
    double x_x = 1.0, x_y = 0.0, y_x = 0.0, y_y = 1.0;
    double x_t = 0.0, y_t = 0.0;
    for (const SineField::Wave& wave : field.waves) {
        const double phase = wave.kx_radpm * x + wave.ky_radpm * y -
                             phase_rad(wave.rate, phase_time) + wave.phase_rad;
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

} // namespace seaway::sea
