// SPDX-License-Identifier: Apache-2.0
#include "sea/realize.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "sea/directional_spectrum.h"
#include "sea/gaussian.h"

namespace seaway::sea {

namespace {

using Ring = DirectionalSpectrum::Ring;

/// Adds one wave system to the modes of one cascade. What depends on |k| alone is computed once for
/// each nx^2 + ny^2: twelve times less than once for each mode.
class CascadeFiller {
  public:
    CascadeFiller(const SeaState& sea, CascadeModes& modes)
        : sea_(sea), modes_(modes), step_(modes.spec.wavenumber_step_radpm()),
          steps_max_(static_cast<int>(
              std::min(std::ceil(modes.band.k_hi_radpm / step_), modes.spec.size / 2 - 1.0))) {}

    void add(const DirectionalSpectrum& spectrum, std::uint32_t system) {
        if (spectrum.empty())
            return;
        std::vector<std::optional<Ring>> rings(
            static_cast<std::size_t>(2 * steps_max_ * steps_max_ + 1));
        for_each_mode([&](int nx, int ny, double k, std::size_t index) {
            std::optional<Ring>& ring = rings[static_cast<std::size_t>(nx * nx + ny * ny)];
            if (!ring)
                ring = spectrum.ring(k, lattice_exponent_max(k, step_));
            if (ring->density <= 0.0)
                return;
            const double theta = std::atan2(ny, nx) - spectrum.towards_rad();
            const double amplitude =
                0.5 * step_ * std::sqrt(ring->density * ring->spreading(theta));
            const GaussianPair xi =
                gaussian_pair({sea_.seed, system, cascade_key(modes_.spec.length_m), nx, ny});
            modes_.h0[index] += std::complex(amplitude * xi.real, amplitude * xi.imaginary);
        });
    }

    void fill_rates(TimeUs loop_period_us) {
        const Dispersion dispersion = sea_.dispersion();
        std::vector<std::optional<Rate>> rates(
            static_cast<std::size_t>(2 * steps_max_ * steps_max_ + 1));
        for_each_mode([&](int nx, int ny, double k, std::size_t index) {
            std::optional<Rate>& rate = rates[static_cast<std::size_t>(nx * nx + ny * ny)];
            if (!rate)
                rate = mode_rate(dispersion.omega(k), loop_period_us);
            modes_.rate[index] = *rate;
        });
    }

  private:
    template <class F>
    void for_each_mode(const F& f) const {
        const int size = modes_.spec.size;
        for (int ny = -steps_max_; ny <= steps_max_; ++ny)
            for (int nx = -steps_max_; nx <= steps_max_; ++nx) {
                const double k = step_ * std::sqrt(nx * nx + ny * ny);
                if ((nx != 0 || ny != 0) && modes_.band.contains(k))
                    f(nx, ny, k,
                      static_cast<std::size_t>((ny + size) % size * size + (nx + size) % size));
            }
    }

    const SeaState& sea_;
    CascadeModes& modes_;
    double step_;
    int steps_max_;
};

} // namespace

Rate mode_rate(double omega_radps, TimeUs loop_period_us) {
    if (loop_period_us <= 0)
        return rate_from_omega(omega_radps);
    const auto period = static_cast<double>(loop_period_us);
    const double turns = std::max(1.0, std::round(omega_radps * period / (two_pi * 1e6)));
    return static_cast<Rate>(turns * (0x1p64 / period) + 0.5);
}

double lattice_exponent_max(double k_radpm, double step_radpm) {
    const double spread = 0.5 * step_radpm / k_radpm;
    return 2.0 / (spread * spread);
}

Result<Realization> realize(const SeaState& sea, std::span<const CascadeSpec> cascades) {
    Result<std::vector<Band>> bands = assign_bands(cascades);
    if (!bands)
        return bands.error();
    Realization realization;
    realization.choppiness = sea.choppiness;
    realization.loop_period_us = us_from_seconds(sea.loop_period_s);
    std::vector<DirectionalSpectrum> spectra;
    for (const WaveSystem& system : sea.systems)
        spectra.emplace_back(system, sea);
    for (std::size_t c = 0; c < cascades.size(); ++c) {
        const auto points =
            static_cast<std::size_t>(cascades[c].size) * static_cast<std::size_t>(cascades[c].size);
        CascadeModes& modes = realization.cascades.emplace_back();
        modes = {cascades[c], (*bands)[c], std::vector<std::complex<double>>(points),
                 std::vector<Rate>(points)};
        CascadeFiller filler(sea, modes);
        filler.fill_rates(realization.loop_period_us);
        for (std::size_t s = 0; s < spectra.size(); ++s)
            filler.add(spectra[s], static_cast<std::uint32_t>(s));
    }
    return realization;
}

} // namespace seaway::sea
