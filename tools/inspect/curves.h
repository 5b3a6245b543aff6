// SPDX-License-Identifier: Apache-2.0
// The numbers behind the picture of a scene.
#pragma once

#include <vector>

#include "sea/waves/directional_spectrum.h"
#include "tools/inspect/report.h"
#include "tools/plot/plot.h"

namespace seaway::inspect {

/// The wave systems of a scene that have a spectrum, summed.
class SeaSpectrum {
  public:
    explicit SeaSpectrum(const sea::SeaState& sea);

    bool empty() const { return systems_.empty(); }
    /// S(w), m2 s/rad, as asked for.
    double density(double omega_radps) const;
    /// S(w) that fade and cut-offs leave.
    double kept_density(double omega_radps) const;
    /// D of all systems together, 1/rad; theta is where waves go, from east.
    double spreading(double omega_radps, double towards_rad) const;
    double lowest_peak_radps() const;
    double highest_peak_radps() const;

  private:
    sea::Dispersion dispersion_;
    std::vector<sea::DirectionalSpectrum> systems_;
};

/// Energy of the drawn modes as points (w, S): rings of the lattice, put together until each spans
/// a tenth of its wavenumber.
std::vector<plot::Point> realised_density(const sea::CascadeModes& modes,
                                          const sea::Dispersion& dispersion);

/// A wave that was given by itself.
struct ExplicitWave {
    double omega_radps;
    double towards_rad;
    double amplitude_m;
};

/// Every wave of a sea without spectra, stylised ones included.
std::vector<ExplicitWave> explicit_waves(const sea::Realization& sea);

/// Range of frequencies worth showing.
struct FrequencyRange {
    double lo_radps;
    double hi_radps;
};
FrequencyRange frequency_range(const Report& report, const SeaSpectrum& spectrum);

} // namespace seaway::inspect
