// SPDX-License-Identifier: Apache-2.0
#include "sea/waves/mode_variances.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>

#include "sea/basics/constants.h"

namespace seaway::sea {

namespace {

using Ring = DirectionalSpectrum::Ring;

/// Half the diagonal of a cell, in steps.
constexpr double cell_reach = 0.7072;
/// Around an edge of the spectrum or of the band, cells this many steps away are not smooth.
constexpr double edge_reach = 2.0;
/// Second difference over one step, as a share of the density, up to which a cell counts as smooth:
/// a Gaussian of three steps. Sums over a lattice of smoother functions are exact to 3e-3: so much of a
/// swell's steep front stays (0.05 leaves 1.3e-3, and costs 15 % more).
constexpr double second_difference_max = 0.1;
/// Lattice steps that the standard deviation of a beam must be wide.
constexpr double beam_steps_min = 2.0;
/// Circles lie this close, in steps and as a share of the wavenumber: a JONSWAP peak is 14 % wide.
constexpr double panel_steps = 1.0 / 3.0;
constexpr double panel_share = 0.04;

/// How finely a ring's directions must be looked at.
struct Beam {
    double centre_rad;
    double width_rad;       ///< a standard deviation or less
    int panels;             ///< of half a width, either side of the centre
    bool both_ways = false; ///< there is another, opposite
};

Beam beam_of(const Ring& ring) {
    if (ring.measured != nullptr)
        return {0.0, 4.0 * pi / 256, 128}; // a maximum entropy beam may be sharp anywhere
    // cos^2 and sech^2 are never narrower than 0.35; swell narrows them as it does cos2s.
    const double width = std::min(0.35, std::sqrt(2.0 / (ring.spreading.exponent() + 1.0)));
    return {ring.towards_rad, width,
            static_cast<int>(std::ceil(std::min(8.0 * width, pi) / (0.5 * width))), ring.both_ways};
}

/// Works in lattice steps: a mode is a point with whole coordinates, a cell a unit square.
class Cells {
  public:
    Cells(const DirectionalSpectrum& spectrum, const CascadeSpec& spec, Band band)
        : spectrum_(spectrum), size_(spec.size), step_(spec.wavenumber_step_radpm()), band_(band),
          reach_(static_cast<int>(
              std::min(std::ceil(band.k_hi_radpm / step_), 0.5 * spec.size - 1.0))),
          variances_(static_cast<std::size_t>(size_) * static_cast<std::size_t>(size_)) {}

    std::vector<double> integrate() {
        find_edges();
        find_smooth_rings();
        add_smooth_cells();
        for (std::size_t e = 0; e + 1 < edges_.size(); ++e)
            add_circles(edges_[e], edges_[e + 1]);
        return std::move(variances_);
    }

  private:
    bool in_band(int nx, int ny) const {
        return std::max(std::abs(nx), std::abs(ny)) <= reach_ && (nx != 0 || ny != 0) &&
               band_.contains(step_ * std::sqrt(nx * nx + ny * ny));
    }
    double& variance(int nx, int ny) {
        return variances_[static_cast<std::size_t>((ny + size_) % size_ * size_ +
                                                   (nx + size_) % size_)];
    }
    bool smooth(double radius) const {
        const long r = std::lround(radius);
        return r >= 0 && static_cast<std::size_t>(r) < smooth_.size() &&
               smooth_[static_cast<std::size_t>(r)];
    }

    /// Radii at which the density or the band ends or jumps, ascending; of the band first and last.
    void find_edges() {
        const double lo = band_.k_lo_radpm / step_, hi = band_.k_hi_radpm / step_;
        edges_ = {lo, hi};
        for (const double k : spectrum_.wavenumber_breaks())
            if (lo < k / step_ && k / step_ < hi)
                edges_.push_back(k / step_);
        std::sort(edges_.begin(), edges_.end());
    }

    void find_smooth_rings() {
        const auto density = [&](double radius) {
            return radius > 0.0 ? spectrum_.ring(step_ * radius).density : 0.0;
        };
        smooth_.assign(static_cast<std::size_t>(reach_) + 2, false);
        for (int r = 1; r <= reach_; ++r) {
            const auto near = [r](double edge) { return std::abs(edge - r) < edge_reach; };
            if (std::any_of(edges_.begin(), edges_.end(), near))
                continue;
            const Ring ring = spectrum_.ring(step_ * r);
            const double before = density(r - 1), after = density(r + 1);
            const double bend = std::abs(before - 2.0 * ring.density + after);
            smooth_[static_cast<std::size_t>(r)] =
                bend <= second_difference_max * std::max({before, ring.density, after}) &&
                r * beam_of(ring).width_rad >= beam_steps_min;
        }
    }

    /// What depends on |k| alone is computed once for each nx^2 + ny^2.
    void add_smooth_cells() {
        std::vector<std::optional<Ring>> rings(static_cast<std::size_t>(2 * reach_ * reach_ + 1));
        for (int ny = -reach_; ny <= reach_; ++ny)
            for (int nx = -reach_; nx <= reach_; ++nx) {
                const double radius = std::sqrt(nx * nx + ny * ny);
                if (!in_band(nx, ny) || !smooth(radius))
                    continue;
                std::optional<Ring>& ring = rings[static_cast<std::size_t>(nx * nx + ny * ny)];
                if (!ring)
                    ring = spectrum_.ring(step_ * radius);
                if (ring->density > 0.0)
                    variance(nx, ny) = (*ring)(std::atan2(ny, nx)) * step_ * step_;
            }
    }

    /// Gauss-Legendre with two points a panel between two radii.
    void add_circles(double from, double to) {
        for (double start = from; start < to;) {
            const double width =
                std::min(to - start, std::min(panel_steps, panel_share * std::max(start, 0.5)));
            for (const double side : {-1.0, 1.0})
                add_circle(start + 0.5 * width * (1.0 + side / std::sqrt(3.0)), 0.5 * width);
            start = start + width < to ? start + width : to;
        }
    }

    /// `width`: how much of the radius this circle stands for.
    void add_circle(double radius, double width) {
        bool needed = false;
        for (const double offset : {-cell_reach, 0.0, cell_reach})
            needed = needed || !smooth(radius + offset);
        const double k = step_ * radius;
        const Ring ring = needed ? spectrum_.ring(k) : Ring{0.0, 0.0, Spreading::power(0.0)};
        if (!(ring.density > 0.0))
            return;
        cut(radius, beam_of(ring));
        double sum = 0.0;
        shares_.clear();
        for (std::size_t i = 0; i < cuts_.size(); ++i) {
            const double begin = cuts_[i];
            const double end = i + 1 < cuts_.size() ? cuts_[i + 1] : cuts_.front() + two_pi;
            const double middle = 0.5 * (begin + end), half = 0.5 * (end - begin);
            const double node = half / std::sqrt(3.0);
            shares_.push_back({middle, half * (ring(middle - node) + ring(middle + node))});
            sum += shares_.back().share;
        }
        if (!(sum > 0.0))
            return;
        // The spreading integrates to one; so do its shares, whatever the quadrature missed.
        const double energy = ring.density * k * (step_ * width) / sum;
        for (const Arc& arc : shares_)
            if (arc.share > 0.0)
                give(radius * std::cos(arc.middle_rad), radius * std::sin(arc.middle_rad),
                     energy * arc.share);
    }

    /// Angles at which a circle crosses from cell to cell, and those of the beam's panels.
    void cut(double radius, const Beam& beam) {
        cuts_.clear();
        const auto add = [this](double angle) {
            cuts_.push_back(angle - two_pi * std::floor(angle / two_pi));
        };
        for (double side = 0.5; side < radius; side += 1.0) {
            const double a = std::acos(side / radius);
            for (const double quarter : {0.0, 0.5 * pi, pi, 1.5 * pi}) {
                add(quarter + a);
                add(quarter - a);
            }
        }
        for (int j = -beam.panels; j <= beam.panels; ++j) {
            add(beam.centre_rad + 0.5 * j * beam.width_rad);
            if (beam.both_ways)
                add(beam.centre_rad + pi + 0.5 * j * beam.width_rad);
        }
        std::sort(cuts_.begin(), cuts_.end());
    }

    /// Energy at a point of the plane goes to the mode of its cell or, if that is outside the band,
    /// to the nearest one inside.
    void give(double x, double y, double energy) {
        const int nx = static_cast<int>(std::lround(x)), ny = static_cast<int>(std::lround(y));
        if (in_band(nx, ny)) {
            if (!smooth(std::sqrt(nx * nx + ny * ny)))
                variance(nx, ny) += energy;
            return;
        }
        double nearest = 1e9;
        int best_x = 0, best_y = 0;
        for (int dy = -2; dy <= 2; ++dy)
            for (int dx = -2; dx <= 2; ++dx) {
                const double distance = std::hypot(nx + dx - x, ny + dy - y);
                if (in_band(nx + dx, ny + dy) && distance < nearest) {
                    nearest = distance;
                    best_x = nx + dx;
                    best_y = ny + dy;
                }
            }
        if (best_x != 0 || best_y != 0)
            variance(best_x, best_y) += energy;
    }

    struct Arc {
        double middle_rad;
        double share;
    };

    const DirectionalSpectrum& spectrum_;
    int size_;
    double step_; ///< rad/m
    Band band_;
    int reach_; ///< largest lattice index
    std::vector<double> variances_;
    std::vector<double> edges_;
    std::vector<bool> smooth_; ///< by radius of the mode, to the nearest whole step
    std::vector<double> cuts_;
    std::vector<Arc> shares_;
};

} // namespace

std::vector<double> mode_variances(const DirectionalSpectrum& spectrum, const CascadeSpec& spec,
                                   Band band) {
    if (spectrum.empty())
        return std::vector<double>(static_cast<std::size_t>(spec.size) *
                                   static_cast<std::size_t>(spec.size));
    return Cells(spectrum, spec, band).integrate();
}

} // namespace seaway::sea
