// SPDX-License-Identifier: Apache-2.0
#include "sea/waves/statistics/lattice_bias.h"

#include <algorithm>
#include <cmath>
#include <complex>

#include "sea/waves/mode_variances.h"
#include "sea/waves/realize.h"
#include "sea/waves/statistics/frequency_nodes.h"
#include "sea/waves/statistics/given_waves.h"

namespace seaway::sea {

namespace {

/// Of m0 of one tile at one instant, over seeds: sum (E_k + E_-k)^2 over pairs of waves that are drawn.
double variance_of_m0(const std::vector<double>& variances, int size) {
    double squares = 0.0;
    for (int iy = 0; iy < size; ++iy)
        for (int ix = 0; ix < size; ++ix) {
            const double here = variances[static_cast<std::size_t>(iy * size + ix)];
            const double there =
                variances[static_cast<std::size_t>((size - iy) % size * size + (size - ix) % size)];
            squares += 0.25 * (here + there) * (here + there);
        }
    return 2.0 * squares;
}

/// What a tile holds of waves given one by one, and what they add to that variance: a given wave and a drawn one of its wavenumber add
/// up by their phases, |G + z|^2 / 2, whose middle term varies by 2 E_given (E_k + E_-k).
struct Given {
    double energy_m2 = 0.0;
    double variance_of_m0 = 0.0;

    void add(const GivenWave& wave, const CascadeSpec& spec, const std::vector<double>& drawn) {
        energy_m2 += wave.energy_m2;
        const double n = wave.k_radpm / spec.wavenumber_step_radpm();
        const long nx = std::lround(n * std::cos(wave.towards_rad));
        const long ny = std::lround(n * std::sin(wave.towards_rad));
        if (drawn.empty() || !wave.phased || 2 * std::max(std::abs(nx), std::abs(ny)) >= spec.size)
            return;
        const auto at = [&](long x, long y) {
            return drawn[static_cast<std::size_t>((y + spec.size) % spec.size * spec.size +
                                                  (x + spec.size) % spec.size)];
        };
        variance_of_m0 += 2.0 * wave.energy_m2 * (at(nx, ny) + at(-nx, -ny));
    }
};

/// Energy and its direction: sums of E and of E e^{i theta}.
struct Directed {
    double energy = 0.0;
    std::complex<double> direction;

    void add(double e, std::complex<double> d) {
        energy += e;
        direction += e * d;
    }
    double spread_rad() const {
        return std::sqrt(2.0 * (1.0 - std::min(1.0, std::abs(direction) / energy)));
    }
};

Directed directed(const std::vector<double>& variances, int size) {
    Directed sum;
    for (int iy = 0; iy < size; ++iy)
        for (int ix = 0; ix < size; ++ix)
            if (const double e = variances[static_cast<std::size_t>(iy * size + ix)]; e > 0.0) {
                const int nx = signed_index(ix, size), ny = signed_index(iy, size);
                sum.add(e, std::complex<double>(nx, ny) / std::hypot(nx, ny));
            }
    return sum;
}

Directed requested_in(const DirectionalSpectrum& spectrum, const Dispersion& dispersion,
                      Band band) {
    Directed sum;
    for (const QuadratureNode& node : kept_nodes(spectrum, dispersion, band)) {
        const double k = dispersion.wavenumber(node.x);
        sum.add(node.weight * spectrum.ring(k).density * k / dispersion.group_speed(k),
                spectrum.direction_moment(node.x));
    }
    return sum;
}

LatticeBias bias_of(std::size_t system, const Directed& requested, const Directed& expected) {
    LatticeBias bias{system, expected.energy / requested.energy};
    if (!(expected.energy > 0.0))
        return bias;
    // Below 1e-6 there is no mean direction to speak of.
    if (std::abs(requested.direction) > 1e-6 * requested.energy)
        bias.turned_rad = std::arg(expected.direction * std::conj(requested.direction));
    if (requested.spread_rad() > 1e-6)
        bias.spread = expected.spread_rad() / requested.spread_rad();
    return bias;
}

} // namespace

void add_expected(const SeaState& sea, const Realization& realization, SeaSummary& summary) {
    const Dispersion dispersion = sea.dispersion();
    std::vector<std::vector<double>> all(realization.cascades.size());
    for (std::size_t s = 0; s < sea.systems.size(); ++s) {
        const DirectionalSpectrum spectrum(sea.systems[s], sea);
        Directed requested, expected;
        for (std::size_t c = 0; c < all.size(); ++c) {
            const CascadeModes& cascade = realization.cascades[c];
            if (spectrum.empty() || !cascade.carries_spectra)
                continue;
            const std::vector<double> variances =
                mode_variances(spectrum, cascade.spec, cascade.band);
            const Directed one = directed(variances, cascade.spec.size);
            const Directed asked = requested_in(spectrum, dispersion, cascade.band);
            expected.energy += one.energy;
            expected.direction += one.direction;
            requested.energy += asked.energy;
            requested.direction += asked.direction;
            summary.cascades[c].expected_m2 += one.energy;
            all[c].resize(variances.size());
            for (std::size_t i = 0; i < variances.size(); ++i)
                all[c][i] += variances[i];
        }
        if (requested.energy > 0.0)
            summary.lattice.push_back(bias_of(s, requested, expected));
    }
    std::vector<Given> given(all.size());
    each_given_wave(sea, [&](const GivenWave& wave) {
        for (std::size_t c = 0; c < all.size(); ++c)
            if (const CascadeSpec& spec = realization.cascades[c].spec;
                same_tile_length(spec.length_m, wave.tile_m))
                return given[c].add(wave, spec, all[c]);
    });
    for (std::size_t c = 0; c < all.size(); ++c) {
        CascadeVariance& tile = summary.cascades[c];
        tile.requested_m2 += given[c].energy_m2;
        tile.expected_m2 += given[c].energy_m2;
        if (all[c].empty() || !(tile.expected_m2 > 0.0))
            continue;
        const double drawn = variance_of_m0(all[c], realization.cascades[c].spec.size);
        tile.expected_scatter =
            std::sqrt(drawn + given[c].variance_of_m0) / (2.0 * tile.expected_m2);
    }
}

} // namespace seaway::sea
