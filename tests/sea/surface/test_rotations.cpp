// SPDX-License-Identifier: Apache-2.0
// Maps of heights and rates at another time (sea/surface/maps/rotations.h), against sums of single waves.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "sea/basics/constants.h"
#include "sea/surface/maps/predictor.h"
#include "sea/surface/maps/regrid.h"
#include "sea/surface/maps/rotations.h"
#include "sea/waves/realize.h"

namespace seaway::sea {
namespace {

/// One way each: (nx, ny) and (-nx, -ny) are different waves.
struct Wave {
    int nx, ny;
    double amplitude_m, phase;
};

struct Sea {
    double length_m;
    WaveLaw law;
    std::vector<Wave> waves;

    double w(const Wave& wave) const {
        const double k = two_pi * std::hypot(wave.nx, wave.ny) / length_m;
        return omega_from_rate(mode_rate(law.dispersion.omega(k), law.loop_period_us));
    }
    double rms() const {
        double m2 = 0;
        for (const Wave& wave : waves)
            m2 += 0.5 * wave.amplitude_m * wave.amplitude_m;
        return std::sqrt(m2);
    }
    /// h = a cos(k x - w t + phase), and its rate.
    void maps(int size, double t_s, std::vector<float>& height, std::vector<float>& rate) const {
        height.clear();
        rate.clear();
        std::vector<double> w_radps; // not anew at each point
        for (const Wave& wave : waves)
            w_radps.push_back(w(wave));
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x) {
                double h = 0, r = 0;
                for (std::size_t i = 0; i < waves.size(); ++i) {
                    const Wave& wave = waves[i];
                    const double angle =
                        two_pi * (wave.nx * x + wave.ny * y) / size - w_radps[i] * t_s + wave.phase;
                    h += wave.amplitude_m * std::cos(angle);
                    r += wave.amplitude_m * w_radps[i] * std::sin(angle);
                }
                height.push_back(static_cast<float>(h));
                rate.push_back(static_cast<float>(r));
            }
    }
};

Sea drawn(double length_m, int size, const WaveLaw& law, unsigned seed) {
    Sea sea{length_m, law, {}};
    std::mt19937 numbers(seed);
    std::uniform_real_distribution<double> any(-1.0, 1.0);
    while (sea.waves.size() < 40) {
        const int nx = static_cast<int>(any(numbers) * size / 2);
        const int ny = static_cast<int>(any(numbers) * size / 2);
        if (nx * nx + ny * ny == 0 || 4 * (nx * nx + ny * ny) >= size * size)
            continue;
        sea.waves.push_back({nx, ny, 1.0 / (1.0 + 0.1 * (nx * nx + ny * ny)), 3.0 * any(numbers)});
        if (sea.waves.size() % 4 == 0) // against it, as long
            sea.waves.push_back({-nx, -ny, 0.7 * sea.waves.back().amplitude_m, 3.0 * any(numbers)});
    }
    return sea;
}

double gap(std::span<const float> a, std::span<const float> b) {
    double most = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        most = std::max(most, std::abs(static_cast<double>(a[i]) - static_cast<double>(b[i])));
    return most;
}

const WaveLaw deep{}, shallow{{.depth_m = 7.0}, 0}, looped{{}, 20'000'000};

TEST(Rotations, waves_of_both_ways_run_as_their_law_says) {
    for (const WaveLaw& law : {deep, shallow, looped})
        for (const int size : {15, 64, 80}) {
            const double length_m = 300;
            const Sea sea = drawn(length_m, size, law, 3);
            std::vector<float> h, r, h_then, r_then;
            sea.maps(size, 0, h, r);
            for (const TimeUs forward_us :
                 {TimeUs{0}, TimeUs{320'000}, TimeUs{-1'280'000}, TimeUs{86'400'000'000}}) {
                sea.maps(size, seconds_from_us(forward_us), h_then, r_then);
                std::vector<float> out_h(h.size()), out_r(h.size());
                Predictor().maps(size, length_m, law, forward_us, h, r, out_h, out_r);
                // Single precision of the transforms, of the tables and of the maps given: as of a regrid, thrice.
                const double bound_m = 3 * regrid_precision * 4 * sea.rms();
                EXPECT_LE(gap(out_h, h_then), bound_m) << size << ", " << forward_us;
                // A rate is as much larger as the fastest wave turns.
                const double w_max = law.dispersion.omega(std::numbers::pi * size / length_m) + 0.5;
                EXPECT_LE(gap(out_r, r_then), bound_m * std::max(w_max, 1.0));
            }
        }
}

TEST(Rotations, all_instructions_come_to_the_same_bits) {
    for (const int size : {15, 72, 80, 160, 256}) {
        const Sea sea = drawn(300, size, deep, 5);
        std::vector<float> h, r;
        sea.maps(size, 0, h, r);
        const Rotations rotations(size, 300, deep, 640'000);
        std::vector<float> first_h(h.size()), first_r(h.size()), out_h(h.size()), out_r(h.size());
        Regrid(size, size, Instructions::portable).maps(h, r, rotations, first_h, first_r);
        for (const Instructions instructions : supported_instructions()) {
            Regrid(size, size, instructions).maps(h, r, rotations, out_h, out_r);
            EXPECT_EQ(std::memcmp(out_h.data(), first_h.data(), 4 * h.size()), 0) << size;
            EXPECT_EQ(std::memcmp(out_r.data(), first_r.data(), 4 * h.size()), 0) << size;
        }
    }
}

TEST(Rotations, a_mean_stays_and_waves_beyond_the_disc_are_nobodys) {
    const int size = 20;
    Sea sea{100, deep, {{9, 9, 1.0, 0.3}}}; // a corner of the square
    std::vector<float> h, r;
    sea.maps(size, 0, h, r);
    for (float& value : h)
        value += 2.5f;
    std::vector<float> out_h(h.size()), out_r(h.size());
    Predictor().maps(size, 100, deep, 500'000, h, r, out_h, out_r);
    for (const float value : out_h)
        EXPECT_NEAR(value, 2.5f, 2e-6f);
    for (const float value : out_r)
        EXPECT_NEAR(value, 0.0f, 2e-5f);
}

// What no server of ours says but a hostile one might: nothing but finite numbers comes of it.
TEST(Rotations, impossible_laws_come_to_finite_numbers) {
    std::vector<float> h(64, 1.0f), r(64, 1.0f), out_h(64), out_r(64);
    h[9] = 3.0f;
    for (const WaveLaw& law :
         {WaveLaw{{1e3, 1.0, 1e-3}, 1}, {{1e3, 1.0, 1e300}, 2}, {{1e-3, 0.0, 1e-3}, time_us_max}})
        for (const double length_m : {1e-3, 1e9})
            for (const TimeUs forward_us : {time_us_max, -time_us_max, TimeUs{1}}) {
                Predictor().maps(8, length_m, law, forward_us, h, r, out_h, out_r);
                for (std::size_t i = 0; i < out_h.size(); ++i)
                    ASSERT_TRUE(std::isfinite(out_h[i]) && std::isfinite(out_r[i]));
            }
}

TEST(Predictor, what_it_keeps_has_a_bound_and_changes_nothing) {
    const Sea sea = drawn(300, 15, deep, 9);
    std::vector<float> h, r;
    sea.maps(15, 0, h, r);
    Predictor one;
    std::vector<float> out_h(h.size()), out_r(h.size()), fresh_h(h.size()), fresh_r(h.size());
    for (int round = 0; round < 2; ++round)
        for (TimeUs n = 1; n <= 2 * static_cast<TimeUs>(Predictor::kept_max); ++n) {
            const WaveLaw& law = n % 2 == 0 ? deep : shallow;
            one.maps(15, 300, law, n * 10'000, h, r, out_h, out_r);
            Predictor().maps(15, 300, law, n * 10'000, h, r, fresh_h, fresh_r);
            ASSERT_EQ(out_h, fresh_h);
            ASSERT_EQ(out_r, fresh_r);
        }
}

} // namespace
} // namespace seaway::sea
