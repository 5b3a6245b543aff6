// SPDX-License-Identifier: Apache-2.0
#include "sea/waves/noise.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/check.h"
#include "sea/basics/constants.h"
#include "sea/basics/philox.h"

namespace seaway::sea {

namespace {

/// Counter words that no mode's key has (its cascade would be a tile of 4295 km), nor a sine's.
constexpr std::uint32_t noise_stream = 0xFFFFFFFEu;

/// Overlap of a corner's weight with itself and with its neighbour's: integral of u^2 + (1-u)^2, and
/// of u (1-u).
constexpr double overlap_self = 181.0 / 231.0;
constexpr double overlap_next = 25.0 / 231.0;

double smoothstep(double t) {
    return t * t * t * (10.0 + t * (-15.0 + 6.0 * t));
}
double smoothstep_slope(double t) {
    return 30.0 * t * t * (1.0 - t) * (1.0 - t);
}

std::vector<double> draw_corners(int cells, std::uint64_t seed, std::uint32_t system,
                                 std::uint32_t octave) {
    std::vector<double> corners;
    const auto count = static_cast<std::size_t>(cells) * static_cast<std::size_t>(cells);
    double sum = 0.0;
    for (std::uint32_t i = 0; i < count; ++i) {
        const PhiloxCounter words = philox4x32_10(
            {i, octave, system, noise_stream},
            {static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)});
        corners.push_back((words[0] + 0.5) * 0x1p-31 - 1.0);
        sum += corners.back();
    }
    for (double& corner : corners)
        corner -= sum / static_cast<double>(count);
    return corners;
}

/// Mean square over the tile of what the smoothsteps make of the corners.
double mean_square(const std::vector<double>& corners, int cells) {
    const auto at = [&](int ix, int iy) {
        return corners[static_cast<std::size_t>((iy + cells) % cells * cells +
                                                (ix + cells) % cells)];
    };
    double sum = 0.0;
    for (int iy = 0; iy < cells; ++iy)
        for (int ix = 0; ix < cells; ++ix)
            for (int dy = -1; dy <= 1; ++dy)
                for (int dx = -1; dx <= 1; ++dx)
                    sum += (dx == 0 ? overlap_self : overlap_next) *
                           (dy == 0 ? overlap_self : overlap_next) * at(ix, iy) *
                           at(ix + dx, iy + dy);
    return sum / static_cast<double>(corners.size());
}

/// Tiles a microsecond, modulo 1; negative ones wrap as two's complement does.
Rate drift_rate(double tiles_per_us, TimeUs loop_period_us, bool at_least_one) {
    if (loop_period_us > 0) {
        const auto period = static_cast<double>(loop_period_us);
        double tiles = std::round(tiles_per_us * period);
        if (tiles == 0.0 && at_least_one)
            tiles = tiles_per_us < 0.0 ? -1.0 : 1.0;
        tiles_per_us = tiles / period;
    }
    SEAWAY_CHECK(std::abs(tiles_per_us) < 0.5, "noise drifts by half a tile in a microsecond");
    const auto magnitude = static_cast<Rate>(std::abs(tiles_per_us) * 0x1p64 + 0.5);
    return tiles_per_us < 0.0 ? Rate{0} - magnitude : magnitude;
}

double speed_of(Rate rate, double length_m) {
    return static_cast<double>(static_cast<std::int64_t>(rate)) * 0x1p-64 * 1e6 * length_m;
}

/// Where a coordinate lies in the drifting pattern: cell and place within.
struct Place {
    std::size_t cell;
    std::size_t next;
    double within;
};
Place place_of(double x_m, double length_m, int cells, Rate rate, std::uint64_t offset,
               TimeUs phase_time) {
    const double drifted = static_cast<double>(offset - phase_turns(rate, phase_time)) * 0x1p-64;
    double tiles = std::fmod(x_m, length_m) / length_m + drifted;
    tiles -= std::floor(tiles);
    const double cell = std::min(tiles * cells, std::nextafter(static_cast<double>(cells), 0.0));
    const auto i = static_cast<std::size_t>(cell);
    return {i, (i + 1) % static_cast<std::size_t>(cells), cell - std::floor(cell)};
}

} // namespace

NoiseOctave noise_octave(int cells, double amplitude_m, double length_m, double speed_mps,
                         double towards_rad, std::uint64_t seed, std::uint32_t system,
                         std::uint32_t octave, TimeUs loop_period_us) {
    NoiseOctave made;
    made.cells = cells;
    made.amplitude_m = amplitude_m;
    std::vector<double> corners = draw_corners(cells, seed, system, octave);
    made.variance = mean_square(corners, cells);
    made.corners = std::make_shared<const std::vector<double>>(std::move(corners));
    const double tiles = speed_mps / length_m * 1e-6;
    const double east = tiles * std::cos(towards_rad), north = tiles * std::sin(towards_rad);
    made.rate_x = drift_rate(east, loop_period_us, std::abs(east) >= std::abs(north));
    made.rate_y = drift_rate(north, loop_period_us, std::abs(north) > std::abs(east));
    made.speed_x_mps = speed_of(made.rate_x, length_m);
    made.speed_y_mps = speed_of(made.rate_y, length_m);
    return made;
}

void add_noise(const NoiseOctave& octave, double length_m, double x_m, double y_m,
               TimeUs phase_time, LagrangianPoint& point) {
    const Place x =
        place_of(x_m, length_m, octave.cells, octave.rate_x, octave.offset_x, phase_time);
    const Place y =
        place_of(y_m, length_m, octave.cells, octave.rate_y, octave.offset_y, phase_time);
    const std::vector<double>& corners = *octave.corners;
    const auto side = static_cast<std::size_t>(octave.cells);
    const double v00 = corners[y.cell * side + x.cell], v10 = corners[y.cell * side + x.next];
    const double v01 = corners[y.next * side + x.cell], v11 = corners[y.next * side + x.next];
    const double ux = smoothstep(x.within), uy = smoothstep(y.within);
    const double low = v00 + ux * (v10 - v00), high = v01 + ux * (v11 - v01);
    const double per_metre = octave.amplitude_m * octave.cells / length_m;
    const double slope_x =
        per_metre * smoothstep_slope(x.within) * ((1.0 - uy) * (v10 - v00) + uy * (v11 - v01));
    const double slope_y = per_metre * smoothstep_slope(y.within) * (high - low);
    point.height += octave.amplitude_m * (low + uy * (high - low));
    point.slope_x += slope_x;
    point.slope_y += slope_y;
    point.height_rate -= octave.speed_x_mps * slope_x + octave.speed_y_mps * slope_y;
}

} // namespace seaway::sea
