// SPDX-License-Identifier: Apache-2.0
#include "sea/waves/reference.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "sea/basics/constants.h"

namespace seaway::sea {

namespace {

using Complex = std::complex<double>;

/// exp(i 2 pi n x / length) for n = 0 .. steps; each from its own sine and cosine.
std::vector<Complex> waves_along(double x_m, double length_m, int steps) {
    const double turns = std::fmod(x_m, length_m) / length_m;
    std::vector<Complex> waves(static_cast<std::size_t>(steps) + 1);
    for (int n = 0; n <= steps; ++n) {
        const double phase = two_pi * std::remainder(n * turns, 1.0);
        waves[static_cast<std::size_t>(n)] = {std::cos(phase), std::sin(phase)};
    }
    return waves;
}

/// std::complex multiplication without its NaN recovery.
Complex product(Complex a, Complex b) {
    return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}

} // namespace

DirectSum::DirectSum(RealizationPtr sea) : sea_(std::move(sea)) {
    SEAWAY_CHECK(sea_ != nullptr, "direct sum of no sea");
    for (const CascadeModes& cascade : sea_->cascades)
        add_cascade(cascade);
}

void DirectSum::add_cascade(const CascadeModes& cascade) {
    const int size = cascade.spec.size;
    const double step = cascade.spec.wavenumber_step_radpm();
    const auto index = [size](int nx, int ny) {
        return static_cast<std::size_t>((ny + size) % size * size + (nx + size) % size);
    };
    Tile& tile = tiles_.emplace_back(Tile{cascade.spec.length_m, 0, {}});
    for (int ny = 0; ny < size / 2; ++ny) {
        const std::size_t begin = modes_.size();
        for (int nx = ny == 0 ? 1 : 1 - size / 2; nx < size / 2; ++nx) {
            const std::size_t i = index(nx, ny);
            const Complex h0 = cascade.h0[i];
            const Complex h0_opposite = cascade.h0[index(-nx, -ny)];
            if (h0 == Complex{} && h0_opposite == Complex{})
                continue;
            modes_.push_back({step * nx, cascade.displacement_over_k(step * std::hypot(nx, ny)), nx,
                              cascade.is_given(i) || cascade.is_given(index(-nx, -ny))});
            phases_.push_back({h0, h0_opposite, cascade.rate[i], omega_from_rate(cascade.rate[i])});
            tile.steps_max = std::max({tile.steps_max, std::abs(nx), ny});
        }
        if (modes_.size() > begin)
            tile.rows.push_back({ny, step * ny, begin, modes_.size()});
    }
}

DirectSum::Moment DirectSum::at_time(TimeUs time_us) const {
    Moment moment;
    moment.sum_ = this;
    moment.height_.reserve(modes_.size());
    moment.rate_.reserve(modes_.size());
    const TimeUs t = sea_->phase_time(time_us);
    moment.phase_time_ = t;
    for (const Phase& wave : phases_) {
        const double phase = phase_rad(wave.rate, t);
        const Complex turn{std::cos(phase), -std::sin(phase)};
        const Complex forward = product(wave.h0, turn);
        const Complex backward = std::conj(product(wave.h0_opposite, turn));
        moment.height_.push_back(forward + backward);
        moment.rate_.push_back(Complex(0.0, wave.omega_radps) * (backward - forward));
    }
    return moment;
}

LagrangianPoint DirectSum::Moment::at(double x_m, double y_m) const {
    LagrangianPoint point;
    for (const Tile& tile : sum_->tiles_) {
        const std::vector<Complex> along_x = waves_along(x_m, tile.length_m, tile.steps_max);
        const std::vector<Complex> along_y = waves_along(y_m, tile.length_m, tile.steps_max);
        for (const Row& row : tile.rows) {
            // Sums over the row of h, kx h, h/k, kx h/k, kx^2 h/k, and of dh/dt likewise; 1/k stands
            // for coth(kd)/k.
            Complex h, kx_h, h_k, kx_h_k, kxx_h_k, r, r_k, kx_r_k;
            for (std::size_t m = row.begin; m < row.end; ++m) {
                const Mode& mode = sum_->modes_[m];
                const Complex wave = along_x[static_cast<std::size_t>(std::abs(mode.nx))];
                const Complex e = mode.nx < 0 ? std::conj(wave) : wave;
                const Complex height = product(height_[m], e);
                const Complex rate = product(rate_[m], e);
                const Complex height_k = height * mode.displacement_over_k_m;
                const Complex rate_k = rate * mode.displacement_over_k_m;
                h += height;
                kx_h += mode.kx_radpm * height;
                h_k += height_k;
                kx_h_k += mode.kx_radpm * height_k;
                kxx_h_k += mode.kx_radpm * mode.kx_radpm * height_k;
                r += rate;
                r_k += rate_k;
                kx_r_k += mode.kx_radpm * rate_k;
            }
            // k and -k together: twice the real part; +i z has real part -imag z.
            const Complex e = along_y[static_cast<std::size_t>(row.ny)];
            const double ky = row.ky_radpm;
            point.height += 2.0 * product(h, e).real();
            point.displacement_x -= 2.0 * product(kx_h_k, e).imag();
            point.displacement_y -= 2.0 * ky * product(h_k, e).imag();
            point.height_rate += 2.0 * product(r, e).real();
            point.displacement_x_rate -= 2.0 * product(kx_r_k, e).imag();
            point.displacement_y_rate -= 2.0 * ky * product(r_k, e).imag();
            point.slope_x -= 2.0 * product(kx_h, e).imag();
            point.slope_y -= 2.0 * ky * product(h, e).imag();
            point.strain_xx -= 2.0 * product(kxx_h_k, e).real();
            point.strain_yy -= 2.0 * ky * ky * product(h_k, e).real();
            point.strain_xy -= 2.0 * ky * product(kx_h_k, e).real();
        }
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
