// SPDX-License-Identifier: Apache-2.0
#include "tests/load/brute_sheets.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include <fftw3.h>

#include "sea/surface/inverse.h"

namespace seaway::tests {

using sea::LagrangianPoint;
using sea::Vec2;
using Complex = std::complex<double>;

namespace {

constexpr int finer = 4;
constexpr int lattice_max = 2048;

typedef double Two __attribute__((vector_size(16)));

/// Weights of the four coefficients around fraction f of a cell, and their derivatives.
void weights(double f, double (&w)[4], double (&d)[4]) {
    const double g = 1 - f;
    w[0] = g * g * g / 6;
    w[1] = 2.0 / 3 - f * f + f * f * f / 2;
    w[2] = 2.0 / 3 - g * g + g * g * g / 2;
    w[3] = f * f * f / 6;
    d[0] = -g * g / 2;
    d[1] = -2 * f + 1.5 * f * f;
    d[2] = 2 * g - 1.5 * g * g;
    d[3] = f * f / 2;
}

/// Newton on X + lambda D(X) = target; false: it went astray.
template <class Field>
bool newton(const Field& field, const sea::Choppiness& l, Vec2 target, double tolerance_m,
            double step_max_m, Vec2& X, LagrangianPoint& p) {
    for (int step = 0; step < 30; ++step) {
        p = field(X);
        const Vec2 r{X.x + l.x * p.displacement_x - target.x,
                     X.y + l.y * p.displacement_y - target.y};
        if (std::hypot(r.x, r.y) < tolerance_m)
            return true;
        const double a = 1 + l.x * p.strain_xx, b = l.x * p.strain_xy;
        const double c = l.y * p.strain_xy, d = 1 + l.y * p.strain_yy;
        const double det = a * d - b * c;
        const Vec2 move{-(d * r.x - b * r.y) / det, -(a * r.y - c * r.x) / det};
        const double length_m = std::hypot(move.x, move.y);
        if (!(length_m < 1e9))
            return false;
        const double shorten = length_m > step_max_m ? step_max_m / length_m : 1.0;
        X = {X.x + shorten * move.x, X.y + shorten * move.y};
    }
    return false;
}

void add_once(std::vector<BruteSheet>& sheets, const BruteSheet& sheet, double apart_m) {
    for (const BruteSheet& other : sheets)
        if (std::hypot(other.at.x - sheet.at.x, other.at.y - sheet.at.y) < apart_m)
            return;
    sheets.push_back(sheet);
}

} // namespace

BruteTile::BruteTile(const sea::CascadeModes& modes, sea::TimeUs phase_time_us)
    : count_(std::max(std::min(finer * modes.spec.size, lattice_max), modes.spec.size)),
      length_m_(modes.spec.length_m) {
    const int size = modes.spec.size;
    const auto n = static_cast<std::size_t>(count_);
    const double step = modes.spec.wavenumber_step_radpm();
    // D_x + i D_y in one transform, the height in another.
    std::vector<Complex> moved(n * n), height(n * n);
    const auto response = [&](int index) {
        return (2 + std::cos(sea::two_pi * index / count_)) / 3;
    };
    for (int ny = 1 - size / 2; ny < size / 2; ++ny)
        for (int nx = 1 - size / 2; nx < size / 2; ++nx) {
            const auto at = [&](int x, int y) {
                return static_cast<std::size_t>((y + size) % size * size + (x + size) % size);
            };
            const Complex h0 = modes.h0[at(nx, ny)], opposite = modes.h0[at(-nx, -ny)];
            if ((nx == 0 && ny == 0) || (h0 == Complex{} && opposite == Complex{}))
                continue;
            const Complex turn =
                std::polar(1.0, -sea::phase_rad(modes.rate[at(nx, ny)], phase_time_us));
            const Complex h =
                (h0 * turn + std::conj(opposite * turn)) / (response(nx) * response(ny));
            const double over_k = modes.displacement_over_k(step * std::hypot(nx, ny));
            const Complex i(0, 1);
            const auto to = static_cast<std::size_t>((ny + count_) % count_) * n +
                            static_cast<std::size_t>((nx + count_) % count_);
            moved[to] = i * over_k * step * Complex(nx, ny) * h;
            height[to] = h;
        }
    for (std::vector<Complex>* values : {&moved, &height}) {
        auto* data = reinterpret_cast<fftw_complex*>(values->data());
        const fftw_plan plan =
            fftw_plan_dft_2d(count_, count_, data, data, FFTW_BACKWARD, FFTW_ESTIMATE);
        fftw_execute(plan);
        fftw_destroy_plan(plan);
    }
    coefficients_.resize(n * n);
    for (std::size_t i = 0; i < n * n; ++i) {
        coefficients_[i] = {moved[i].real(), moved[i].imag(), height[i].real(), 0.0};
        reach_m_ = std::max(reach_m_, std::abs(moved[i]));
    }
}

void BruteTile::add(LagrangianPoint& sum, double x_m, double y_m) const {
    const auto split = [&](double position_m, int(&lines)[4], double& fraction) {
        const double turns = position_m / length_m_;
        const double u = (turns - std::floor(turns)) * count_;
        const int line = std::min(static_cast<int>(u), count_ - 1);
        fraction = u - line;
        for (int i = 0; i < 4; ++i)
            lines[i] = (line - 1 + i + count_) % count_;
    };
    int column[4], row[4];
    double fx, fy, wx[4], dx[4], wy[4], dy[4];
    split(x_m, column, fx);
    split(y_m, row, fy);
    weights(fx, wx, dx);
    weights(fy, wy, dy);
    Two value[2]{}, by_x[2]{}, by_y[2]{};
    for (int j = 0; j < 4; ++j) {
        const auto* line = coefficients_.data() +
                           static_cast<std::size_t>(row[j]) * static_cast<std::size_t>(count_);
        Two v[2]{}, s[2]{};
        for (int i = 0; i < 4; ++i) {
            Two part[2];
            std::memcpy(part, line[column[i]].data(), sizeof part);
            for (int c = 0; c < 2; ++c) {
                v[c] += wx[i] * part[c];
                s[c] += dx[i] * part[c];
            }
        }
        for (int c = 0; c < 2; ++c) {
            value[c] += wy[j] * v[c];
            by_x[c] += wy[j] * s[c];
            by_y[c] += dy[j] * v[c];
        }
    }
    const double per_m = count_ / length_m_;
    sum.displacement_x += value[0][0];
    sum.displacement_y += value[0][1];
    sum.height += value[1][0];
    sum.strain_xx += per_m * by_x[0][0];
    sum.strain_yy += per_m * by_y[0][1];
    sum.strain_xy += 0.5 * per_m * (by_y[0][0] + by_x[0][1]);
}

BruteField::BruteField(const sea::Realization& sea, sea::TimeUs time_us)
    : choppiness_(sea.choppiness) {
    for (const sea::CascadeModes& modes : sea.cascades) {
        tiles_.emplace_back(modes, sea.phase_time(time_us));
        if (!(tiles_.back().reach_m() > 0)) {
            tiles_.pop_back();
            continue;
        }
        reach_m_ += choppiness_.largest() * tiles_.back().reach_m();
        finest_m_ = std::min(finest_m_, modes.spec.spacing_m());
    }
}

LagrangianPoint BruteField::at(Vec2 X) const {
    LagrangianPoint sum;
    for (const BruteTile& tile : tiles_)
        tile.add(sum, X.x, X.y);
    return sum;
}

BruteSheets::BruteSheets(const BruteField& field, Vec2 centre, double half_m)
    : field_(field), low_{centre.x - half_m, centre.y - half_m} {
    // Half of the finest spacing, unless the sea moves so far that no memory would hold it.
    constexpr int side_max = 3000;
    const double reach_m = half_m + field.reach_m();
    step_m_ = std::max(0.5 * field.finest_m(), 2 * reach_m / side_max);
    const int n = static_cast<int>(2 * reach_m / step_m_) + 2;
    bin_m_ = 2 * step_m_;
    bins_ = static_cast<int>(2 * half_m / bin_m_) + 1;
    starts_.resize(static_cast<std::size_t>(bins_) * static_cast<std::size_t>(bins_));

    std::vector<Vec2> above(static_cast<std::size_t>(n)), line(above.size());
    const auto X_of = [&](double i, double j) {
        return Vec2{centre.x - reach_m + i * step_m_, centre.y - reach_m + j * step_m_};
    };
    for (int j = 0; j < n; ++j) {
        std::swap(above, line);
        for (int i = 0; i < n; ++i) {
            const Vec2 X = X_of(i, j);
            const LagrangianPoint p = field.at(X);
            const Vec2 x = line[static_cast<std::size_t>(i)] = field.landed(X, p);
            if (std::abs(x.x - centre.x) < half_m && std::abs(x.y - centre.y) < half_m)
                places_.push_back({X, x, sea::jacobian(p, field.choppiness())});
        }
        for (int i = 0; j > 0 && i + 1 < n; ++i) {
            Vec2 low{1e30, 1e30}, high{-1e30, -1e30};
            for (const auto* row : {&above, &line})
                for (int k = 0; k < 2; ++k) {
                    const Vec2& x = (*row)[static_cast<std::size_t>(i + k)];
                    low = {std::min(low.x, x.x), std::min(low.y, x.y)};
                    high = {std::max(high.x, x.x), std::max(high.y, x.y)};
                }
            // The image of a cell is curved: as far again as it is wide, and half a cell.
            const double mx = high.x - low.x + 0.5 * step_m_, my = high.y - low.y + 0.5 * step_m_;
            const auto clipped = [&](double x_m, double low_m) {
                return static_cast<int>(std::clamp((x_m - low_m) / bin_m_, -1.0, bins_ + 0.0));
            };
            const int x0 = std::max(clipped(low.x - mx, low_.x), 0);
            const int x1 = std::min(clipped(high.x + mx, low_.x), bins_ - 1);
            const int y0 = std::max(clipped(low.y - my, low_.y), 0);
            const int y1 = std::min(clipped(high.y + my, low_.y), bins_ - 1);
            if (high.x + mx < low_.x || high.y + my < low_.y)
                continue;
            for (int y = y0; y <= y1; ++y)
                for (int x = x0; x <= x1; ++x)
                    starts_[static_cast<std::size_t>(y * bins_ + x)].push_back(
                        X_of(i + 0.5, j - 0.5));
        }
    }
}

std::size_t BruteSheets::bin(double x_m, double y_m) const {
    const auto along = [&](double position_m, double low_m) {
        return std::clamp(static_cast<int>((position_m - low_m) / bin_m_), 0, bins_ - 1);
    };
    return static_cast<std::size_t>(along(y_m, low_.y) * bins_ + along(x_m, low_.x));
}

std::vector<BruteSheet> BruteSheets::above(Vec2 target) const {
    std::vector<BruteSheet> sheets;
    const auto at = [&](Vec2 X) { return field_.at(X); };
    for (Vec2 X : starts_[bin(target.x, target.y)]) {
        const Vec2 start = X;
        LagrangianPoint p;
        // Every sheet lies in a cell that is started from.
        if (newton(at, field_.choppiness(), target, 1e-7, step_m_, X, p) &&
            std::hypot(X.x - start.x, X.y - start.y) < 4 * step_m_)
            add_once(sheets, {X, p.height, sea::jacobian(p, field_.choppiness())}, 1e-4);
    }
    return sheets;
}

double ends_within_m(const BruteField& field, const BruteSheet& sheet) {
    const sea::Choppiness& l = field.choppiness();
    const LagrangianPoint p = field.at(sheet.at);
    const double a = 1 + l.x * p.strain_xx, b = l.x * p.strain_xy;
    const double c = l.y * p.strain_xy, d = 1 + l.y * p.strain_yy;
    // Eigenvectors of A^T A: v belongs to the smaller one.
    const double half = 0.5 * (a * a + c * c - b * b - d * d), xy = a * b + c * d;
    const double angle = 0.5 * std::atan2(xy, half) + sea::two_pi / 4;
    const Vec2 v{std::cos(angle), std::sin(angle)};
    const double larger = std::hypot(-a * v.y + b * v.x, -c * v.y + d * v.x);
    const double s = sheet.jacobian / larger;
    const double step_m = 0.05 * field.finest_m();
    const auto j = [&](double off) {
        return sea::jacobian(field.at({sheet.at.x + off * v.x, sheet.at.y + off * v.y}), l);
    };
    const double bend_per_m = (j(step_m) - j(-step_m)) / (2 * step_m * larger);
    return s * s / (2 * std::max(std::abs(bend_per_m), 1e-9));
}

std::vector<BruteSheet> polish(const sea::DirectSum::Moment& moment, Vec2 target,
                               const std::vector<BruteSheet>& starts) {
    std::vector<BruteSheet> sheets;
    const auto at = [&](Vec2 X) { return moment.at(X.x, X.y); };
    const sea::Choppiness& l = moment.sea().choppiness;
    for (const BruteSheet& start : starts) {
        Vec2 X = start.at;
        LagrangianPoint p;
        if (newton(at, l, target, 1e-10, 1.0, X, p))
            add_once(sheets, {X, p.height, sea::jacobian(p, l)}, 1e-4);
    }
    return sheets;
}

} // namespace seaway::tests
