// SPDX-License-Identifier: Apache-2.0
#include "sea/surface/maps/sine_maps.h"

#include <complex>
#include <vector>

namespace seaway::sea {

namespace {

/// exp(i k n spacing) for every node n of a line.
std::vector<std::complex<double>> along(double k_radpm, double spacing_m, int size) {
    std::vector<std::complex<double>> line;
    for (int i = 0; i < size; ++i)
        line.push_back(std::polar(1.0, k_radpm * i * spacing_m));
    return line;
}

/// Plane waves are products of a factor along x and one along y: no sine a node.
void add_plane_waves(const SineField& field, TimeUs phase_time, Keyframe& keyframe) {
    struct Factors {
        std::vector<std::complex<double>> columns;
        std::vector<std::complex<double>> rows;
    };
    const double spacing = keyframe.length_m / keyframe.size;
    const auto size = static_cast<std::size_t>(keyframe.size);
    std::vector<Factors> factors;
    for (const SineField::Wave& wave : field.waves)
        factors.push_back({along(wave.kx_radpm, spacing, keyframe.size),
                           along(wave.ky_radpm, spacing, keyframe.size)});
    for (std::size_t iy = 0; iy < size; ++iy) {
        std::vector<LagrangianPoint> nodes(size);
        for (std::size_t w = 0; w < factors.size(); ++w) {
            const SineField::Wave& wave = field.waves[w];
            const std::complex<double> row =
                factors[w].rows[iy] *
                (field.share *
                 std::polar(wave.amplitude_m, wave.phase_rad - wave.turned_rad(phase_time)));
            for (std::size_t ix = 0; ix < size; ++ix) {
                const std::complex<double> column = factors[w].columns[ix];
                add_plane_wave(wave, row.real() * column.real() - row.imag() * column.imag(),
                               row.real() * column.imag() + row.imag() * column.real(), nodes[ix]);
            }
        }
        for (const Field f : keyframe.fields& sine_fields)
            for (std::size_t ix = 0; ix < size; ++ix)
                keyframe.plane(f)[iy * size + ix] += static_cast<float>(value_of(nodes[ix], f));
    }
}

/// Waves that drag one another, and noise.
void add_points(const SineField& field, TimeUs phase_time, Keyframe& keyframe) {
    const double spacing = keyframe.length_m / keyframe.size;
    for (int iy = 0; iy < keyframe.size; ++iy)
        for (int ix = 0; ix < keyframe.size; ++ix) {
            const LagrangianPoint point = sines_at(field, ix * spacing, iy * spacing, phase_time);
            const auto node = static_cast<std::size_t>(iy * keyframe.size + ix);
            for (const Field f : keyframe.fields& sine_fields)
                keyframe.plane(f)[node] += static_cast<float>(value_of(point, f));
        }
}

} // namespace

std::uint64_t add_sines(const SineField& field, TimeUs phase_time, Keyframe& keyframe) {
    keyframe.stylised = true;
    if ((keyframe.fields & sine_fields).empty())
        return 0;
    if (field.kind == SineKind::sine)
        add_plane_waves(field, phase_time, keyframe);
    else
        add_points(field, phase_time, keyframe);
    return keyframe.plane_size() * sine_terms(field);
}

} // namespace seaway::sea
