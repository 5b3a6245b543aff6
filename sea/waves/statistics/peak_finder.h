// SPDX-License-Identifier: Apache-2.0
// Where most of the energy of waves that were drawn is.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "sea/basics/constants.h"
#include "sea/waves/statistics/moments.h"

namespace seaway::sea {

/// Slower than period_max_s it stands still.
inline bool moves(double omega_radps) {
    return omega_radps > two_pi / period_max_s;
}

/// Peak of a realised sea: sum w S^4 / sum S^4 (Young 1995) over narrow bins of equal ratio around
/// the densest, so that neither one lucky mode nor a second wave system pulls it away. Of what moves.
class PeakFinder {
  public:
    static constexpr double bin_width = 0.1; ///< of the logarithm of a frequency

    void add(double energy, double omega) {
        if (!moves(omega))
            return;
        const double bin = std::floor(std::log(omega) / bin_width) + offset;
        Bin& b = bins_[static_cast<std::size_t>(std::clamp(bin, 0.0, bin_count - 1.0))];
        b.energy += energy;
        b.moment += energy * omega;
    }
    /// 0: nothing moves.
    double peak_omega_radps() const {
        int densest = 0;
        for (int i = 0; i < bin_count; ++i)
            if (density(i) > density(densest))
                densest = i;
        double weights = 0.0;
        double sum = 0.0;
        for (int i = densest - reach; i <= densest + reach; ++i) {
            if (!(density(i) > 0.0))
                continue;
            // Of the densest's: the fourth power of a small sea's own is no number.
            const double weight = std::pow(density(i) / density(densest), 4);
            const Bin& b = bins_[static_cast<std::size_t>(i)];
            weights += weight;
            sum += weight * (b.moment / b.energy);
        }
        return weights > 0.0 ? sum / weights : 0.0;
    }

  private:
    struct Bin {
        double energy = 0.0;
        double moment = 0.0;
    };
    static constexpr int offset = 120; ///< exp(-12) rad/s
    static constexpr int bin_count = 240;
    static constexpr int reach = 2; ///< bins either way: 20 % in frequency

    /// Mean density over bin i, up to a factor; 0 outside.
    double density(int i) const {
        if (i < 0 || i >= bin_count || !(bins_[static_cast<std::size_t>(i)].energy > 0.0))
            return 0.0;
        const Bin& b = bins_[static_cast<std::size_t>(i)];
        return b.energy * (b.energy / b.moment);
    }

    std::array<Bin, bin_count> bins_{};
};

} // namespace seaway::sea
