// SPDX-License-Identifier: Apache-2.0
// The mean direction of each frequency, from which the report has its direction and spread, is that of the
// energy that is drawn: the integral over all directions, for every kind of system.
#include <cmath>
#include <complex>
#include <vector>

#include <gtest/gtest.h>

#include "sea/waves/directional_spectrum.h"
#include "tests/sea/scene_of.h"

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
