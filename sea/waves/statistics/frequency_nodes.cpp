// SPDX-License-Identifier: Apache-2.0
#include "sea/waves/statistics/frequency_nodes.h"

#include <algorithm>
#include <cmath>

namespace seaway::sea {

std::vector<QuadratureNode> frequency_nodes(const DirectionalSpectrum& spectrum, double lo,
                                            double hi) {
    std::vector<QuadratureNode> nodes;
    const std::vector<double> breaks = spectrum.breaks();
    for (std::size_t i = 0; i + 1 < breaks.size(); ++i) {
        const double from = std::max(lo, breaks[i]);
        const double to = std::min(hi, breaks[i + 1]);
        if (!(from < to))
            continue;
        const double a = std::log(from);
        const double width = std::log(to) - a;
        const int panels = std::max(1, static_cast<int>(std::ceil(width / 0.12)));
        const double half = 0.5 * width / panels;
        for (int p = 0; p < panels; ++p)
            for (const QuadratureNode& node : gauss_legendre_16)
                for (const double side : {-1.0, 1.0}) {
                    const double omega = std::exp(a + (2 * p + 1 + side * node.x) * half);
                    nodes.push_back({omega, node.weight * half * omega});
                }
    }
    return nodes;
}

std::vector<QuadratureNode> kept_nodes(const DirectionalSpectrum& spectrum,
                                       const Dispersion& dispersion, Band band) {
    const Band cut = spectrum.cutoffs();
    return frequency_nodes(spectrum, dispersion.omega(std::max(band.k_lo_radpm, cut.k_lo_radpm)),
                           dispersion.omega(std::min(band.k_hi_radpm, cut.k_hi_radpm)));
}

} // namespace seaway::sea
