// SPDX-License-Identifier: Apache-2.0
// Stylised waves as statistics see them.
#include <cmath>
#include <memory>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "sea/basics/constants.h"
#include "sea/scene/scene.h"
#include "sea/waves/realize.h"
#include "sea/waves/reference.h"
#include "sea/waves/sine_waves.h"
#include "sea/waves/statistics/moments.h"

namespace seaway::sea {
namespace {

// Naive: all of a sharp wave turns and bends as its fundamental: of sharpness 10 its slopes have six times the variance.
TEST(Sines, a_sharp_waves_slopes_and_rates_are_those_of_all_its_harmonics) {
    for (const double sharpness : {0.1, 1.0, 3.0, 10.0}) {
        SineField field;
        field.length_m = 100;
        field.sharpness = sharpness;
        field.waves.push_back({two_pi / 50, two_pi / 25, 1.3, 0.4, 0, 0.7, 0});
        double square = 0, slope = 0, rate = 0;
        constexpr int n = 4096; // along x alone the whole phase is gone through
        for (int i = 0; i < n; ++i) {
            const LagrangianPoint at = sines_at(field, 50.0 * i / n, 0, 0);
            square += at.height * at.height / n;
            slope += (at.slope_x * at.slope_x + at.slope_y * at.slope_y) / n;
            rate += at.height_rate * at.height_rate / n;
        }
        double variance = 0, of_slope = 0, of_rate = 0;
        for (const SineLine& line : sine_lines(field)) {
            variance += line.variance_m2();
            of_slope += line.variance_m2() *
                        (line.kx_radpm * line.kx_radpm + line.ky_radpm * line.ky_radpm);
            of_rate += line.variance_m2() * line.omega_radps * line.omega_radps;
        }
        // A sum over equal steps of a periodic function is its integral; what is left is rounding.
        EXPECT_NEAR(variance, square, 1e-9 * square) << sharpness;
        EXPECT_NEAR(variance, 1.3 * 1.3 * exponential_sine(sharpness).variance, 1e-9 * variance);
        EXPECT_NEAR(of_slope, slope, 1e-9 * slope) << sharpness;
        EXPECT_NEAR(of_rate, rate, 1e-9 * rate) << sharpness;
    }
}

// Each wave moves those after it, by its second derivative: 64 of them at the ends of their ranges make of a rounding more than the sea
// is high, or infinities. Refused by name; what games draw is far below.
TEST(Sines, waves_that_drag_each_other_beyond_all_numbers_are_refused_by_name) {
    const auto sines = [](double amplitude_m, double sharpness, double drag, int count) {
        return fmt::format("[sea]\nseed = 3\n[[sea.system]]\ntype = \"sines\"\nfrom_deg = "
                           "270\nshape = \"exponential\"\nnormalise = false\n"
                           "amplitude_ratio = 1.0\nwavenumber_ratio = 1.0\ncount = {}\n"
                           "amplitude_m = {}\nlength_m = 128\nwavelength_m = 10\n"
                           "drag = {}\nsharpness = {}\n",
                           count, amplitude_m, drag, sharpness);
    };
    for (const std::string& toml :
         {sines(100, 10, 2, 64), sines(2, 2, 2, 64), sines(1, 1, 2, 64)}) {
        const Result<Scene> refused = parse_scene(toml, "test", ".");
        ASSERT_FALSE(refused) << toml;
        EXPECT_NE(refused.error().message.find("drag"), std::string::npos)
            << refused.error().message;
    }
    EXPECT_TRUE(parse_scene(sines(100, 10, 0, 64), "test", "."));
    EXPECT_TRUE(parse_scene(sines(0.1, 2, 0.4, 64), "test", "."));
}

/// Of the heights over a tile, all places alike.
double variance_of(const Realization& sea, double length_m) {
    constexpr int n = 256;
    const DirectSum sum(std::make_shared<const Realization>(sea));
    const DirectSum::Moment now = sum.at_time(0);
    double mean = 0, square = 0;
    for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x) {
            const double height_m = now.at(length_m * x / n, length_m * y / n).height;
            mean += height_m / (n * n);
            square += height_m * height_m / (n * n);
        }
    return square - mean * mean;
}

// Naive: of waves that snap to one vector, and turn alike, energies are added. So many places a side hold each of these waves.
TEST(Sines, waves_of_one_vector_add_up_with_their_phases_in_what_is_realised) {
    const auto ramps = [](SineKind kind, int count, double wavelength_m) {
        SineRamps made;
        made.kind = kind;
        made.count = count;
        made.wavelength_m = wavelength_m;
        made.amplitude_m = 1.0;
        made.wavenumber_ratio = 1.0;
        made.direction_spread_rad = 0.0;
        made.length_m = 256.0;
        return made;
    };
    SineRamps many = ramps(SineKind::sine, 64, 64.0);
    many.wavenumber_ratio = 1.05;
    many.direction_spread_rad = 0.5;
    const std::vector<std::vector<WaveSystem>> seas{
        {ramps(SineKind::sine, 8, 128.0)},
        {ramps(SineKind::exponential, 8, 128.0)},
        {many},
        {ramps(SineKind::sine, 1, 64.0), ramps(SineKind::sine, 1, 64.0)},
        {ramps(SineKind::sine, 1, 64.0), ramps(SineKind::exponential, 1, 64.0)},
        {ramps(SineKind::sine, 1, 64.0), ramps(SineKind::gerstner, 1, 64.0)},
        {ramps(SineKind::sine, 1, 64.0),
         ExplicitModes{256.0, {{4, 0, 0.7, 1.0}, {0, 3, 0.2, 0.0}}}}};
    for (const std::vector<WaveSystem>& systems : seas) {
        SeaState state;
        state.seed = 3;
        state.systems = systems;
        const Realization sea = *realize(state, std::vector<CascadeSpec>{{256.0, 256}});
        const SeaSummary summary = summarize(state, sea);
        const double found = variance_of(sea, 256.0);
        // Waves of other frequencies have nothing to do with one another on average over time; over a tile likewise.
        EXPECT_NEAR(std::pow(summary.realised.significant_height_m / 4, 2), found, 1e-6 * found);
        EXPECT_NEAR(summary.cascades.at(0).realised_m2, found, 1e-6 * found);
    }
}

} // namespace
} // namespace seaway::sea
