// SPDX-License-Identifier: Apache-2.0
#include "sea/waves/probes.h"

#include <algorithm>
#include <cmath>

namespace seaway::sea {
namespace {

constexpr TimeUs day_us = 86'400'000'000;
/// Beyond one tile and on both sides of the origin: who reduces places wrongly is seen, too.
constexpr double tiles_across = 8.0;
/// Multiples of a quadratic irrational leave no gap wide, however many there are: the golden ratio, sqrt(2), sqrt(3).
constexpr double axis_steps[] = {0.6180339887498949, 0.4142135623730951, 0.7320508075688772};

double share(int probe, int axis) {
    const double at = 0.5 + probe * axis_steps[axis];
    return at - std::floor(at);
}

/// The larger one; NaN stays.
void take_larger(double& largest, double value) {
    if (!std::isnan(largest) && !(value <= largest))
        largest = value;
}

} // namespace

std::vector<Probe> make_probes(const DirectSum& sea, TimeUs from_us) {
    const Realization& waves = sea.sea();
    double length_m = 0;
    for (const CascadeModes& cascade : waves.cascades)
        length_m = std::max(length_m, cascade.spec.length_m);
    const TimeUs long_us = waves.loop_period_us > 0 ? waves.loop_period_us : day_us;
    const auto span_us = static_cast<double>(std::min(long_us, time_us_max - from_us));
    std::vector<Probe> probes;
    for (int n = 0; n < probe_count; ++n) {
        const double x_m = tiles_across * length_m * (share(n, 0) - 0.5);
        const double y_m = tiles_across * length_m * (share(n, 1) - 0.5);
        const TimeUs time_us = from_us + static_cast<TimeUs>(span_us * share(n, 2));
        const LagrangianPoint point = sea.at(x_m, y_m, time_us);
        probes.push_back(
            {x_m, y_m, time_us, point.height, point.displacement_x, point.displacement_y});
    }
    return probes;
}

ProbeDifference compare(const DirectSum& sea, std::span<const Probe> probes) {
    ProbeDifference difference;
    for (const Probe& probe : probes) {
        const LagrangianPoint point = sea.at(probe.x_m, probe.y_m, probe.time_us);
        take_larger(difference.height_m, std::abs(point.height - probe.height_m));
        take_larger(difference.displacement_m,
                    std::abs(point.displacement_x - probe.displacement_x_m));
        take_larger(difference.displacement_m,
                    std::abs(point.displacement_y - probe.displacement_y_m));
    }
    return difference;
}

} // namespace seaway::sea
