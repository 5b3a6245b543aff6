// SPDX-License-Identifier: Apache-2.0
// The seas that a tuned scene is measured in beside its own: rougher and calmer ones, fresh seeds, and what
// the certificate says of them. Nothing is searched or measured here.
#include <cmath>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "tests/sea/scene_of.h"
#include "tools/bench/tune/tuner.h"

namespace seaway::bench {
namespace {

using testing::scene_of;

template <class System>
const System& system_of(const sea::Scene& scene, std::size_t index) {
    return std::get<System>(scene.sea.systems.at(index));
}

const char* const every_system = R"([sea]
seed = 5
[[sea.system]]
type = "wind"
spectrum = "jonswap"
from_deg = 250
wind_speed_10m_mps = 12
fetch_m = 80e3
[[sea.system]]
type = "wind"
spectrum = "pierson_moskowitz"
from_deg = 20
wind_speed_19m5_mps = 11
[[sea.system]]
type = "swell"
spectrum = "jonswap"
from_deg = 300
significant_height_m = 2.5
peak_period_s = 12
[[sea.system]]
type = "modes"
length_m = 300
data = '''
nx,ny,amplitude_m,phase_rad
3,1,0.5,0
'''
[[sea.system]]
type = "sines"
shape = "sine"
from_deg = 10
amplitude_m = 0.4
[[sea.system]]
type = "measured"
from_deg = 270
data = '''
f_hz,df_hz,s_m2_hz
0.08,0.01,1
0.09,0.01,3
0.10,0.01,1
'''
)";

// Froude: lengths grow by a factor, times by its root. So a swell keeps its steepness, Hs / Tp^2, and a wind
// sea grows by its wind, on the fetch that it has; waves that are given one by one or measured are what they
// are.
TEST(GrownSeas, winds_and_swells_grow_as_seas_do_and_what_is_given_or_measured_stays) {
    const sea::Scene given = scene_of(every_system);
    ASSERT_EQ(given.sea.systems.size(), 6u);
    for (const double factor : {0.9, 1.0, 1.1, 1.44}) {
        const sea::Scene other = grown(given, factor);
        const auto& wind = system_of<sea::WindSea>(other, 0);
        EXPECT_NEAR(wind.wind_speed_10m_mps, 12 * factor, 1e-12);
        EXPECT_EQ(wind.fetch_m, 80e3);
        EXPECT_FALSE(wind.wind_speed_19m5_mps);
        const auto& high = system_of<sea::WindSea>(other, 1);
        ASSERT_TRUE(high.wind_speed_19m5_mps);
        EXPECT_NEAR(*high.wind_speed_19m5_mps, 11 * factor, 1e-12);
        EXPECT_NEAR(high.wind_speed_10m_mps / *high.wind_speed_19m5_mps,
                    system_of<sea::WindSea>(given, 1).wind_speed_10m_mps / 11, 1e-12)
            << "one wind at two heights";
        const auto& swell = system_of<sea::Swell>(other, 2);
        EXPECT_NEAR(swell.significant_height_m, 2.5 * factor, 1e-12);
        EXPECT_NEAR(swell.significant_height_m / (swell.peak_period_s * swell.peak_period_s),
                    2.5 / 144, 1e-12);
        EXPECT_EQ(system_of<sea::ExplicitModes>(other, 3).modes.at(0).amplitude_m, 0.5);
        EXPECT_EQ(system_of<sea::SineRamps>(other, 4).amplitude_m, 0.4);
        EXPECT_EQ(system_of<sea::MeasuredSea>(other, 5).spectrum,
                  system_of<sea::MeasuredSea>(given, 5).spectrum);
        EXPECT_EQ(other.sea.height_scale, given.sea.height_scale) << "or they would grow too";
    }
}

// A fully developed sea alone: by its wind U, Hs goes as U^2 and Tp as U (Pierson and Moskowitz 1964); a
// swell's Hs as the factor and its Tp as the root. Both ends were measured, and the scene between them.
TEST(GrownSeas, a_certificate_reaches_from_the_calmer_sea_to_the_rougher_one) {
    const std::string swell = "type = \"swell\"\nspectrum = \"bretschneider\"\nfrom_deg = 300\n"
                              "significant_height_m = 2.5\npeak_period_s = 10\n";
    const std::string wind = "type = \"wind\"\nspectrum = \"pierson_moskowitz\"\nfrom_deg = 20\n"
                             "wind_speed_10m_mps = 10\n";
    struct Law {
        std::string system;
        double hs_power, tp_power;
    };
    for (const Law& law : {Law{swell, 1.0, 0.5}, Law{wind, 2.0, 1.0}}) {
        const sea::Scene scene =
            scene_of("[[sea.system]]\n" + law.system + "[[cascade]]\nlength_m = 1021\nsize = 64\n");
        const auto own = measured_envelope(scene, 0.0), seas = measured_envelope(scene, 0.2);
        ASSERT_TRUE(own && seas);
        EXPECT_EQ(own->low.hs_m, own->high.hs_m);
        EXPECT_EQ(own->low.tp_s, own->high.tp_s);
        // The peak is looked for in steps of 1.0005.
        for (const auto& [end, factor] : {std::pair{seas->low, 0.8}, std::pair{seas->high, 1.2}}) {
            EXPECT_NEAR(end.hs_m / own->low.hs_m, std::pow(factor, law.hs_power), 1e-6);
            EXPECT_NEAR(end.tp_s / own->low.tp_s, std::pow(factor, law.tp_power), 2e-3);
            EXPECT_NEAR(end.wind_speed_10m_mps, own->low.wind_speed_10m_mps * factor, 1e-9);
        }
    }
}

// A scene holds seeds below 2^63.
TEST(GrownSeas, fresh_seeds_are_all_different_and_fit_into_a_scene) {
    std::set<std::uint64_t> seen;
    for (std::uint64_t seed = 0; seed < 8; ++seed)
        for (std::uint64_t number = 0; number < 2000; ++number) {
            const std::uint64_t fresh = fresh_seed(seed, number);
            EXPECT_TRUE(seen.insert(fresh).second) << seed << ", " << number;
            EXPECT_LT(fresh, 1ull << 63);
        }
}

// What is measured is what the server would run: no tiles where nothing streams, nothing sideways where
// the scene has no displacement.
TEST(GrownSeas, a_scene_is_measured_with_what_it_streams_and_moves) {
    sea::Scene scene = scene_of(every_system);
    EXPECT_EQ(configuration_of(scene, "vulkan:1").device, "vulkan:1");
    EXPECT_NE(configuration_of(scene, "native").codec_error_m, 0.0);
    EXPECT_NE(configuration_of(scene, "native").choppiness, 0.0);
    scene.effects.choppy = false;
    EXPECT_EQ(configuration_of(scene, "native").choppiness, 0.0);
    scene.accuracy.preset = sea::AccuracyPreset::query_only;
    EXPECT_EQ(configuration_of(scene, "native").codec_error_m, 0.0);
    const Candidate candidate{.layout = {.cascades = {{400.0, 64}}}, .height_error_m = 0.07};
    const sea::Scene changed = with_candidate(scene, candidate);
    ASSERT_EQ(changed.cascades.size(), 1u);
    EXPECT_EQ(changed.cascades[0].length_m, 400.0);
    EXPECT_EQ(changed.accuracy.height_error_m, 0.07);
}

} // namespace
} // namespace seaway::bench
