// SPDX-License-Identifier: Apache-2.0
// What one asks of the sea at a point, and what one gets.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

#include "sea/basics/cascade.h"
#include "sea/basics/time.h"

namespace seaway::sea {

/// How far from the origin the sea may be looked at: there a double still resolves 1e-7 m, a
/// hundred times finer than what is lost to it on a tile.
inline constexpr double position_max_m = 1e9;

/// A place in the world (not displaced) and a sea time.
struct QueryPoint {
    double x_m;     ///< east, -position_max_m .. position_max_m
    double y_m;     ///< north
    TimeUs time_us; ///< in_time_range()
};

/// Bits of Answer::flags.
enum AnswerFlag : std::uint32_t {
    /// The surface has several sheets here, or comes so near to it that the error of the maps leaves
    /// open whether it does. The height is that of the highest one.
    answer_folded = 1u << 0,
    answer_not_converged = 1u << 1, ///< residual above tolerance; `error_m` covers it
    answer_extrapolated = 1u << 2,  ///< outside the keyframes held; `error_m` is not a bound
    answer_invalid = 1u << 3,       ///< the point was not a number; the rest is NaN
    answer_exact = 1u << 4,         ///< direct sum in double precision
    /// Of some of the waves the velocity has its vertical part alone: of all, from maps that hold no displacement; of stylised
    /// ones (sea/waves/sine_waves.h) from whatever is asked.
    answer_vertical_velocity = 1u << 5,
    /// With answer_folded: a sheet begins or ends so near that the error of the maps leaves open which
    /// one is the highest, and `error_m` is not a bound. The exact sum knows.
    answer_open = 1u << 6,
    /// Of a client whose server may know more of this time: `error_m` has what staleness.h says.
    answer_stale = 1u << 7,
    /// Asked about the water at a depth: there is none, above the surface or below the sea floor.
    answer_dry = 1u << 8,
    /// Of a client that is asked for foam: it is that of the nearest keyframe, which is of another time.
    answer_foam_late = 1u << 9,
};

/// Their names, in the order of their bits.
inline constexpr std::array answer_flag_names{
    "folded", "not_converged", "extrapolated", "invalid",  "exact", "vertical_velocity",
    "open",   "stale",         "dry",          "foam_late"};
static_assert(1u << (answer_flag_names.size() - 1) == answer_foam_late);

/// Which waves count. A hull that is L long does not feel waves that are much shorter.
struct Looking {
    std::uint32_t cascades = all_cascades; ///< a bit each
    /// Cascades all of whose waves are shorter are left out; shorter waves of a cascade that has longer ones
    /// too stay.
    double min_wavelength_m = 0;

    /// `longest_radpm`: CascadeModes::longest_radpm().
    /// A wave as long as that is felt: lengths are compared, as clients are told them, since of doubles k (2 pi / k) may be
    /// more than 2 pi.
    bool feels(std::size_t cascade, double longest_radpm) const {
        return (cascades >> cascade & 1u) != 0 &&
               (longest_radpm == 0 || 2 * std::numbers::pi / longest_radpm >= min_wavelength_m);
    }
    bool operator==(const Looking&) const = default;
};

/// What is asked for.
enum class AnswerParts {
    height, ///< height_m, error_m, flags and the normal, which the error takes; no velocity
    all,
};

/// Where a point's water came from when it was last asked about: where it is looked for first the next time. Of a point
/// that moves a little from one time to the next, as on a hull.
struct PointMemory {
    double shift_x_m = 0; ///< X - x
    double shift_y_m = 0;
    bool known = false;
};

/// The surface above a world point.
struct Answer {
    double height_m = 0;
    double normal[3] = {0, 0, 1}; ///< unit length, z up
    /// Of the water at the surface, by linear theory: (dDx/dt, dDy/dt, d eta/dt) at choppiness 1,
    /// whatever choppiness moves the picture's points. Stylised waves that are no modes have no water
    /// below them and give their vertical part alone: answer_vertical_velocity.
    double velocity_mps[3] = {0, 0, 0};
    double error_m = 0;      ///< bound on |height_m - truth|
    std::uint32_t flags = 0; ///< AnswerFlag
};

/// What an answer's error_m is made of, each a bound on what this cause alone does to the height. Coding, time and space are
/// of five standard deviations and have nothing to do with each other: they add up in the square, the rest is added to that.
struct ErrorTerms {
    double codec_m = 0;   ///< rounding of what was sent: tiles, or the waves
    double time_m = 0;    ///< between two keyframes
    double space_m = 0;   ///< between grid points, and waves that a map came without
    double inverse_m = 0; ///< the place is met to a tolerance; a sheet beside may be the highest
    double rounding_m =
        0;              ///< single precision, and all interpolation where its parts are not known
    double clock_m = 0; ///< the time asked about may be another one than was meant
    double stale_m = 0; ///< the sea may have been changed meanwhile

    double sum_m() const {
        return std::sqrt(codec_m * codec_m + time_m * time_m + space_m * space_m) + rounding_m +
               inverse_m + clock_m + stale_m;
    }
};

/// What AnswerParts::height leaves of it.
inline void leave_out_velocity(Answer& answer) {
    if (!(answer.flags & answer_invalid))
        for (double& component : answer.velocity_mps)
            component = 0;
}

/// The water at a world point below the surface (sea/surface/below.h).
struct WaterBelow {
    double velocity_mps[3] = {0, 0, 0};
    /// Dynamic pressure over density: times the water's density it is what presses beside its weight below still water,
    /// -density g z. Zero in still water.
    double pressure_m2ps2 = 0;
};

} // namespace seaway::sea
