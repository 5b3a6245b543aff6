// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <vector>

#include "sea/basics/constants.h"
#include "sea/waves/reference.h"

namespace seaway::sea {

namespace {

using Complex = std::complex<double>;

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

/// Coefficients of splines through exp(i 2 pi n m / count), the waves on the lines m of a patch.
class LineWaves {
  public:
    /// circle: exp(i 2 pi n / count).
    explicit LineWaves(const std::vector<Complex>& circle)
        : circle_(circle), count_(static_cast<long>(circle.size())) {}

    double share(int n) const {
        return 1.0 / spline_response(two_pi * n / static_cast<double>(count_));
    }
    Complex at(int n, long line) const {
        const auto on_tile = static_cast<std::uint32_t>((line % count_ + count_) % count_);
        const auto n_wave = static_cast<std::uint32_t>(n);
        return circle_[n_wave * on_tile % static_cast<std::uint32_t>(count_)];
    }

  private:
    const std::vector<Complex>& circle_;
    long count_;
};

/// What a patch holds of a line of y where it meets the columns.
void write(const Crossings& crossings, int column, int row, SheetPatch& patch) {
    for (int c = 0; c < std::min(columns_together, patch.x.count - column); ++c) {
        const std::size_t at = patch.at(column + c, row);
        patch.moved[2 * at] = static_cast<float>(crossings.east.at[c]);
        patch.moved[2 * at + 1] = static_cast<float>(crossings.north.at[c]);
        patch.height[at] = static_cast<float>(crossings.up.at[c]);
    }
}

/// Of one wave of a pair and its conjugate at -k: twice |h(k,t)|.
double amplitude_m(const PairBlock& pair, int lane, bool west) {
    // h of the wave to the east is (even - i odd) / 2, of the one to the west (even + i odd) / 2.
    const double side = west ? -1.0 : 1.0;
    const double real = pair.even[0].at[lane] + side * pair.odd[1].at[lane];
    const double imag = pair.even[1].at[lane] - side * pair.odd[0].at[lane];
    return std::sqrt(real * real + imag * imag);
}

} // namespace

SheetPatch DirectSum::Moment::patch(int cascade, double x_low_m, double x_high_m, double y_low_m,
                                    double y_high_m) const {
    const auto c = static_cast<std::size_t>(cascade);
    const Tile& tile = sum_->tiles_[c];
    const TileWaves summed = waves(c);
    const LineWaves lines(tile.circle);
    const auto count = static_cast<int>(tile.circle.size());
    SheetPatch patch(x_low_m, x_high_m, y_low_m, y_high_m, tile.length_m / count, count);

    const std::size_t runs = summed.run_count;
    std::vector<RunTurn> north(runs * static_cast<std::size_t>(patch.y.count));
    for (std::size_t r = 0; r < runs; ++r) {
        const double share = lines.share(tile.runs[r].ny);
        for (int j = 0; j < patch.y.count; ++j) {
            const Complex wave = share * lines.at(tile.runs[r].ny, patch.y.first + j);
            north[static_cast<std::size_t>(j) * runs + r] = {wave.real(), wave.imag()};
        }
    }
    std::vector<Turns> east(tile.kx_radpm.size() * sum_lanes);
    std::vector<ColumnSums> sums(runs);
    for (int i = 0; i < patch.x.count; i += columns_together) {
        for (std::size_t n = 0; n < east.size(); ++n) {
            const double share = lines.share(static_cast<int>(n));
            for (int column = 0; column < columns_together; ++column) {
                const Complex wave =
                    share * lines.at(static_cast<int>(n), patch.x.first + i + column);
                east[n].cos.at[column] = wave.real();
                east[n].sin.at[column] = wave.imag();
            }
        }
        sum_->sums_->columns(summed, east.data(), sums.data());
        for (int j = 0; j < patch.y.count; ++j) {
            Crossings crossings;
            sum_->sums_->cross(summed, sums.data(),
                               north.data() + static_cast<std::size_t>(j) * runs, crossings);
            write(crossings, i, j, patch);
        }
    }
    return patch;
}

DirectSum::Moment::PatchScale DirectSum::Moment::patch_scale(int cascade) const {
    const auto c = static_cast<std::size_t>(cascade);
    const CascadeSpec& spec = sum_->sea_->cascades[c].spec;
    const double step = spec.wavenumber_step_radpm();
    const double q_step = 0.5 * spec.spacing_m() / two_pi * step;
    const auto fourth = [](double q) { return q * q * (q * q); };
    Bound displacement, missed, missed_height;
    if (!has(c))
        return {};
    for (const WaveRun& run : sum_->tiles_[c].runs)
        for (std::size_t b = run.begin; b < run.end; ++b)
            for (int lane = 0; lane < sum_lanes; ++lane) {
                const double nx = run.first + static_cast<int>(b - run.begin) * sum_lanes + lane;
                const double per_height = step * std::sqrt(nx * nx + run.ny * run.ny) *
                                          sum_->displacement_over_k_m_[b].at[lane];
                const double share = 4.33 * (fourth(nx * q_step) + fourth(run.ny * q_step));
                const Given given = sum_->given_[b];
                for (const bool west : {false, true}) {
                    const double height = amplitude_m(height_[b], lane, west);
                    const bool is_given = ((west ? given.west : given.east) >> lane & 1) != 0;
                    displacement.add(height * per_height, is_given);
                    missed.add(height * per_height * share, is_given);
                    missed_height.add(height * share, is_given);
                }
            }
    return {displacement.bound_m(), missed.bound_m(), missed_height.bound_m()};
}

} // namespace seaway::sea
