// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <complex>

#include "sea/basics/constants.h"
#include "sea/waves/reference.h"

namespace seaway::sea {

namespace {

using Complex = std::complex<double>;

/// std::complex multiplication without its NaN recovery.
Complex product(Complex a, Complex b) {
    return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}

/// exp(i 2 pi n step / count), exactly periodic.
Complex turn(long n, long step, long count) {
    const double phase =
        two_pi * static_cast<double>(n * (step % count) % count) / static_cast<double>(count);
    return {std::cos(phase), std::sin(phase)};
}

constexpr double sigmas = 6.0;

/// Of a sum of waves: those of random phases add in the square, those whose phases were given as they are.
class Bound {
  public:
    void add(double amplitude, bool given) {
        (given ? given_ : variance_) += given ? amplitude : 0.5 * amplitude * amplitude;
    }
    double bound_m() const { return sigmas * std::sqrt(variance_) + given_; }

  private:
    double variance_ = 0, given_ = 0;
};

/// A wave's own B-spline coefficients are the wave over this: phase step q between them.
double spline_response(double q) {
    return (2.0 + std::cos(q)) / 3.0;
}

} // namespace

SheetPatch DirectSum::Moment::patch(int cascade, double x_low_m, double x_high_m, double y_low_m,
                                    double y_high_m) const {
    const Tile& tile = sum_->tiles_[static_cast<std::size_t>(cascade)];
    const CascadeSpec& spec = sum_->sea_->cascades[static_cast<std::size_t>(cascade)].spec;
    const long count = 2L * spec.size;
    SheetPatch patch(x_low_m, x_high_m, y_low_m, y_high_m,
                     tile.length_m / static_cast<double>(count), static_cast<int>(count));

    std::vector<Complex> along_x(static_cast<std::size_t>(tile.steps_max) + 1);
    std::vector<double> x_share(along_x.size());
    for (std::size_t n = 0; n < along_x.size(); ++n)
        x_share[n] =
            1.0 / spline_response(two_pi * static_cast<double>(n) / static_cast<double>(count));
    std::vector<Complex> along_y(tile.rows.size() * static_cast<std::size_t>(patch.y.count));
    for (std::size_t r = 0; r < tile.rows.size(); ++r)
        for (int j = 0; j < patch.y.count; ++j)
            along_y[static_cast<std::size_t>(j) * tile.rows.size() + r] =
                turn(tile.rows[r].ny, patch.y.first + j, count) /
                spline_response(two_pi * tile.rows[r].ny / static_cast<double>(count));
    std::vector<Complex> east(tile.rows.size()), north(east.size()), up(east.size());
    for (int i = 0; i < patch.x.count; ++i) {
        for (std::size_t n = 0; n < along_x.size(); ++n)
            along_x[n] = turn(static_cast<long>(n), patch.x.first + i, count) * x_share[n];
        for (std::size_t r = 0; r < tile.rows.size(); ++r) {
            Complex h_k, kx_h_k, h; // sums over the row of h/k, kx h/k and h
            for (std::size_t m = tile.rows[r].begin; m < tile.rows[r].end; ++m) {
                const Mode& mode = sum_->modes_[m];
                const Complex wave = along_x[static_cast<std::size_t>(std::abs(mode.nx))];
                const Complex height = product(height_[m], mode.nx < 0 ? std::conj(wave) : wave);
                const Complex height_k = height * mode.displacement_over_k_m;
                h += height;
                h_k += height_k;
                kx_h_k += mode.kx_radpm * height_k;
            }
            east[r] = kx_h_k;
            north[r] = tile.rows[r].ky_radpm * h_k;
            up[r] = h;
        }
        for (int j = 0; j < patch.y.count; ++j) {
            const Complex* e = along_y.data() + static_cast<std::size_t>(j) * tile.rows.size();
            double dx = 0, dy = 0, z = 0; // k and -k together; +i z has real part -imag z
            for (std::size_t r = 0; r < tile.rows.size(); ++r) {
                dx -= 2.0 * (east[r].real() * e[r].imag() + east[r].imag() * e[r].real());
                dy -= 2.0 * (north[r].real() * e[r].imag() + north[r].imag() * e[r].real());
                z += 2.0 * (up[r].real() * e[r].real() - up[r].imag() * e[r].imag());
            }
            const std::size_t at = patch.at(i, j);
            patch.moved[2 * at] = static_cast<float>(dx);
            patch.moved[2 * at + 1] = static_cast<float>(dy);
            patch.height[at] = static_cast<float>(z);
        }
    }
    return patch;
}

DirectSum::Moment::PatchScale DirectSum::Moment::patch_scale(int cascade) const {
    const auto c = static_cast<std::size_t>(cascade);
    const double q_per_k = 0.5 * sum_->sea_->cascades[c].spec.spacing_m() / two_pi;
    Bound displacement, missed, missed_height;
    for (const Row& row : sum_->tiles_[c].rows)
        for (std::size_t m = row.begin; m < row.end; ++m) {
            const Mode& mode = sum_->modes_[m];
            const double per_height =
                std::hypot(mode.kx_radpm, row.ky_radpm) * mode.displacement_over_k_m;
            const double height = 2.0 * std::abs(height_[m]);
            const double share =
                4.33 * (std::pow(mode.kx_radpm * q_per_k, 4) + std::pow(row.ky_radpm * q_per_k, 4));
            displacement.add(height * per_height, mode.given);
            missed.add(height * per_height * share, mode.given);
            missed_height.add(height * share, mode.given);
        }
    return {displacement.bound_m(), missed.bound_m(), missed_height.bound_m()};
}

} // namespace seaway::sea
