// SPDX-License-Identifier: Apache-2.0
// Amplitudes of a cascade as they are looked at: k = 0 in the middle, rows from south to north. Column i stands for
// wavenumber (i - size / 2) * spec.wavenumber_step_radpm(), rows likewise.
//
// Pure; thread-safe. 256 x 256 take about 3 ms.
#pragma once

#include "sea/waves/realization.h"

namespace seaway::sea {

/// h0(k), m, [row][column].
std::vector<std::complex<double>> centred_h0(const CascadeModes& modes);

/// h(k,t) = h0(k) exp(-i w t) + conj(h0(-k)) exp(+i w t), m.
std::vector<std::complex<double>> centred_h(const Realization& sea, std::size_t cascade,
                                            TimeUs time_us);

} // namespace seaway::sea
