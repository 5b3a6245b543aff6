// SPDX-License-Identifier: Apache-2.0
// The mean direction of each frequency, from which the report has its direction and spread, is that of the
// energy that is drawn: the integral over all directions, for every kind of system.
#include <cmath>
#include <complex>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sea/basics/quadrature.h"
#include "sea/waves/directional_spectrum.h"
#include "sea/waves/statistics/moments.h"
#include "tests/sea/scene_of.h"
#include "tests/sea/sea_fixture.h"

namespace seaway::sea {
namespace {

using testing::scene_of;

TEST(DirectionalSpectrum, direction_moments_are_integrals_of_the_energy_over_directions) {
    const std::string wind = "type = \"wind\"\nwind_speed_10m_mps = 11\nfrom_deg = 237\n";
    const std::string measured =
        "type = \"measured\"\ndata = \"\"\"\nf_hz,df_hz,s_m2_hz,r1,alpha1_deg,r2,alpha2_deg\n"
        "0.08,0.04,3,0.8,100,0.5,110\n0.12,0.04,5,0.6,140,0.3,20\n0.16,0.04,2,0.4,320,0.2,300\n"
        "\"\"\"\n";
    std::vector<std::string> systems{
        wind + "spectrum = \"phillips\"\nphillips_upwind = true\n",
        wind + "spectrum = \"phillips\"\n",
        wind + "isotropic = 0.3\n",
        wind + "swell = 0.6\n",
        "type = \"swell\"\nsignificant_height_m = 2\npeak_period_s = 8\nfrom_deg = 12\n",
        measured};
    for (const char* spreading : {"cos2", "cos2s", "mitsuyasu", "hasselmann", "donelan_banner"})
        systems.push_back(wind + "spreading = \"" + spreading + "\"\n" +
                          (std::string(spreading) == "cos2s" ? "spreading_exponent = 7\n" : ""));
    for (const std::string& system : systems) {
        const Scene scene = scene_of("[sea]\n[[sea.system]]\n" + system);
        const DirectionalSpectrum spectrum(scene.sea.systems[0], scene.sea);
        for (const double omega : {0.7, 0.9, 1.05}) {
            const DirectionalSpectrum::Ring ring =
                spectrum.ring(scene.sea.dispersion().wavenumber(omega));
            constexpr int steps = 7200;
            std::complex<double> sum;
            double all = 0;
            for (int i = 0; i < steps; ++i) {
                const double towards_rad = two_pi * i / steps;
                all += ring(towards_rad);
                sum += ring(towards_rad) * std::polar(1.0, towards_rad);
            }
            ASSERT_GT(all, 0) << system;
            // cos^2 has kinks where it ends, and swell narrows it to a power that has no closed form.
            EXPECT_LT(std::abs(spectrum.direction_moment(omega) - sum / all), 1e-3)
                << system << " at " << omega << " rad/s";
        }
    }
}

SeaStatistics requested(const SeaState& sea) {
    return summarize(sea, *testing::realized(sea, {{100.0, 32}})).requested;
}

/// The spread of all energy, integrated in fine steps between these multiples of the peak.
double spread_rad(const SeaState& sea, const std::vector<double>& cuts) {
    const DirectionalSpectrum spectrum(sea.systems.at(0), sea);
    double energy = 0;
    std::complex<double> moment;
    for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
        const double lo = std::log(cuts[i]), hi = std::log(cuts[i + 1]);
        const auto omega = [&](double x) { return std::exp(x) * spectrum.peak_omega_radps(); };
        const auto density = [&](double x) {
            return spectrum.frequency_density(omega(x)) * omega(x);
        };
        const auto part = [&](double x) { return spectrum.direction_moment(omega(x)); };
        energy += integrate(density, lo, hi, 400);
        moment += std::complex(
            integrate([&](double x) { return density(x) * part(x).real(); }, lo, hi, 400),
            integrate([&](double x) { return density(x) * part(x).imag(); }, lo, hi, 400));
    }
    return std::sqrt(2 * (1 - std::abs(moment) / energy));
}

// Hasselmann's exponent jumps at 1.05 peaks, Donelan's and Banner's at 0.95 and 1.6.
TEST(DirectionalSpectrum, the_spread_of_a_sea_is_its_integral_where_a_spreading_jumps) {
    SeaState sea;
    WindSea wind;
    wind.wind_speed_10m_mps = 21.37;
    wind.fetch_m = 1;
    const std::vector<double> cuts{0.25, 0.95, 1, 1.05, 1.6, 1000};
    for (const SpreadingKind kind : {SpreadingKind::hasselmann, SpreadingKind::cos2_hasselmann,
                                     SpreadingKind::donelan_banner, SpreadingKind::mitsuyasu}) {
        wind.spreading = {.kind = kind};
        sea.systems = {wind};
        EXPECT_NEAR(requested(sea).spread_rad, spread_rad(sea, cuts), 1e-7)
            << static_cast<int>(kind);
    }
    wind.spreading = {.kind = SpreadingKind::hasselmann};
    sea.systems = {wind};
    EXPECT_NEAR(requested(sea).spread_rad * 180 / pi, 62.369, 0.0005);
}

TEST(DirectionalSpectrum, a_spectrum_breaks_where_its_own_spreading_jumps) {
    SeaState sea = testing::swell_sea(2, 10);
    auto& swell = std::get<Swell>(sea.systems.at(0));
    const auto breaks = [&](SpreadingKind kind) {
        swell.spreading.kind = kind;
        std::vector<double> peaks = DirectionalSpectrum(sea.systems.at(0), sea).breaks();
        for (double& peak : peaks)
            peak *= 10 / two_pi;
        return peaks;
    };
    using ::testing::DoubleNear;
    const auto at = [](double x) { return DoubleNear(x, 1e-9); };
    using ::testing::ElementsAre;
    EXPECT_THAT(breaks(SpreadingKind::cos2s), ElementsAre(at(0.25), at(1), at(1000)));
    EXPECT_THAT(breaks(SpreadingKind::hasselmann),
                ElementsAre(at(0.25), at(1), at(1.05), at(1000)));
    EXPECT_THAT(breaks(SpreadingKind::donelan_banner),
                ElementsAre(at(0.25), at(0.95), at(1), at(1.6), at(1000)));
}

// Its very period, not that of the nearest step of a search. In shallow water the spectrum has its top elsewhere.
TEST(DirectionalSpectrum, a_scene_that_names_a_peak_is_said_to_have_asked_for_it) {
    for (const double period_s : {9.7, 13.37, 17.003}) {
        SeaState sea = testing::swell_sea(2, period_s);
        EXPECT_NEAR(requested(sea).peak_period_s / period_s, 1, 1e-12);
        std::get<Swell>(sea.systems.at(0)).spectrum = SpectrumKind::tma;
        sea.depth_m = 6;
        const DirectionalSpectrum spectrum(sea.systems.at(0), sea);
        const double found = two_pi / requested(sea).peak_period_s;
        EXPECT_GT(found, 1.001 * spectrum.peak_omega_radps());
        for (const double aside : {0.999, 1.001, spectrum.peak_omega_radps() / found})
            EXPECT_GT(spectrum.frequency_density(found), spectrum.frequency_density(aside * found));
    }
}

// Bretschneider 1959: its peak has no enhancement.
TEST(DirectionalSpectrum, a_bretschneider_swell_has_that_spectrum_by_height_and_peak_period) {
    const Scene scene = scene_of("[sea]\n[[sea.system]]\ntype = \"swell\"\nspectrum = "
                                 "\"bretschneider\"\nsignificant_height_m = 2.5\n"
                                 "peak_period_s = 11\nfrom_deg = 300\n");
    const DirectionalSpectrum spectrum(scene.sea.systems[0], scene.sea);
    const double peak = two_pi / 11;
    for (const double omega : {0.7 * peak, peak, 1.5 * peak, 3 * peak})
        EXPECT_NEAR(spectrum.frequency_density(omega) /
                        (5.0 / 16 * 2.5 * 2.5 * std::pow(peak, 4) / std::pow(omega, 5) *
                         std::exp(-1.25 * std::pow(peak / omega, 4))),
                    1, 1e-6)
            << omega;
}

} // namespace
} // namespace seaway::sea
