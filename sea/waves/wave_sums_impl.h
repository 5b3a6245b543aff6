// SPDX-License-Identifier: Apache-2.0
// wave_sums.h for W doubles a vector. Included once per instruction set: all is of internal linkage,
// and nothing of the standard library is instantiated here.
//
// Derivatives of a pair, even cos(kx x) + odd sin(kx x), along x:
//     first   kx (odd cos - even sin),    second   -kx^2 (even cos + odd sin)
// The displacement is the gradient of the potential, the sum with coth(kd)/k h in place of h.
#pragma once

#include "sea/waves/wave_sums.h"

namespace seaway::sea {
namespace {

#define SEAWAY_INLINE [[gnu::always_inline]] inline

template <int W>
struct Vector {
    typedef double D __attribute__((vector_size(W * 8)));
    typedef double Held __attribute__((vector_size(W * 8), may_alias));
    typedef std::int64_t I __attribute__((vector_size(W * 8)));
    typedef std::uint64_t U __attribute__((vector_size(W * 8)));
    typedef std::uint64_t HeldU __attribute__((vector_size(W * 8), may_alias));
    static constexpr int parts = sum_lanes / W;
};

/// The lanes part * W and on.
template <int W>
SEAWAY_INLINE typename Vector<W>::D load(const Lanes& from, int part) {
    return *reinterpret_cast<const typename Vector<W>::Held*>(from.at + part * W);
}
template <int W>
SEAWAY_INLINE void store(Lanes& to, int part, typename Vector<W>::D value) {
    *reinterpret_cast<typename Vector<W>::Held*>(to.at + part * W) = value;
}

/// `from` is as aligned as Lanes are.
template <int W>
SEAWAY_INLINE typename Vector<W>::U load(const std::uint64_t* from, int part) {
    return *reinterpret_cast<const typename Vector<W>::HeldU*>(from + part * W);
}

/// In one order for every W.
SEAWAY_INLINE double total(const Lanes& v) {
    return ((v.at[0] + v.at[4]) + (v.at[2] + v.at[6])) +
           ((v.at[1] + v.at[5]) + (v.at[3] + v.at[7]));
}

template <int W>
struct Turned {
    typename Vector<W>::D cos, sin;
};

/// Cosine and sine of phases in turns, 0.64 fixed point: the nearest quarter by integer, what is left in
/// [-pi/4, pi/4] by their Taylor series, of which the next terms are below 5e-17.
template <int W>
SEAWAY_INLINE Turned<W> turned(typename Vector<W>::U turns) {
    using D = typename Vector<W>::D;
    using I = typename Vector<W>::I;
    using U = typename Vector<W>::U;
    constexpr double rad = 3.14159265358979323846 / 0x1p63;
    const U quarter = (turns + (std::uint64_t{1} << 61)) >> 62;
    const D x = __builtin_convertvector(I(turns - (quarter << 62)), D) * rad;
    const D xx = x * x;
    // Factors are one over products of two numbers that follow each other, from 16 to 1.
    D cos = 1.0 - xx * (1.0 / (16 * 15));
#pragma GCC unroll 8
    for (int n = 14; n > 0; n -= 2)
        cos = 1.0 - xx * cos * (1.0 / (n * (n - 1)));
    D sin = 1.0 - xx * (1.0 / (15 * 14));
#pragma GCC unroll 8
    for (int n = 13; n > 1; n -= 2)
        sin = 1.0 - xx * sin * (1.0 / (n * (n - 1)));
    sin *= x;
    const I odd = I(quarter << 63) != 0;
    const U cos_sign = ((quarter + 1) & 2) << 62, sin_sign = (quarter & 2) << 62;
    return {D(U(odd ? sin : cos) ^ cos_sign), D(U(odd ? cos : sin) ^ sin_sign)};
}

template <int W>
void turns_of(std::uint64_t phase, std::size_t blocks, Turns* out) {
    alignas(Lanes) constexpr std::uint64_t lanes[] = {0, 1, 2, 3, 4, 5, 6, 7};
    static_assert(sizeof lanes / sizeof *lanes == sum_lanes);
    for (std::size_t b = 0; b < blocks; ++b)
        for (int part = 0; part < Vector<W>::parts; ++part) {
            const Turned<W> wave = turned<W>((load<W>(lanes, part) + b * sum_lanes) * phase);
            store<W>(out[b].cos, part, wave.cos);
            store<W>(out[b].sin, part, wave.sin);
        }
}

/// A complex number a lane.
template <int W>
struct Complexes {
    typename Vector<W>::D real, imag;
};

/// Of one side: h = h0 exp(-i w t) + conj(h0(-k)) exp(i w t), and dh/dt.
template <int W>
SEAWAY_INLINE void evolve_side(const SpectrumBlock& waves, std::uint64_t time, int part,
                               Complexes<W>& height, Complexes<W>& rate) {
    using D = typename Vector<W>::D;
    const Turned<W> turn = turned<W>(load<W>(waves.rate, part) * time);
    const D real = load<W>(waves.h0[0], part), imag = load<W>(waves.h0[1], part);
    const D real_opposite = load<W>(waves.h0_opposite[0], part);
    const D imag_opposite = load<W>(waves.h0_opposite[1], part);
    const D forward_real = real * turn.cos + imag * turn.sin;
    const D forward_imag = imag * turn.cos - real * turn.sin;
    const D backward_real = real_opposite * turn.cos + imag_opposite * turn.sin;
    const D backward_imag = real_opposite * turn.sin - imag_opposite * turn.cos;
    const D omega = load<W>(waves.omega_radps, part);
    height = {forward_real + backward_real, forward_imag + backward_imag};
    rate = {omega * (forward_imag - backward_imag), omega * (backward_real - forward_real)};
}

template <int W>
SEAWAY_INLINE void join(const Complexes<W>& east, const Complexes<W>& west, int part,
                        PairBlock& pair) {
    store<W>(pair.even[0], part, east.real + west.real);
    store<W>(pair.even[1], part, east.imag + west.imag);
    store<W>(pair.odd[0], part, west.imag - east.imag);
    store<W>(pair.odd[1], part, east.real - west.real);
}

template <int W>
void evolve_pairs(const PairSpectrum* waves, std::size_t count, TimeUs time, PairBlock* height,
                  PairBlock* rate) {
    for (std::size_t b = 0; b < count; ++b)
        for (int part = 0; part < Vector<W>::parts; ++part) {
            Complexes<W> height_east, height_west, rate_east, rate_west;
            evolve_side<W>(waves[b].east, static_cast<std::uint64_t>(time), part, height_east,
                           rate_east);
            evolve_side<W>(waves[b].west, static_cast<std::uint64_t>(time), part, height_west,
                           rate_west);
            join<W>(height_east, height_west, part, height[b]);
            join<W>(rate_east, rate_west, part, rate[b]);
        }
}

/// Sums over a run: the real parts or the imaginary parts. _x, _xx: derivatives to x.
template <int W>
struct RunSums {
    using D = typename Vector<W>::D;
    D height{}, height_x{}, potential{}, potential_x{}, potential_xx{};
    D rate{}, potential_rate{}, potential_x_rate{};
};

template <int W>
SEAWAY_INLINE RunSums<W> run_sums(const TileWaves& tile, const WaveRun& run, const Turns* east,
                                  int imaginary, int part) {
    using D = typename Vector<W>::D;
    RunSums<W> sums;
    int at = run.first / sum_lanes;
    for (std::size_t b = run.begin; b < run.end; ++b, ++at) {
        const D cos = load<W>(east[at].cos, part), sin = load<W>(east[at].sin, part);
        const D kx = load<W>(tile.kx_radpm[at], part);
        const D over_k = load<W>(tile.displacement_over_k_m[b], part);
        const D kx_over_k = kx * over_k;
        const D even = load<W>(tile.height[b].even[imaginary], part);
        const D odd = load<W>(tile.height[b].odd[imaginary], part);
        const D height = even * cos + odd * sin, height_turned = odd * cos - even * sin;
        sums.height += height;
        sums.height_x += kx * height_turned;
        sums.potential += over_k * height;
        sums.potential_x += kx_over_k * height_turned;
        sums.potential_xx -= kx * kx_over_k * height;
        const D even_rate = load<W>(tile.rate[b].even[imaginary], part);
        const D odd_rate = load<W>(tile.rate[b].odd[imaginary], part);
        const D rate = even_rate * cos + odd_rate * sin;
        sums.rate += rate;
        sums.potential_rate += over_k * rate;
        sums.potential_x_rate += kx_over_k * (odd_rate * cos - even_rate * sin);
    }
    return sums;
}

/// The fields of half the plane of waves; the other half, its conjugate, makes them twice as large.
template <int W>
struct Fields {
    using D = typename Vector<W>::D;
    D height{}, displacement_x{}, displacement_y{};
    D height_rate{}, displacement_x_rate{}, displacement_y_rate{};
    D slope_x{}, slope_y{}, strain_xx{}, strain_yy{}, strain_xy{};

    SEAWAY_INLINE void add(const RunSums<W>& real, const RunSums<W>& imag, double ky, double cos,
                           double sin) {
        // The real part of the sum times exp(i ky y), and its derivative to y.
        const auto here = [&](D re, D im) { return re * cos - im * sin; };
        const auto to_y = [&](D re, D im) { return -ky * (re * sin + im * cos); };
        height += here(real.height, imag.height);
        slope_x += here(real.height_x, imag.height_x);
        slope_y += to_y(real.height, imag.height);
        height_rate += here(real.rate, imag.rate);
        const D potential = here(real.potential, imag.potential);
        displacement_x += here(real.potential_x, imag.potential_x);
        displacement_y += to_y(real.potential, imag.potential);
        strain_xx += here(real.potential_xx, imag.potential_xx);
        strain_yy -= ky * ky * potential;
        strain_xy += to_y(real.potential_x, imag.potential_x);
        displacement_x_rate += here(real.potential_x_rate, imag.potential_x_rate);
        displacement_y_rate += to_y(real.potential_rate, imag.potential_rate);
    }
};

template <int W>
void add_point(const TileWaves& tile, const Turns* east, const Turns* north,
               LagrangianPoint& point) {
    constexpr int parts = Vector<W>::parts;
    Fields<W> fields[parts];
    for (std::size_t r = 0; r < tile.run_count; ++r) {
        const WaveRun& run = tile.runs[r];
        const Turns& turns = north[run.ny / sum_lanes];
        const double cos = turns.cos.at[run.ny % sum_lanes];
        const double sin = turns.sin.at[run.ny % sum_lanes];
        for (int part = 0; part < parts; ++part)
            fields[part].add(run_sums<W>(tile, run, east, 0, part),
                             run_sums<W>(tile, run, east, 1, part), run.ky_radpm, cos, sin);
    }
    const auto twice = [&fields](typename Vector<W>::D Fields<W>::*field) {
        Lanes lanes;
        for (int part = 0; part < parts; ++part)
            store<W>(lanes, part, fields[part].*field);
        return 2.0 * total(lanes);
    };
    point.height += twice(&Fields<W>::height);
    point.displacement_x += twice(&Fields<W>::displacement_x);
    point.displacement_y += twice(&Fields<W>::displacement_y);
    point.height_rate += twice(&Fields<W>::height_rate);
    point.displacement_x_rate += twice(&Fields<W>::displacement_x_rate);
    point.displacement_y_rate += twice(&Fields<W>::displacement_y_rate);
    point.slope_x += twice(&Fields<W>::slope_x);
    point.slope_y += twice(&Fields<W>::slope_y);
    point.strain_xx += twice(&Fields<W>::strain_xx);
    point.strain_yy += twice(&Fields<W>::strain_yy);
    point.strain_xy += twice(&Fields<W>::strain_xy);
}

// ---- patches: a lane is a column ---------------------------------------------------------------

template <int W>
SEAWAY_INLINE void sum_columns_of(const TileWaves& tile, const WaveRun& run, const Turns* east,
                                  int part, ColumnSums& sums) {
    using D = typename Vector<W>::D;
    D height[2] = {}, potential[2] = {}, potential_x[2] = {};
    for (std::size_t b = run.begin; b < run.end; ++b) {
        const int first = run.first + static_cast<int>(b - run.begin) * sum_lanes;
        const Lanes& kx = tile.kx_radpm[first / sum_lanes];
        for (int lane = 0; lane < sum_lanes; ++lane) {
            const D cos = load<W>(east[first + lane].cos, part);
            const D sin = load<W>(east[first + lane].sin, part);
            const double over_k = tile.displacement_over_k_m[b].at[lane];
            const double kx_over_k = kx.at[lane] * over_k;
            for (int i = 0; i < 2; ++i) {
                const double even = tile.height[b].even[i].at[lane];
                const double odd = tile.height[b].odd[i].at[lane];
                const D here = even * cos + odd * sin;
                height[i] += here;
                potential[i] += over_k * here;
                potential_x[i] += kx_over_k * (odd * cos - even * sin);
            }
        }
    }
    for (int i = 0; i < 2; ++i) {
        store<W>(sums.height[i], part, height[i]);
        store<W>(sums.potential[i], part, potential[i]);
        store<W>(sums.potential_x[i], part, potential_x[i]);
    }
}

template <int W>
void sum_columns(const TileWaves& tile, const Turns* east, ColumnSums* sums) {
    for (std::size_t r = 0; r < tile.run_count; ++r)
        for (int part = 0; part < Vector<W>::parts; ++part)
            sum_columns_of<W>(tile, tile.runs[r], east, part, sums[r]);
}

template <int W>
void cross_columns(const TileWaves& tile, const ColumnSums* sums, const RunTurn* north,
                   Crossings& crossings) {
    using D = typename Vector<W>::D;
    for (int part = 0; part < Vector<W>::parts; ++part) {
        D east{}, to_north{}, up{};
        for (std::size_t r = 0; r < tile.run_count; ++r) {
            const double cos = north[r].cos, sin = north[r].sin;
            const D real = load<W>(sums[r].potential[0], part);
            const D imag = load<W>(sums[r].potential[1], part);
            east += load<W>(sums[r].potential_x[0], part) * cos -
                    load<W>(sums[r].potential_x[1], part) * sin;
            to_north -= tile.runs[r].ky_radpm * (real * sin + imag * cos);
            up += load<W>(sums[r].height[0], part) * cos - load<W>(sums[r].height[1], part) * sin;
        }
        store<W>(crossings.east, part, 2.0 * east);
        store<W>(crossings.north, part, 2.0 * to_north);
        store<W>(crossings.up, part, 2.0 * up);
    }
}

template <int W>
const WaveSums& sums_of() {
    static constexpr WaveSums sums{turns_of<W>, evolve_pairs<W>, add_point<W>, sum_columns<W>,
                                   cross_columns<W>};
    return sums;
}

} // namespace
} // namespace seaway::sea
