// SPDX-License-Identifier: Apache-2.0
// Quadrature over the frequencies of a spectrum: Gauss-Legendre in ln w between its breaks, where
// everything is smooth. Pure functions; thread-safe.
#pragma once

#include <vector>

#include "sea/basics/quadrature.h"
#include "sea/waves/directional_spectrum.h"

namespace seaway::sea {

/// Over lo .. hi, rad/s; a node's `x` is w and its `weight` includes dw.
std::vector<QuadratureNode> frequency_nodes(const DirectionalSpectrum& spectrum, double lo_radps,
                                            double hi_radps);

/// Over what the cut-offs leave of a band.
std::vector<QuadratureNode> kept_nodes(const DirectionalSpectrum& spectrum,
                                       const Dispersion& dispersion, Band band);

} // namespace seaway::sea
