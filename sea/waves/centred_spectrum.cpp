// SPDX-License-Identifier: Apache-2.0
#include "sea/waves/centred_spectrum.h"

namespace seaway::sea {

namespace {

/// value(mode, mode of -k) at each place of the picture.
template <class Value>
std::vector<std::complex<double>> centred(const CascadeModes& modes, const Value& value) {
    const auto size = static_cast<std::size_t>(modes.spec.size);
    std::vector<std::complex<double>> out(size * size);
    for (std::size_t y = 0; y < size; ++y)
        for (std::size_t x = 0; x < size; ++x) {
            const std::size_t mirror = (size - y) % size * size + (size - x) % size;
            out[(y + size / 2) % size * size + (x + size / 2) % size] = value(y * size + x, mirror);
        }
    return out;
}

} // namespace

std::vector<std::complex<double>> centred_h0(const CascadeModes& modes) {
    return centred(modes, [&](std::size_t mode, std::size_t) { return modes.h0[mode]; });
}

std::vector<std::complex<double>> centred_h(const Realization& sea, std::size_t cascade,
                                            TimeUs time_us) {
    const CascadeModes& modes = sea.cascades[cascade];
    const TimeUs phase_time = sea.phase_time(time_us);
    return centred(modes, [&](std::size_t mode, std::size_t mirror) {
        const std::complex<double> forward =
            std::polar(1.0, -phase_rad(modes.rate[mode], phase_time));
        return modes.h0[mode] * forward + std::conj(modes.h0[mirror]) * std::conj(forward);
    });
}

} // namespace seaway::sea
