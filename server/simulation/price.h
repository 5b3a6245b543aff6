// SPDX-License-Identifier: Apache-2.0
// What is asked of the simulation, in microseconds of its thread, before any of it is done: keyframes
// that are not held, ticks of foam on the way to them, splines, points, exact sums. The one place where
// requests are priced; what they then take is measured, and settled with their asker (account.h). Pricing makes nothing.
//
// Units were measured with tests/load/load_costs on the north_sea_gale scene, two cores, AVX2
// (docs/performance/load.md has the table). Values; Prices is immutable and thread-safe.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "sea/surface/answer.h"
#include "server/device/synthesizer.h"
#include "server/host/subscriptions.h"
#include "server/simulation/sea_course.h"

namespace seaway::server {

inline constexpr double price_sample_us = 0.0004;        ///< one sample of one field of a keyframe
inline constexpr double price_spline_sample_us = 0.0042; ///< one sample of one field of a spline
inline constexpr double price_foam_sample_us = 0.004;    ///< one sample of a tick, strains included
inline constexpr double price_plane_sine_us =
    0.005; ///< one stylised wave at one point of a keyframe: plain
inline constexpr double price_sharp_sine_us = 0.1;     ///< exponential
inline constexpr double price_octave_us = 0.03;        ///< of noise
inline constexpr double price_point_us = 2.2;          ///< one answer from splines that are there
inline constexpr double price_exact_wave_us = 0.00018; ///< one grid point of the sea, for one point
inline constexpr double price_moment_wave_us = 0.00025; ///< one grid point of the sea, for one time
inline constexpr double price_below_wave_us = 0.0012;   ///< likewise, for the water below one point
inline constexpr double price_glide_wave_us = 0.016; ///< likewise, while waves are between two seas
inline constexpr double price_sea_wave_us =
    0.9; ///< one grid point of a sea that is not made; of a glide for each of two
inline constexpr double price_spectrum_wave_us =
    0.4; ///< one grid point of a sea whose waves are to be sent, at an accuracy that is not held
/// Points of seas that fold are searched all around.
inline constexpr double price_folds_factor = 10;

/// What of a keyframe is there already.
enum class Holding { nothing, keyframe, spline };
using HoldingOf = std::function<Holding(const KeyframeRequest&)>;
inline constexpr double prompt_points = 100;
/// Keyframes of one request that are looked up; what comes after them counts as not held, so that
/// pricing itself costs little.
inline constexpr int price_lookups_max = 256;

class Prices {
  public:
    explicit Prices(SeaCoursePtr course);

    double keyframes_us(std::span<const KeyframeRequest> wanted, const HoldingOf& held) const;
    /// All of them around these times, those included that must be made before.
    double fetch_us(std::vector<sea::TimeUs> times_us, const Demand& demand,
                    const HoldingOf& held) const;
    /// Answers from surfaces, those included that are to be made.
    double points_us(std::span<const sea::QueryPoint> points, const HoldingOf& held,
                     std::uint32_t cascades = sea::all_cascades) const;
    /// `depths`: of so many the water below as well.
    double exact_us(std::span<const sea::QueryPoint> points, std::size_t depths = 0) const;
    double surface_us(sea::TimeUs time_us, const HoldingOf& held) const;

    /// Questions of no higher price are prompt ones: some points at one time, of whose surface nothing
    /// need be there.
    double prompt_us() const { return prompt_us_; }

    double samples(int cascade) const { return samples_[static_cast<std::size_t>(cascade)]; }

  private:
    /// By the sea of the first of them.
    double folds_factor(std::span<const sea::QueryPoint> points) const;
    double surfaces_us(std::vector<sea::TimeUs> times_us, const HoldingOf& held,
                       std::uint32_t cascades) const;
    /// Making these seas, so far as nobody has; none is made to know that.
    double seas_us(std::span<const std::uint32_t> epochs) const;
    std::vector<std::uint32_t> epochs_at(std::span<const sea::TimeUs> times_us) const;
    /// keyframes_around(), of seas that are not made with the intervals of the first.
    std::vector<KeyframeRequest> expected_around(std::span<const sea::TimeUs> times_us,
                                                 const Demand& demand) const;

    const SeaCoursePtr course_;
    /// One keyframe that is not held, but for the ticks of its foam.
    double keyframe_us(const KeyframeRequest& wanted) const;
    double foam_start_ticks(int cascade) const;

    std::vector<double> samples_;       ///< of one field, a cascade
    std::vector<int> foam_start_ticks_; ///< a cascade that makes waves break; 0: no foam
    double all_samples_ = 0;
    double prompt_us_ = 0;
};

} // namespace seaway::server
