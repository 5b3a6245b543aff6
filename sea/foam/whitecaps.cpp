// SPDX-License-Identifier: Apache-2.0
#include "sea/foam/whitecaps.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "sea/spectrum/spectra.h"
#include "sea/waves/directional_spectrum.h"

namespace seaway::sea {

namespace {

double cube(double x) {
    return x * x * x;
}

/// The strongest wind that is given; none without a wind system.
std::optional<double> given_wind_mps(const SeaState& sea) {
    std::optional<double> strongest;
    for (const WaveSystem& system : sea.systems)
        if (const auto* wind = std::get_if<WindSea>(&system))
            strongest = std::max(strongest.value_or(0.0), wind->wind_speed_10m_mps);
    return strongest;
}

} // namespace

double whitecap_share(double wind_speed_10m_mps) {
    constexpr double onset_mps = 3.70, last_mps = 23.09;
    const double wind = std::min(wind_speed_10m_mps, last_mps);
    if (!(wind > onset_mps))
        return 0.0;
    const double light = 3.18e-5 * cube(wind - onset_mps);
    const double strong = 4.82e-6 * cube(wind + 1.98);
    // They cross once, at 10.19 m/s; on either side the lower one is the one that was fitted there.
    return std::min(light, strong);
}

FoamWind foam_wind(const SeaState& sea) {
    if (const std::optional<double> given = given_wind_mps(sea))
        return {*given, FoamWind::Origin::given};
    std::vector<DirectionalSpectrum> spectra;
    for (const WaveSystem& system : sea.systems)
        if (DirectionalSpectrum spectrum(system, sea); !spectrum.empty())
            spectra.push_back(std::move(spectrum));
    if (spectra.empty())
        return {0.0, FoamWind::Origin::by_hand};
    // Periods from 63 s to 0.16 s in steps of half a percent.
    constexpr double omega_min_radps = 0.1, omega_max_radps = 40.0, step = 0.005;
    // A sea that is grown lies on the limit: a thousandth for rounding.
    const double peak_level =
        0.999 * 8.1e-3 * std::exp(-1.25) * sea.gravity_mps2 * sea.gravity_mps2;
    double wind_sea_m2 = 0.0;
    for (double omega = omega_min_radps; omega < omega_max_radps; omega *= 1.0 + step) {
        double density = 0.0;
        for (const DirectionalSpectrum& spectrum : spectra)
            density += spectrum.frequency_density(omega);
        if (density >= peak_level / std::pow(omega, 5))
            wind_sea_m2 += density * omega * step;
    }
    if (!(wind_sea_m2 > 0.0))
        return {0.0, FoamWind::Origin::swell};
    // Above its peak a Pierson-Moskowitz sea holds this share of its variance.
    const double above_peak = 1.0 - std::exp(-1.25);
    return {grown_sea_wind_10m_mps(wind_sea_m2 / above_peak, sea.gravity_mps2),
            FoamWind::Origin::equivalent};
}

std::string describe(const FoamWind& wind) {
    switch (wind.origin) {
    case FoamWind::Origin::given:
        return fmt::format("at {:.3g} m/s", wind.speed_10m_mps);
    case FoamWind::Origin::equivalent:
        return fmt::format("at {:.3g} m/s, the wind of a grown sea like the steep part of this one",
                           wind.speed_10m_mps);
    case FoamWind::Origin::swell:
        return "without wind: all of this sea is swell, too long for its height to be a wind sea";
    case FoamWind::Origin::by_hand:
        break;
    }
    return "without wind: waves given by hand have none; foam.threshold gives them foam";
}

} // namespace seaway::sea
