// SPDX-License-Identifier: Apache-2.0
// The waves of one cascade as far as accuracy goes: what its grid misses of them, and what an interval
// between its keyframes would.
//
// Immutable after construction; thread-safe. Cost: one pass over the modes, a few milliseconds a cascade of
// 256 x 256, and what sine_error.h says.
#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "sea/surface/budget/orbit_error.h"
#include "sea/surface/budget/sine_error.h"
#include "sea/surface/map_error.h"
#include "sea/waves/realization.h"

namespace seaway::sea {

/// Some quantity summed over waves. Where phases are random, variances add up; waves whose phases a scene
/// gives may all agree somewhere, and count with the sum of their amplitudes where that is more.
struct WaveSum {
    double random_m2 = 0;
    double given_m2 = 0;
    double given_m = 0;

    void add(double variance, double amplitude, bool given) {
        (given ? given_m2 : random_m2) += variance;
        given_m += given ? amplitude : 0.0;
    }
    void add(const WaveSum& part, double factor) {
        random_m2 += part.random_m2 * factor * factor;
        given_m2 += part.given_m2 * factor * factor;
        given_m += part.given_m * factor;
    }
    double mean_square_m2() const { return random_m2 + given_m2; }
    /// Of which `sigmas` standard deviations are a bound.
    double variance_m2(double sigmas) const {
        return random_m2 + std::max(given_m2, given_m * given_m / (sigmas * sigmas));
    }
};

/// Heights, displacements or strains: by frequency, and what the grid spacing costs of them.
struct Motion {
    static constexpr int bins = 512;
    std::array<WaveSum, bins> by_frequency{};
    /// Variance times what the grid misses of it along each axis, as a share of the amplitude, by frequency.
    struct Missed {
        double east_m2 = 0;
        double north_m2 = 0;
    };
    std::array<Missed, bins> missed_by_frequency{};
    WaveSum whole;
    WaveSum gradient;   ///< the slope
    double east_m2 = 0; ///< missed in the middle of a cell, as variances of bound_sigmas
    double north_m2 = 0;
    double single_m = 0; ///< what single precision costs
};

/// What a map misses of heights, of displacements, of their gradients: standard deviations, m and 1.
struct CutWaves {
    double height_m = 0;
    double displacement_m = 0; ///< both components together
    double slope = 0;
    double strain = 0;
};

/// Has it waves whose phases are given, modes or stylised ones? What is missed of n such cascades may agree as that of the waves of one
/// may, and cascades are added in the square: (a + b + ...)^2 <= n (a^2 + b^2 + ...).
bool has_given(const CascadeModes& modes);

class CascadeWaves {
  public:
    /// Of a steady sea, or of one that glides so, whose waves are no higher than these. `given_cascades`: so many of the
    /// sea has_given().
    explicit CascadeWaves(const CascadeModes& modes, const DepthGlide& glide = {},
                          int given_cascades = 1);

    /// Losses of this interval; nothing is coded. A spline and Hermite's cubic both make a wave smaller, so that what they miss of one
    /// wave adds up: of (t + x)^2 the halves of 2 t x stand with what each misses alone. So does what is missed of all waves that are
    /// given, stylised ones among them.
    CascadeLoss loss(TimeUs interval_us) const;
    /// The same where maps come so much further apart than their sea says: with the losses in space of loss(interval_us).
    struct SlowLoss {
        double height_m = 0; ///< MapLoss::time_m
        double displacement_m = 0;
    };
    SlowLoss slow_loss(TimeUs interval_us, TimeUs slow_us) const;
    /// What of the variance of a height comes of the interval, a displacement counted with `sideways_weight`.
    double time_costs_m2(TimeUs interval_us, double sideways_weight) const;
    double time_strain_rms(TimeUs interval_us) const; ///< missed of grad D between keyframes
    double strain_rms(TimeUs interval_us) const;      ///< and between grid points
    /// Keyframes so far apart that a wave turns more than once between two of them say nothing of it.
    bool told_by(TimeUs interval_us) const;

    const Motion& height() const { return height_; }
    const Motion& displacement() const { return displacement_; }
    const Motion& strain() const { return strain_; }
    const WaveSum& curvature() const { return curvature_; } ///< of heights, as k^2
    double spacing_m() const { return spacing_m_; }
    /// Of the grid.
    double points() const { return static_cast<double>(size_) * size_; }
    int size() const { return size_; }
    /// The smallest grid that carries all its waves (sea/surface/maps/regrid.h); its own size where stylised
    /// waves have no end.
    int compact_size() const { return compact_size_; }
    /// Those of its waves that a grid of so many points a side has no room for (sea/surface/maps/regrid.h); stylised ones
    /// are not cut. Cost: one pass over some hundred sums.
    CutWaves cut(int size) const;
    bool has_stylised() const { return !sines_.empty(); } ///< waves that are no modes
    /// Are all of its waves modes, which can be cut, on a grid that transforms are quick at?
    bool can_be_cut() const;
    /// What even noise of heights becomes in displacements that follow from them on a grid of so many points a side
    /// (Orbits::gain).
    double follows_gain(int size) const;
    /// On compact_size(); more than any that is had where displacements do not follow: not those of stylised waves, which move
    /// nothing sideways.
    double follows_gain() const { return follows_gain_; }
    /// Variance of what the predictor of the codec leaves of a map of heights, and of one of their time
    /// rates, (m/s)^2: h(x,y) - h(x-dx,y) - h(x,y-dy) + h(x-dx,y-dy).
    double detail_m2() const { return detail_m2_; }
    double rate_detail_m2ps2() const { return rate_detail_m2ps2_; }

  private:
    struct Missed;
    struct Wave;
    void add(const Wave& wave, Missed (&missed)[3]);
    double time_rms(const Motion& motion, TimeUs interval_us) const;
    /// Of what is missed in time and in space the mean product.
    Motion::Missed in_common(const Motion& motion, TimeUs interval_us) const;
    double missed_in_time(int bin, TimeUs interval_us) const;
    double slow_rms(const Motion& motion, TimeUs interval_us, TimeUs slow_us) const;
    /// Missed between keyframes where the depth glides: of a displacement, and of its gradient.
    struct OrbitsMissed {
        double displacement_m = 0;
        double strain = 0;
    };
    OrbitsMissed orbits_missed(TimeUs interval_us) const;
    /// Of heights that are given, at most, as standard deviations.
    struct AtMost {
        double time_m = 0, east_m = 0, north_m = 0;
        double agrees = 1; ///< what is missed in time and in space, 0 to 1 (SineError::Time)
    };
    /// What stands with each part of a sum's square.
    struct Shares {
        double time_m2 = 0, east_m2 = 0, north_m2 = 0; ///< its own
        double time_east_m2 = 0, time_north_m2 = 0;    ///< with time and with space alike
    };
    AtMost sines_missed(TimeUs interval_us) const;
    AtMost modes_missed(TimeUs interval_us) const;
    /// Of all stylised waves, and of those that are modes beside them, which count alone already.
    Shares with_sines(TimeUs interval_us) const;
    double as_rms(double bound_m) const; ///< of what is given

    DepthGlide glide_;
    double given_cascades_;
    double given_east_m_ = 0, given_north_m_ = 0; ///< missed of modes that are given, at most
    /// Waves that agree are missed between keyframes and between grid points at once: there the two add up to
    /// sqrt(2) times the root of their squares.
    double loss_sigmas_;
    int size_;
    int compact_size_;
    double follows_gain_ = std::numeric_limits<double>::infinity();
    double spacing_m_;
    double omega_max_radps_ = 0; ///< of modes
    double omega_fastest_radps_ = 0;
    Motion height_;
    Motion displacement_;
    Motion strain_;
    WaveSum curvature_;
    double detail_m2_ = 0;
    double rate_detail_m2ps2_ = 0;
    double length_m_;
    double depth_m_;
    /// Heights by the length of waves, a bin a twelfth of an octave from the longest of the tile on; where the depth glides.
    static constexpr int bins_an_octave = 12;
    std::vector<WaveSum> by_length_;
    /// Of the waves with a lattice index of n up to n + 1.
    struct Ring {
        WaveSum height, displacement, slope, strain;
    };
    std::vector<Ring> rings_;
    std::vector<SineError> sines_; ///< stylised waves, which move nothing sideways
};

} // namespace seaway::sea
