// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstdlib>
#include <span>
#include <vector>

#include "sea/basics/constants.h"
#include "sea/waves/reference.h"

namespace seaway::sea {

namespace {

using Complex = std::complex<double>;

/// exp(i 2 pi n step / count), exactly periodic.
Complex turn(long n, long step, long count) {
    const double phase =
        two_pi * static_cast<double>(n * (step % count) % count) / static_cast<double>(count);
    return {std::cos(phase), std::sin(phase)};
}

/// Columns that are summed together, so that a wave is fetched from memory once for all of them.
constexpr int together = 4;

/// A complex number for each of them.
struct Columns {
    std::array<double, together> real{}, imag{};
};

/// Sums over a row of waves.
struct RowSums {
    Columns kx_h_k, h_k, h; ///< of kx h/k, h/k and h
};

template <class Mode>
RowSums row_sums(std::span<const Mode> modes, const Complex* heights, const Columns* along_x) {
    RowSums sums;
    for (const Mode& mode : modes) {
        const Complex h = *heights++;
        const Columns& wave = along_x[std::abs(mode.nx)];
        const double side = mode.nx < 0 ? -1.0 : 1.0; // of a wave to the west the conjugate
        for (std::size_t c = 0; c < together; ++c) {
            const double imag = side * wave.imag[c];
            const double height_real = h.real() * wave.real[c] - h.imag() * imag;
            const double height_imag = h.real() * imag + h.imag() * wave.real[c];
            const double real_k = height_real * mode.displacement_over_k_m;
            const double imag_k = height_imag * mode.displacement_over_k_m;
            sums.h.real[c] += height_real;
            sums.h.imag[c] += height_imag;
            sums.h_k.real[c] += real_k;
            sums.h_k.imag[c] += imag_k;
            sums.kx_h_k.real[c] += mode.kx_radpm * real_k;
            sums.kx_h_k.imag[c] += mode.kx_radpm * imag_k;
        }
    }
    return sums;
}

/// Displacement and height where a line of y meets the columns; e: a number for each row of waves.
struct Crossings {
    std::array<double, together> east{}, north{}, up{};

    void add(const RowSums& row, double ky_radpm, Complex e) {
        // k and -k together; +i z has real part -imag z.
        for (std::size_t c = 0; c < together; ++c) {
            const double north_real = ky_radpm * row.h_k.real[c];
            const double north_imag = ky_radpm * row.h_k.imag[c];
            east[c] -= 2.0 * (row.kx_h_k.real[c] * e.imag() + row.kx_h_k.imag[c] * e.real());
            north[c] -= 2.0 * (north_real * e.imag() + north_imag * e.real());
            up[c] += 2.0 * (row.h.real[c] * e.real() - row.h.imag[c] * e.imag());
        }
    }
    void write(int column, int row, SheetPatch& patch) const {
        for (int c = 0; c < std::min(together, patch.x.count - column); ++c) {
            const std::size_t at = patch.at(column + c, row);
            const auto from = static_cast<std::size_t>(c);
            patch.moved[2 * at] = static_cast<float>(east[from]);
            patch.moved[2 * at + 1] = static_cast<float>(north[from]);
            patch.height[at] = static_cast<float>(up[from]);
        }
    }
};

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

    std::vector<Columns> along_x(static_cast<std::size_t>(tile.steps_max) + 1);
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
    std::vector<RowSums> sums(tile.rows.size());
    for (int i = 0; i < patch.x.count; i += together) {
        for (std::size_t n = 0; n < along_x.size(); ++n)
            for (std::size_t c = 0; c < together; ++c) {
                const Complex wave =
                    x_share[n] *
                    turn(static_cast<long>(n), patch.x.first + i + static_cast<long>(c), count);
                along_x[n].real[c] = wave.real();
                along_x[n].imag[c] = wave.imag();
            }
        for (std::size_t r = 0; r < sums.size(); ++r) {
            const std::size_t begin = tile.rows[r].begin;
            sums[r] = row_sums(std::span(sum_->modes_).subspan(begin, tile.rows[r].end - begin),
                               height_.data() + begin, along_x.data());
        }
        for (int j = 0; j < patch.y.count; ++j) {
            const Complex* e = along_y.data() + static_cast<std::size_t>(j) * sums.size();
            Crossings crossings;
            for (std::size_t r = 0; r < sums.size(); ++r)
                crossings.add(sums[r], tile.rows[r].ky_radpm, e[r]);
            crossings.write(i, j, patch);
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
