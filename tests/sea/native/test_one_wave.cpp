// SPDX-License-Identifier: Apache-2.0
// A sea of one wave alone. Random seas fill every quadrant and every block of columns, so they do not
// see a wave that is lost because of where it stands; one wave alone is lost or it is not.
#include "sea/native/native_runner.h"

#include <algorithm>
#include <numbers>
#include <set>

#include <gtest/gtest.h>

#include "base/worse.h"
#include "tests/sea/native/every_transform.h"
#include "tests/sea/native/random_modes.h"

namespace seaway::sea {
namespace {

constexpr TimeUs t_us = 12'340'000;
constexpr double amplitude_m = 1.5;
constexpr double phase_at_0_rad = 0.7;

/// eta = amplitude cos(k.X - w t + phase), and what it is in the maps.
struct Wave {
    int nx, ny;

    double angle_rad(const CascadeModes& modes, int x, int y) const {
        const int size = modes.spec.size;
        // Whole turns are left out as integers: the rest is exact.
        const int turns = ((nx * x + ny * y) % size + size) % size;
        return 2 * std::numbers::pi * turns / size - phase_rad(modes.rate[index(size)], t_us) +
               phase_at_0_rad;
    }
    std::size_t index(int size) const {
        return static_cast<std::size_t>((ny + size) % size * size + (nx + size) % size);
    }
    void put(CascadeModes& modes) const {
        const Rate rate = rate_from_omega(
            std::sqrt(9.81 * std::hypot(nx, ny) * modes.spec.wavenumber_step_radpm()));
        modes.h0[index(modes.spec.size)] = std::polar(amplitude_m / 2, phase_at_0_rad);
        modes.rate[index(modes.spec.size)] = modes.rate[Wave{-nx, -ny}.index(modes.spec.size)] =
            rate;
    }
    void take(CascadeModes& modes) const { modes.h0[index(modes.spec.size)] = 0; }
};

class OneWave : public testing::TestWithParam<TransformCase> {};

/// kx at both edges of every block of columns. Blocks are 4, 8 or 16 wide: the small sizes are cut at
/// every 4, which is the edge of all; the large ones at every 16, and at 4 and 8 at either end.
std::vector<int> block_edges(int size) {
    std::set<int> edges;
    const int step = size <= 256 ? 4 : 16, last = size / 2;
    for (int kx = 0; kx < last; kx += step)
        edges.insert({kx, std::min(kx + step, last) - 1});
    for (int kx : {3, 4, 7, 8, last - 9, last - 8, last - 5, last - 4})
        if (kx >= 0 && kx < last)
            edges.insert(kx);
    return {edges.begin(), edges.end()};
}

// The map of a wave is right to 1e-6 of four times its rms (test_native_transform.cpp says why), which
// is 2.8 amplitudes; a slope is its height times k.
TEST_P(OneWave, of_every_sign_at_every_edge_of_a_block_is_the_direct_sum) {
    const auto [instructions, size] = GetParam();
    const FieldSet fields =
        size <= 256 ? FieldSet{Field::height, Field::slope_y} : FieldSet{Field::height};
    const auto n = static_cast<std::size_t>(size);
    CascadeModes modes = random_modes(size, 0, 1);
    const double step = modes.spec.wavenumber_step_radpm();
    std::vector<float> planes(static_cast<std::size_t>(fields.size()) * n * n);
    NativeRunner runner(2);
    const int reaches[] = {1, 5, size / 4, size / 2 - 1};
    int turn = 0;
    for (int kx : block_edges(size)) {
        const int ky = reaches[turn++ % 4];
        for (const Wave wave : {Wave{kx, ky}, Wave{kx, -ky}, Wave{-kx, ky}, Wave{-kx, -ky}}) {
            wave.put(modes);
            const auto cascade = NativeTransform::create(modes, {}, instructions);
            const NativeTask task{&*cascade, t_us, fields, planes};
            runner.run({&task, 1});
            double worst = 0, worst_slope = 0;
            for (int i = 0; i < 256; ++i) {
                // Every row of the small ones, and points that share no factor with the size.
                const int x = (i * 37 + 11) % size,
                          y = (i * (size < 256 ? 1 : size / 256) + i / 7) % size;
                const std::size_t at =
                    static_cast<std::size_t>(y) * n + static_cast<std::size_t>(x);
                const double angle = wave.angle_rad(modes, x, y);
                worst = worse(worst, std::abs(planes[at] - amplitude_m * std::cos(angle)));
                if (fields.contains(Field::slope_y))
                    worst_slope = worse(worst_slope,
                                        std::abs(planes[n * n + at] +
                                                 amplitude_m * wave.ny * step * std::sin(angle)));
            }
            wave.take(modes);
            const double tolerance = 1e-6 * 4 * amplitude_m / std::sqrt(2.0);
            ASSERT_LT(worst, tolerance) << wave.nx << ", " << wave.ny;
            ASSERT_LT(worst_slope, tolerance * ky * step) << wave.nx << ", " << wave.ny;
        }
    }
}

TEST_P(OneWave, along_an_axis_is_the_direct_sum_too) {
    const auto [instructions, size] = GetParam();
    const auto n = static_cast<std::size_t>(size);
    CascadeModes modes = random_modes(size, 0, 1);
    std::vector<float> plane(n * n);
    NativeRunner runner(2);
    for (int k : {1, 3, 4, 7, size / 4, size / 2 - 1})
        for (const Wave wave : {Wave{k, 0}, Wave{-k, 0}, Wave{0, k}, Wave{0, -k}}) {
            wave.put(modes);
            const auto cascade = NativeTransform::create(modes, {}, instructions);
            const NativeTask task{&*cascade, t_us, {Field::height}, plane};
            runner.run({&task, 1});
            for (int i = 0; i < size; ++i) {
                const int x = i, y = (i * 5 + 3) % size;
                ASSERT_NEAR(plane[static_cast<std::size_t>(y) * n + static_cast<std::size_t>(x)],
                            amplitude_m * std::cos(wave.angle_rad(modes, x, y)),
                            1e-6 * 4 * amplitude_m)
                    << wave.nx << ", " << wave.ny;
            }
            wave.take(modes);
        }
}

TEST_P(OneWave, on_nyquist_is_taken_as_zero_as_the_header_says) {
    const auto [instructions, size] = GetParam();
    const auto n = static_cast<std::size_t>(size);
    NativeRunner runner(1);
    for (const Wave wave : {Wave{size / 2, 3}, Wave{3, size / 2}, Wave{size / 2, size / 2}}) {
        CascadeModes modes = random_modes(size, 0, 1);
        wave.put(modes);
        std::vector<float> plane(n * n, NAN);
        const auto cascade = NativeTransform::create(modes, {}, instructions);
        const NativeTask task{&*cascade, t_us, {Field::height}, plane};
        runner.run({&task, 1});
        EXPECT_TRUE(std::all_of(plane.begin(), plane.end(), [](float v) { return v == 0; }))
            << wave.nx << ", " << wave.ny;
    }
}

INSTANTIATE_TEST_SUITE_P(Native, OneWave, testing::ValuesIn(every_transform()), name_of);

} // namespace
} // namespace seaway::sea
