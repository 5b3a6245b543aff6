// SPDX-License-Identifier: Apache-2.0
// What benchmarks of synthesis have in common: the work, programs that are timed in turn, and the
// proof that they make the same sea.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "sea/basics/field.h"
#include "sea/waves/realization.h"

namespace seaway::bench {

/// The work: three cascades of one size, eight fields each.
inline constexpr sea::FieldSet eight_fields{sea::Field::height,         sea::Field::displacement_x,
                                            sea::Field::displacement_y, sea::Field::slope_x,
                                            sea::Field::slope_y,        sea::Field::strain_xx,
                                            sea::Field::strain_yy,      sea::Field::strain_xy};
inline constexpr int cascade_count = 3;

/// `reach`: radius of the disc of modes in use as a share of Nyquist.
std::vector<sea::CascadeModes> three_cascades(int size, double reach);

struct Contender {
    std::string name;
    std::function<void(sea::TimeUs)> run;
    std::vector<double> wall_ms{};
    std::vector<double> cpu_ms{}; ///< of all threads, those of a driver among them
};

/// Runs once and adds its times.
void run_timed(Contender& contender, sea::TimeUs time_us);

double fastest(const std::vector<double>& values);

/// Stops where a plane of one program differs from that of another by 1e-4 of its rms. A slope
/// shares its transform with a displacement that may be a hundred times larger, and its rounding
/// errors: hence not 2e-6.
void check_same(std::span<const float> a, std::span<const float> b);

} // namespace seaway::bench
