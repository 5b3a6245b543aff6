// SPDX-License-Identifier: Apache-2.0
#include "sea/waves/reference.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "sea/basics/constants.h"

namespace seaway::sea {

namespace {

using Complex = std::complex<double>;

/// std::complex multiplication without its NaN recovery.
Complex product(Complex a, Complex b) {
    return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}

/// exp(i 2 pi n x / length) for n = 0 .. 8 blocks - 1, to 1e-15: every eighth from its own sine and cosine,
/// times one of the first eight.
std::vector<Turns> turns_along(double x_m, double length_m, std::size_t blocks) {
    // The turns of the first wave, once more what rounding left of them; n times the first 30 bits is exact.
    const double rest_m = std::remainder(x_m, length_m);
    const double turns = rest_m / length_m;
    const double coarse = std::nearbyint(turns * 0x1p30) * 0x1p-30;
    const double fine = (turns - coarse) + std::fma(-turns, length_m, rest_m) / length_m;
    const auto wave = [=](double n) {
        const double phase = two_pi * ((n * coarse - std::nearbyint(n * coarse)) + n * fine);
        return Complex{std::cos(phase), std::sin(phase)};
    };
    std::array<Complex, sum_lanes> first;
    for (std::size_t n = 0; n < sum_lanes; ++n)
        first[n] = wave(static_cast<double>(n));
    std::vector<Turns> all(blocks);
    for (std::size_t b = 0; b < blocks; ++b) {
        const Complex eighth = wave(static_cast<double>(b * sum_lanes));
        for (std::size_t n = 0; n < sum_lanes; ++n) {
            const Complex turned = product(eighth, first[n]);
            all[b].cos.at[n] = turned.real();
            all[b].sin.at[n] = turned.imag();
        }
    }
    return all;
}

/// Adds h or dh/dt of a wave to its pair (wave_sums.h).
void add_to_pair(int nx, Complex value, PairBlock& block) {
    const double side = nx < 0 ? -1.0 : 1.0;
    const auto lane = static_cast<std::size_t>(std::abs(nx) % sum_lanes);
    block.even[0].at[lane] += value.real();
    block.even[1].at[lane] += value.imag();
    block.odd[0].at[lane] -= side * value.imag();
    block.odd[1].at[lane] += side * value.real();
}

/// exp(i 2 pi n / count), exactly periodic.
std::vector<Complex> circle_of(int count) {
    std::vector<Complex> circle;
    for (int n = 0; n < count; ++n) {
        const double phase = two_pi * n / count;
        circle.emplace_back(std::cos(phase), std::sin(phase));
    }
    return circle;
}

} // namespace

const WaveSums& wave_sums(Instructions instructions) {
#if defined(SEAWAY_X86)
    switch (instructions) {
    case Instructions::portable:
        break;
    case Instructions::avx2:
        return wave_sums_avx2();
    case Instructions::avx512:
        return wave_sums_avx512();
    }
#else
    SEAWAY_CHECK(instructions == Instructions::portable, "no other loops are built");
#endif
    return wave_sums_portable();
}

DirectSum::DirectSum(RealizationPtr sea, Instructions instructions)
    : sea_(std::move(sea)), sums_(&wave_sums(instructions)) {
    SEAWAY_CHECK(sea_ != nullptr, "direct sum of no sea");
    for (const CascadeModes& cascade : sea_->cascades)
        add_cascade(cascade);
}

void DirectSum::add_cascade(const CascadeModes& cascade) {
    const int size = cascade.spec.size;
    const double step = cascade.spec.wavenumber_step_radpm();
    Tile& tile = tiles_.emplace_back(
        Tile{cascade.spec.length_m, {}, {}, waves_.size(), circle_of(2 * cascade.spec.size)});
    int blocks = 0; // along an axis
    int next = 0;   // nx after the last block that is held
    for (int ny = 0; ny < size / 2; ++ny)
        for (int first = 0; first < size / 2; first += sum_lanes) {
            const std::size_t block = displacement_over_k_m_.size();
            const std::size_t waves_before = waves_.size();
            for (int nx = first; nx < first + sum_lanes; ++nx)
                add_pair(cascade, nx, ny);
            if (waves_.size() == waves_before)
                continue;
            Lanes& over_k_m = displacement_over_k_m_.emplace_back();
            for (int lane = 0; lane < sum_lanes; ++lane)
                if (first + lane > 0 || ny > 0)
                    over_k_m.at[lane] =
                        cascade.displacement_over_k(step * std::hypot(first + lane, ny));
            if (tile.runs.empty() || tile.runs.back().ny != ny || next != first)
                tile.runs.push_back({ny, first, block, block, step * ny});
            tile.runs.back().end = block + 1;
            next = first + sum_lanes;
            blocks = std::max({blocks, first / sum_lanes + 1, ny / sum_lanes + 1});
        }
    tile.kx_radpm.resize(static_cast<std::size_t>(blocks));
    for (int nx = 0; nx < blocks * sum_lanes; ++nx)
        tile.kx_radpm[static_cast<std::size_t>(nx / sum_lanes)].at[nx % sum_lanes] = step * nx;
}

/// The waves (nx, ny) and (-nx, ny), where they carry anything.
void DirectSum::add_pair(const CascadeModes& cascade, int nx, int ny) {
    const int size = cascade.spec.size;
    const auto index = [size](int x, int y) {
        return static_cast<std::size_t>((y + size) % size * size + (x + size) % size);
    };
    const auto add = [&](int x) {
        const std::size_t i = index(x, ny), opposite = index(-x, -ny);
        const Complex h0 = cascade.h0[i], h0_opposite = cascade.h0[opposite];
        if (h0 == Complex{} && h0_opposite == Complex{})
            return;
        waves_.push_back({h0, h0_opposite, cascade.rate[i], omega_from_rate(cascade.rate[i]), x, ny,
                          static_cast<std::uint32_t>(displacement_over_k_m_.size()),
                          cascade.is_given(i) || cascade.is_given(opposite)});
    };
    if (nx > 0 || ny > 0)
        add(nx);
    if (nx > 0 && ny > 0)
        add(-nx);
}

DirectSum::Moment DirectSum::at_time(TimeUs time_us) const {
    Moment moment;
    moment.sum_ = this;
    moment.height_.resize(displacement_over_k_m_.size());
    moment.rate_.resize(displacement_over_k_m_.size());
    const TimeUs t = sea_->phase_time(time_us);
    moment.phase_time_ = t;
    for (const Wave& wave : waves_) {
        const double phase = phase_rad(wave.rate, t);
        const Complex turn{std::cos(phase), -std::sin(phase)};
        const Complex forward = product(wave.h0, turn);
        const Complex backward = std::conj(product(wave.h0_opposite, turn));
        add_to_pair(wave.nx, forward + backward, moment.height_[wave.block]);
        add_to_pair(wave.nx, Complex(0.0, wave.omega_radps) * (backward - forward),
                    moment.rate_[wave.block]);
    }
    return moment;
}

TileWaves DirectSum::Moment::waves(std::size_t tile) const {
    const Tile& t = sum_->tiles_[tile];
    return {t.runs.data(),
            t.runs.size(),
            height_.data(),
            rate_.data(),
            sum_->displacement_over_k_m_.data(),
            t.kx_radpm.data()};
}

LagrangianPoint DirectSum::Moment::at(double x_m, double y_m) const {
    LagrangianPoint point;
    for (std::size_t t = 0; t < sum_->tiles_.size(); ++t) {
        const Tile& tile = sum_->tiles_[t];
        const std::vector<Turns> east = turns_along(x_m, tile.length_m, tile.kx_radpm.size());
        const std::vector<Turns> north = turns_along(y_m, tile.length_m, tile.kx_radpm.size());
        sum_->sums_->point(waves(t), east.data(), north.data(), point);
    }
    for (const CascadeModes& cascade : sum_->sea_->cascades)
        for (const SineField& field : cascade.sines) {
            const LagrangianPoint sines = sines_at(field, x_m, y_m, phase_time_);
            point.height += sines.height;
            point.height_rate += sines.height_rate;
            point.slope_x += sines.slope_x;
            point.slope_y += sines.slope_y;
        }
    return point;
}

} // namespace seaway::sea
