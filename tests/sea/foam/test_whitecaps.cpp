// SPDX-License-Identifier: Apache-2.0
#include "sea/foam/whitecaps.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace seaway::sea {
namespace {

TEST(Whitecaps, cover_what_callaghan_and_others_photographed) {
    // 3.18e-3 (U - 3.70)^3 percent and 4.82e-4 (U + 1.98)^3 percent, by hand.
    EXPECT_EQ(whitecap_share(0.0), 0.0);
    EXPECT_EQ(whitecap_share(3.70), 0.0);
    EXPECT_NEAR(whitecap_share(5.0), 6.986e-5, 1e-8);
    EXPECT_NEAR(whitecap_share(8.0), 0.0025283, 1e-7);
    EXPECT_NEAR(whitecap_share(12.0), 0.0131695, 1e-7);
    EXPECT_NEAR(whitecap_share(19.0), 0.0445106, 1e-7);
    EXPECT_NEAR(whitecap_share(23.09), 0.0759469, 1e-7);
}

TEST(Whitecaps, never_jump_and_never_fall_with_the_wind_and_level_off) {
    double before = 0.0;
    for (double wind = 0.0; wind <= 100.0; wind += 0.001) {
        const double share = whitecap_share(wind);
        ASSERT_GE(share, before) << wind;
        ASSERT_LT(share - before, 2e-5) << wind; // the steepest is 9.1e-3 a m/s
        before = share;
    }
    EXPECT_EQ(whitecap_share(45.0), whitecap_share(23.09));
    EXPECT_LT(before, 0.1);
}

SeaState with(const WaveSystem& system) {
    SeaState sea;
    sea.systems.assign(1, system);
    return sea;
}

TEST(Whitecaps, go_by_the_strongest_wind_that_is_given) {
    SeaState sea = with(WindSea{.wind_speed_10m_mps = 8.0});
    sea.systems.emplace_back(Swell{.significant_height_m = 9.0, .peak_period_s = 10.0});
    sea.systems.emplace_back(WindSea{.wind_speed_10m_mps = 11.0});
    EXPECT_EQ(foam_wind(sea).speed_10m_mps, 11.0);
    EXPECT_EQ(foam_wind(sea).origin, FoamWind::Origin::given);
    std::reverse(sea.systems.begin(), sea.systems.end());
    EXPECT_EQ(foam_wind(sea).speed_10m_mps, 11.0) << "whichever stands first";
}

TEST(Whitecaps, a_grown_sea_given_by_height_and_period_has_its_own_wind) {
    // Pierson-Moskowitz: Hs = 0.2092 U^2/g at 19.5 m, Tp = 5.00 sqrt(Hs). 1 % for sums in steps of half a
    // percent of frequency.
    for (const auto& [wind, g] :
         {std::pair(6.0, 9.81), {12.0, 9.81}, {20.0, 9.81}, {12.0, 3.72}, {12.0, 24.8}}) {
        const double at_19m5 = wind_19m5_over_10m * wind;
        const double hs = 4.0 * std::sqrt(8.1e-3 / (4.0 * 0.74)) * at_19m5 * at_19m5 / g;
        const double tp = two_pi * at_19m5 / (std::pow(0.8 * 0.74, 0.25) * g);
        SeaState sea = with(Swell{.spectrum = SpectrumKind::bretschneider,
                                  .significant_height_m = hs,
                                  .peak_period_s = tp});
        sea.gravity_mps2 = g;
        const FoamWind found = foam_wind(sea);
        EXPECT_EQ(found.origin, FoamWind::Origin::equivalent);
        EXPECT_NEAR(found.speed_10m_mps, wind, 0.01 * wind);
    }
}

TEST(Whitecaps, swell_under_a_wind_sea_adds_no_wind) {
    const Swell swell{.significant_height_m = 2.0, .peak_period_s = 15.0, .gamma = 6.0};
    const Swell sea{
        .spectrum = SpectrumKind::bretschneider, .significant_height_m = 2.5, .peak_period_s = 7.5};
    EXPECT_EQ(foam_wind(with(swell)).origin, FoamWind::Origin::swell);
    EXPECT_EQ(foam_wind(with(swell)).speed_10m_mps, 0.0);
    SeaState both = with(sea);
    both.systems.emplace_back(swell);
    EXPECT_NEAR(foam_wind(both).speed_10m_mps, foam_wind(with(sea)).speed_10m_mps, 0.3);
}

} // namespace
} // namespace seaway::sea
