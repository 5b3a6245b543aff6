// SPDX-License-Identifier: Apache-2.0
// The truth that synthesised maps are held against: the sum over modes in double precision, by the
// formulas of sea/waves/realization.h and tests/support/field_law.h, separable but without any fast transform.
#pragma once

#include <complex>
#include <numbers>
#include <vector>

#include "sea/basics/field.h"
#include "sea/waves/realization.h"
#include "tests/sea/native/random_modes.h"
#include "tests/support/field_law.h"

namespace seaway::sea {

/// Complex amplitude of a linear field at array index (ix, iy).
inline std::complex<double> amplitude(const CascadeModes& modes, Field field, std::size_t ix,
                                      std::size_t iy, TimeUs t_us) {
    const auto n = static_cast<std::size_t>(modes.spec.size);
    const std::size_t here = iy * n + ix, there = (n - iy) % n * n + (n - ix) % n;
    const double omega = omega_from_rate(modes.rate[here]);
    const auto turn = std::polar(1.0, -phase_rad(modes.rate[here], t_us));
    const auto forward = modes.h0[here] * turn;
    const auto backward = std::conj(modes.h0[there] * turn);
    std::complex<double> h = forward + backward;
    if (tests::is_rate(field))
        h = std::complex<double>(0, -omega) * (forward - backward);
    const double step = modes.spec.wavenumber_step_radpm();
    return h * tests::of_wave(field, lattice(ix, modes.spec.size) * step,
                              lattice(iy, modes.spec.size) * step, modes.depth_m);
}

/// Rows y = 0, stride, 2 stride, ... of a linear field: [row][x].
inline std::vector<double> double_sum(const CascadeModes& modes, Field field, TimeUs t_us,
                                      std::size_t stride) {
    const auto n = static_cast<std::size_t>(modes.spec.size);
    std::vector<std::complex<double>> roots(n);
    for (std::size_t i = 0; i < n; ++i)
        roots[i] =
            std::polar(1.0, 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(n));
    std::vector<std::complex<double>> lines(n / stride * n); // [row][ix]
    for (std::size_t iy = 0; iy < n; ++iy) {
        for (std::size_t ix = 0; ix < n; ++ix) {
            const auto a = amplitude(modes, field, ix, iy, t_us);
            if (a == 0.0)
                continue;
            for (std::size_t row = 0; row < n / stride; ++row)
                lines[row * n + ix] += a * roots[iy * row * stride % n];
        }
    }
    std::vector<double> values(n / stride * n);
    for (std::size_t row = 0; row < n / stride; ++row)
        for (std::size_t ix = 0; ix < n; ++ix)
            if (const auto line = lines[row * n + ix]; line != 0.0)
                for (std::size_t x = 0; x < n; ++x)
                    values[row * n + x] += (line * roots[ix * x % n]).real();
    return values;
}

} // namespace seaway::sea
