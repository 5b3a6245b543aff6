// SPDX-License-Identifier: Apache-2.0
// What keyframes and grids cost stylised waves that are no modes (sea/waves/sine_waves.h). Their
// crests are sharp, and drag bends one wave by the others, so no sum over harmonics is both safe and
// tight: the interpolation is tried out on the waves themselves, at places and times spread evenly.
//
// Pure; thread-safe. About 0.2 s for a dozen waves, 5 s for 256.
#pragma once

#include <vector>

#include "sea/basics/time.h"
#include "sea/waves/sine_waves.h"

namespace seaway::sea {

class SineError {
  public:
    SineError(const SineField& field, double spacing_m);

    /// Bound on what the cubic spline misses between grid points along x and along y: 1.25 times the largest error that was
    /// found, from the largest that were met uphill, for those that were not. Held by tests, not proved.
    double east_m() const { return east_m_; }
    double north_m() const { return north_m_; }
    struct Time {
        double missed_m = 0;
        /// How far it agrees with what is missed in space where that is most, 0 to 1: fully where there is one wave, which both
        /// make smaller; hardly where there are many.
        double agrees = 0;
    };
    /// Likewise on what cubic Hermite misses between keyframes; and, in a glide, by gliding_error(), as if all of it were the
    /// fastest wave. Where that turns more than once between two of them, by hermite_error(): keyframes a whole turn apart agree.
    Time time(TimeUs interval_us, TimeUs glide_us = 0) const;
    double omega_max_radps() const { return omega_max_radps_; } ///< of the fastest wave

    double slope_variance() const { return slope_variance_; }
    /// As of CascadeWaves.
    double detail_m2() const { return detail_m2_; }
    double rate_detail_m2ps2() const { return rate_detail_m2ps2_; }

  private:
    struct Sample {
        double x_m;
        double y_m;
        TimeUs time_us;
        double share; ///< of an interval, at which Hermite is tried out
    };
    struct Met {
        double error_m;
        Sample at;
    };
    // Signed.
    double spline_error_m(const Sample& sample, double dx_m, double dy_m) const;
    double hermite_error_m(const Sample& sample, TimeUs interval_us) const;
    /// Of all samples, in their order.
    template <class ErrorAt>
    std::vector<Met> met(const ErrorAt& error_at) const;
    /// From the largest of them uphill.
    template <class ErrorAt>
    double largest(std::vector<Met> met, const ErrorAt& error_at) const;
    double agrees(const std::vector<Met>& in_time) const;

    const SineField& field_;
    double stride_m_ = 0; ///< a radian of the shortest wave
    double omega_max_radps_ = 0;
    std::vector<Sample> samples_;
    std::vector<Met> east_, north_; ///< of each sample
    double east_m_ = 0;
    double north_m_ = 0;
    double slope_variance_ = 0;
    double detail_m2_ = 0;
    double rate_detail_m2ps2_ = 0;
};

} // namespace seaway::sea
