// SPDX-License-Identifier: Apache-2.0
#include "sea/surface/budget/orbit_error.h"

#include <algorithm>
#include <cmath>

#include "sea/basics/dispersion.h"
#include "sea/basics/glide.h"

namespace seaway::sea {
namespace {

/// Of so many intervals between the first that ends as the glide begins and the last that begins as it ends.
constexpr int intervals = 96;
constexpr double untried = 1.1; // between those that are tried

/// x: the share of the glide's time that has passed.
class Orbit {
  public:
    Orbit(double k_radpm, const DepthGlide& glide) : k_radpm_(k_radpm), glide_(glide) {}

    double depth_m(double x) const {
        return glided_depth_m(glide_.from_m, glide_.to_m, glide_share(at_us(x), 0, whole_us));
    }
    double aspect(double x) const { return orbit_aspect(k_radpm_, depth_m(x)); }
    /// For each time that the glide takes.
    double rate(double x) const {
        const double share_rate = glide_rate(at_us(x), 0, whole_us) * seconds_from_us(whole_us);
        return aspect(x) * orbit_growth_m(k_radpm_, depth_m(x)) * share_rate *
               (1.0 / glide_.to_m - 1.0 / glide_.from_m);
    }
    /// Of the cubic from `x` on, over a share q of the glide.
    double missed(double x, double q) const {
        const double a = aspect(x), b = aspect(x + q), da = q * rate(x), db = q * rate(x + q);
        double most = 0;
        for (const double s : {0.2, 0.35, 0.5, 0.65, 0.8}) {
            const double r = 1.0 - s;
            const double cubic = r * r * (1.0 + 2.0 * s) * a + s * s * (1.0 + 2.0 * r) * b +
                                 s * r * (r * da - s * db);
            most = std::max(most, std::abs(cubic - aspect(x + s * q)));
        }
        return most;
    }
    /// Where it stops growing, or begins to; none: below 0.
    double kink() const {
        const auto above = [this](double x) { return k_radpm_ * depth_m(x) > orbit_kd_min; };
        if (above(0) == above(1))
            return -1;
        double lo = 0, hi = 1;
        for (int i = 0; i < 40; ++i) {
            const double middle = 0.5 * (lo + hi);
            (above(middle) == above(0) ? lo : hi) = middle;
        }
        return lo;
    }

  private:
    static constexpr TimeUs whole_us = 1'000'000'000'000; // as fine as shares are asked for
    static TimeUs at_us(double x) { return static_cast<TimeUs>(x * static_cast<double>(whole_us)); }

    double k_radpm_;
    const DepthGlide& glide_;
};

} // namespace

double orbit_error(double k_radpm, const DepthGlide& glide, TimeUs interval_us) {
    if (!glide.changes())
        return 0;
    const Orbit orbit(k_radpm, glide);
    const double q = static_cast<double>(interval_us) / static_cast<double>(glide.us);
    double most = 0;
    for (int i = 0; i <= intervals; ++i)
        most = std::max(most, orbit.missed(-q + (1.0 + q) * i / intervals, q));
    if (const double kink = orbit.kink(); kink >= 0)
        for (int tenths = 1; tenths < 10; ++tenths)
            most = std::max(most, orbit.missed(kink - 0.1 * tenths * q, q));
    return untried * most;
}

} // namespace seaway::sea
