// SPDX-License-Identifier: Apache-2.0
#include "sea/surface/maps/rotations.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sea/waves/realize.h"
#include "sea/waves/sine_limits.h"

namespace seaway::sea {

Rotations::Rotations(int size, double length_m, const WaveLaw& law, TimeUs forward_us)
    : size_(size), side_((size + 1) / 2) {
    turns_.resize(static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_));
    for (int j = 0; j < side_; ++j)
        for (int i = 0; i < side_; ++i) {
            const int square = i * i + j * j;
            if (square == 0 || 4 * square >= size * size)
                continue; // the mean, and what is nobody's
            const double k_radpm =
                2.0 * std::numbers::pi * std::sqrt(static_cast<double>(square)) / length_m;
            // Whoever was told of an impossible sea is not to stop for it.
            const double omega_radps =
                std::min(law.dispersion.omega(k_radpm), rate_omega_max_radps);
            const Rate rate = mode_rate(omega_radps, law.loop_period_us);
            const double w = omega_from_rate(rate);
            const double angle = phase_rad(rate, forward_us);
            const double sine = std::sin(angle);
            turns_[static_cast<std::size_t>(j * side_ + i)] = {
                .cosine = static_cast<float>(std::cos(angle)),
                .sine_over_w_s = w > 0 ? static_cast<float>(sine / w) : 0.0f,
                .sine_w_radps = static_cast<float>(w * sine)};
        }
}

} // namespace seaway::sea
