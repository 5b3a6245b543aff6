// SPDX-License-Identifier: Apache-2.0
// Identities of physics.md section 4 on the realised sea, by their numbers there.
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <map>
#include <numeric>
#include <tuple>
#include <vector>

#include "sea/basics/gaussian.h"
#include "sea/surface/inverse.h"
#include "sea/waves/directional_spectrum.h"
#include "sea/waves/statistics/moments.h"
#include "tests/sea/csv.h"
#include "tests/sea/sea_fixture.h"

namespace seaway::sea {
namespace {

using testing::one_wave;
using testing::realized;
using testing::windy_sea;

const std::vector<CascadeSpec> one_tile{{200.0, 32}};

/// All nodes of one tile at one time, [y][x]; n points a side.
std::vector<LagrangianPoint> nodes(const RealizationPtr& sea, double length_m, int n, TimeUs t) {
    const DirectSum sum(sea);
    const DirectSum::Moment moment = sum.at_time(t);
    std::vector<LagrangianPoint> points;
    for (int iy = 0; iy < n; ++iy)
        for (int ix = 0; ix < n; ++ix)
            points.push_back(moment.at(length_m * ix / n, length_m * iy / n));
    return points;
}

template <class F>
double mean(const std::vector<LagrangianPoint>& points, const F& f) {
    double sum = 0.0;
    for (const LagrangianPoint& p : points)
        sum += f(p);
    return sum / static_cast<double>(points.size());
}

struct Wave {
    double kx, ky, k;
    std::complex<double> h; ///< h(k,t)
    double h0_squared;
    double omega;
    std::complex<double> rate; ///< dh/dt
};

/// h(k,t) of every wave, from the definition.
std::vector<Wave> waves(const CascadeModes& modes, TimeUs t) {
    std::vector<Wave> all;
    const int size = modes.spec.size;
    for (int iy = 0; iy < size; ++iy)
        for (int ix = 0; ix < size; ++ix) {
            const auto i = static_cast<std::size_t>(iy * size + ix);
            const auto mirror =
                static_cast<std::size_t>((size - iy) % size * size + (size - ix) % size);
            if (modes.h0[i] == 0.0 && modes.h0[mirror] == 0.0)
                continue;
            const auto turn = std::polar(1.0, -phase_rad(modes.rate[i], t));
            const auto forward = modes.h0[i] * turn;
            const auto backward = std::conj(modes.h0[mirror] * turn);
            const double step = modes.spec.wavenumber_step_radpm();
            const double kx = step * signed_index(ix, size), ky = step * signed_index(iy, size);
            const double omega = omega_from_rate(modes.rate[i]);
            all.push_back({kx, ky, std::hypot(kx, ky), forward + backward,
                           std::norm(modes.h0[i]) + std::norm(modes.h0[mirror]), omega,
                           std::complex(0.0, omega) * (backward - forward)});
        }
    return all;
}

template <class F>
double wave_sum(const std::vector<Wave>& all, const F& f) {
    double sum = 0.0;
    for (const Wave& w : all)
        sum += f(w);
    return sum;
}

TEST(Identity, I2_I3_I8_I14_I17_hold_exactly_on_one_tile) {
    const auto sea = realized(windy_sea(), one_tile);
    for (const TimeUs t : {TimeUs{0}, us_from_seconds(86400.0)}) {
        const auto points = nodes(sea, 200.0, 32, t);
        const auto all = waves(sea->cascades[0], t);
        const double m0 = wave_sum(all, [](const Wave& w) { return std::norm(w.h); });
        const double tolerance = 1e-11; // rounding of sums of 1000 terms
        // I2 Parseval; I3 means vanish.
        EXPECT_NEAR(mean(points, [](auto& p) { return p.height * p.height; }) / m0, 1.0, tolerance);
        EXPECT_NEAR(mean(points, [](auto& p) { return p.height; }), 0.0, tolerance);
        EXPECT_NEAR(mean(points, [](auto& p) { return p.displacement_x; }), 0.0, tolerance);
        EXPECT_NEAR(mean(points, [](auto& p) { return p.displacement_y; }), 0.0, tolerance);
        // I8 mean square slope.
        const double mss = wave_sum(all, [](const Wave& w) { return w.k * w.k * std::norm(w.h); });
        EXPECT_NEAR(
            mean(points, [](auto& p) { return p.slope_x * p.slope_x + p.slope_y * p.slope_y; }) /
                mss,
            1.0, tolerance);
        // I17 mean(eta div D) = -sum k coth(kd) |h|^2; crests sharpen.
        const auto stretch = [](const Wave& w) { return w.k / std::tanh(w.k * 60.0); };
        const double k_sum =
            wave_sum(all, [&](const Wave& w) { return stretch(w) * std::norm(w.h); });
        EXPECT_NEAR(mean(points, [](auto& p) { return p.height * (p.strain_xx + p.strain_yy); }) /
                        -k_sum,
                    1.0, tolerance);
        // I14 div D = -|k| coth(kd) h: its mean square is sum k^2 coth^2 |h|^2.
        const double div_2 =
            wave_sum(all, [&](const Wave& w) { return std::pow(stretch(w), 2) * std::norm(w.h); });
        EXPECT_NEAR(mean(points, [](auto& p) { return std::pow(p.strain_xx + p.strain_yy, 2); }) /
                        div_2,
                    1.0, tolerance);
    }
}

// I13 on a grid four times as fine as the modes need.
TEST(Identity, I13_slopes_are_the_derivative_of_the_height) {
    const auto sea = realized(windy_sea(), one_tile);
    const int n = 256;
    const double spacing = 200.0 / n;
    const DirectSum sum(sea);
    const auto moment = sum.at_time(0);
    double error = 0.0, rms = 0.0;
    for (int i = 0; i < 200; ++i) {
        const double x = 3.1 * i, y = 1.7 * i;
        // Fourth-order central difference: (k dx)^4 / 30 at k = 0.3 rad/m is 1e-4.
        const double difference =
            (8 * (moment.at(x + spacing, y).height - moment.at(x - spacing, y).height) -
             (moment.at(x + 2 * spacing, y).height - moment.at(x - 2 * spacing, y).height)) /
            (12 * spacing);
        const double slope = moment.at(x, y).slope_x;
        error += std::pow(difference - slope, 2);
        rms += slope * slope;
    }
    EXPECT_LT(std::sqrt(error / rms), 1e-3);
}

TEST(Identity, I4_I5_energy_is_constant_where_the_variance_is_not) {
    const auto sea = realized(windy_sea(), one_tile);
    const CascadeModes& modes = sea->cascades[0];
    double low = 1e30, high = 0.0;
    for (const double t : {0.0, 1.7, 60.0, 1e4, 1e6, 1e9}) {
        for (const Wave& w : waves(modes, us_from_seconds(t))) {
            const double energy = 0.5 * (std::norm(w.h) + std::norm(w.rate) / (w.omega * w.omega));
            ASSERT_NEAR(energy / w.h0_squared, 1.0, 1e-10); // I4
        }
        const double m0 = wave_sum(waves(modes, us_from_seconds(t)),
                                   [](const Wave& w) { return std::norm(w.h); });
        low = std::min(low, m0);
        high = std::max(high, m0);
    }
    const double mean_m0 = testing::energy_of(modes);
    EXPECT_GT(high, low * 1.001); // k and -k beat (I5)
    EXPECT_LE(high, 2.0 * mean_m0);
    EXPECT_NEAR(low / mean_m0, 1.0, 0.3);
}

TEST(Identity, I7_crossings_of_a_point_record_have_the_period_of_the_moments) {
    const auto sea = realized(windy_sea(5), {{400.0, 64}});
    // At one point, waves of one frequency (the lattice has up to 16) add up to one oscillation.
    std::map<Rate, std::complex<double>> oscillations;
    const CascadeModes& modes = sea->cascades[0];
    const double step_k = modes.spec.wavenumber_step_radpm();
    for (int i = 0; i < 64 * 64; ++i)
        oscillations[modes.rate[static_cast<std::size_t>(i)]] +=
            modes.h0[static_cast<std::size_t>(i)] *
            std::polar(1.0,
                       step_k * (11.0 * signed_index(i % 64, 64) + 5.0 * signed_index(i / 64, 64)));
    double m0 = 0.0, m2 = 0.0;
    for (const auto& [rate, a] : oscillations) {
        m0 += 2.0 * std::norm(a);
        m2 += 2.0 * std::norm(a) * std::pow(omega_from_rate(rate), 2);
    }
    const double tz = two_pi * std::sqrt(m0 / m2);
    const DirectSum sum(sea);
    int crossings = 0;
    double last = -1.0;
    const int samples = 6000;
    const double step = tz / 12.0;
    double square = 0.0;
    for (int i = 0; i < samples; ++i) {
        const double eta = sum.at(11.0, 5.0, us_from_seconds(i * step)).height;
        crossings += last < 0.0 && eta >= 0.0;
        last = eta;
        square += eta * eta / samples;
    }
    EXPECT_NEAR(samples * step / crossings / tz, 1.0, 0.03); // 500 waves: 3 %
    // A record's variance: sqrt(kappa Tp / T), three of them.
    EXPECT_NEAR(square / m0, 1.0, 3.0 * std::sqrt(1.52 * 1.3 * tz / (samples * step)));
}

// I10; naive tests take pixels for independent and fail a correct sea.
TEST(Identity, I10_height_is_gaussian_over_seeds) {
    std::vector<double> skews, seconds, fourths;
    const int seeds = 60;
    for (int seed = 0; seed < seeds; ++seed) {
        const auto sea = realized(windy_sea(1000 + seed), one_tile);
        const auto points = nodes(sea, 200.0, 16, 0);
        const auto moment = [&](int power) {
            return mean(points, [&](auto& p) { return std::pow(p.height, power); });
        };
        seconds.push_back(moment(2));
        fourths.push_back(moment(4));
        skews.push_back(moment(3) / std::pow(moment(2), 1.5));
    }
    // Excess of the fourth moment over three times the square of the variance of all seeds, m4/v^2 - 3; each seed's share of it
    // holds what it does to v. By the variance of each seed the mean would be less by its scatter.
    const double v = std::accumulate(seconds.begin(), seconds.end(), 0.0) / seeds;
    std::vector<double> kurts;
    for (std::size_t i = 0; i < seconds.size(); ++i)
        kurts.push_back(fourths[i] / (v * v) - 6.0 * seconds[i] / v + 3.0);
    const auto within_3_errors = [](const std::vector<double>& values) {
        const double n = static_cast<double>(values.size());
        const double m = std::accumulate(values.begin(), values.end(), 0.0) / n;
        double var = 0.0;
        for (const double v : values)
            var += (v - m) * (v - m) / (n - 1);
        return std::abs(m) < 3.0 * std::sqrt(var / n);
    };
    EXPECT_TRUE(within_3_errors(skews));
    EXPECT_TRUE(within_3_errors(kurts));
}

TEST(Identity, I11_a_wave_moves_at_its_phase_speed) {
    const auto sea = one_wave(100.0, 64, 3, 4, 1.0, 0.3, 7.0);
    const DirectSum sum(sea);
    const double k = two_pi / 100.0 * 5.0;
    const Dispersion d{9.81, 7.4e-5, 7.0};
    // In a single wave, height and tanh(kd) displacement are cosine and sine of the phase.
    const auto phase = [&](TimeUs t) {
        const LagrangianPoint p = sum.at(0, 0, t);
        return std::atan2(-std::tanh(7.0 * k) * (0.6 * p.displacement_x + 0.8 * p.displacement_y),
                          p.height);
    };
    const TimeUs dt = 200'000;
    const double speed = std::remainder(phase(1'000'000) - phase(1'000'000 + dt), two_pi) /
                         (k * seconds_from_us(dt));
    EXPECT_NEAR(speed / (d.omega(k) / k), 1.0, 1e-5);
}

TEST(Identity, I12_all_energy_lies_on_the_dispersion_shell) {
    SeaState state = windy_sea();
    state.loop_period_s = 64.0; // frequencies are exact bins of a 64 s record
    const auto sea = realized(state, one_tile);
    const DirectSum sum(sea);
    const int n = 64;      // times, one second apart: waves below 3 rad/s
    const int points = 32; // along x
    std::vector<std::vector<double>> eta(n, std::vector<double>(points));
    for (int t = 0; t < n; ++t) {
        const auto moment = sum.at_time(us_from_seconds(t));
        for (int x = 0; x < points; ++x)
            for (int y = 0; y < points; ++y) // summing over y keeps ky = 0
                eta[t][x] += moment.at(200.0 * x / points, 200.0 * y / points).height / points;
    }
    const Dispersion d = state.dispersion();
    for (int nx = 2; nx <= 9; ++nx) {
        std::vector<double> power(n);
        for (int bin = 0; bin < n; ++bin) {
            std::complex<double> a;
            for (int t = 0; t < n; ++t)
                for (int x = 0; x < points; ++x)
                    a += eta[t][x] *
                         std::polar(1.0, -two_pi * (double(nx * x) / points - double(bin * t) / n));
            power[bin] = std::norm(a);
        }
        const int expected =
            static_cast<int>(std::lround(d.omega(two_pi / 200.0 * nx) * 64.0 / two_pi));
        const double total = std::accumulate(power.begin(), power.end(), 0.0);
        EXPECT_GT((power[expected] + power[n - expected]) / total, 0.999) << nx;
    }
}

TEST(Identity, I16_mean_level_drops_by_the_sum_of_k_psi_where_crests_are_sharp) {
    std::vector<double> levels, jacobians;
    double predicted = 0.0;
    for (std::uint64_t seed = 0; seed < 30; ++seed) {
        const auto sea = realized(windy_sea(seed), one_tile);
        const auto points = nodes(sea, 200.0, 32, 0);
        jacobians.push_back(mean(points, [](auto& p) { return jacobian(p, {}); }));
        levels.push_back(mean(points, [](auto& p) { return p.height * jacobian(p, {}); }));
        for (const Wave& w : waves(sea->cascades[0], 0))
            predicted -= w.k * std::norm(w.h) / 30.0;
    }
    double level = 0.0, spread = 0.0;
    for (const double l : levels)
        level += l / 30.0;
    for (const double l : levels)
        spread += (l - level) * (l - level) / 29.0;
    // The first-order part is exact in each seed (I17); the rest averages out.
    EXPECT_NEAR(level, predicted, 3.0 * std::sqrt(spread / 30.0));
    for (const double j : jacobians)
        EXPECT_NEAR(j, 1.0, 1e-12); // a periodic map covers its tile once
}

/// Long-crested: independent waves along x alone.
RealizationPtr long_crested(std::uint64_t seed, double mss_target) {
    auto sea = std::make_shared<Realization>();
    CascadeModes modes;
    modes.spec = {100.0, 128};
    modes.band = {0.01, 10.0};
    modes.h0.resize(128 * 128);
    modes.rate.resize(128 * 128);
    const double step = modes.spec.wavenumber_step_radpm();
    for (int nx = 1; nx < 60; ++nx) {
        const GaussianPair xi = gaussian_pair({seed, 9, 1, nx, 0});
        // Equal slope variance in each wave: E[2 |h0|^2 k^2] = mss / 59.
        const double amplitude = std::sqrt(mss_target / 59.0) / (2.0 * step * nx);
        modes.h0[static_cast<std::size_t>(nx)] = {amplitude * xi.real, amplitude * xi.imaginary};
    }
    sea->cascades.push_back(std::move(modes));
    return sea;
}

TEST(Identity, I18_folded_share_and_foam_cover_of_a_long_crested_sea_are_normal_tails) {
    const double mss = 0.2; // steep on purpose: folds are common
    for (const double threshold : {0.0, 0.45}) {
        std::vector<double> shares;
        for (std::uint64_t seed = 0; seed < 150; ++seed) {
            const DirectSum sum(long_crested(seed, mss));
            const auto moment = sum.at_time(0);
            int below = 0;
            for (int i = 0; i < 256; ++i)
                below += jacobian(moment.at(100.0 * i / 256, 0.0), {}) < threshold;
            shares.push_back(below / 256.0);
        }
        double share = 0.0, spread = 0.0;
        for (const double s : shares)
            share += s / 150.0;
        for (const double s : shares)
            spread += (s - share) * (s - share) / 149.0;
        const double expected = 0.5 * std::erfc((1.0 - threshold) / std::sqrt(2.0 * mss));
        EXPECT_NEAR(share, expected, 3.0 * std::sqrt(spread / 150.0)) << threshold;
    }
}

TEST(Identity, I19_jacobian_of_a_directional_sea_has_variance_mss) {
    double variance = 0.0, mss = 0.0;
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
        const auto sea = realized(windy_sea(seed), one_tile);
        const auto points = nodes(sea, 200.0, 32, 0);
        variance += mean(points, [](auto& p) { return std::pow(jacobian(p, {}) - 1.0, 2); });
        mss += wave_sum(waves(sea->cascades[0], 0),
                        [](const Wave& w) { return w.k * w.k * std::norm(w.h); });
    }
    ASSERT_LT(mss / 10.0, 0.02);
    EXPECT_NEAR(variance / mss, 1.0, 0.1); // second order in mss
}

TEST(Identity, I21_cascades_are_independent) {
    double cross = 0.0, a2 = 0.0, b2 = 0.0;
    std::vector<double> products;
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        const auto sea = realized(windy_sea(seed), {{200.0, 32}, {60.0, 32}});
        auto split = [&](std::size_t c) {
            auto part = std::make_shared<Realization>(*sea);
            part->cascades = {sea->cascades[c]};
            return DirectSum(part).at(0, 0, 0).height;
        };
        const double a = split(0), b = split(1);
        cross += a * b;
        a2 += a * a;
        b2 += b * b;
    }
    EXPECT_LT(std::abs(cross / std::sqrt(a2 * b2)), 3.0 / std::sqrt(200.0));
}

TEST(Identity, I23_a_query_does_not_depend_on_the_grid_size) {
    SeaState state = windy_sea();
    state.wavenumber_max_radpm = 0.35; // the same cut for all, below the smallest grid's own
    double first = 0.0;
    for (const int size : {64, 128, 256}) {
        const auto sea = realized(state, {{300.0, size}});
        const double height = DirectSum(sea).at(17.0, -3.0, us_from_seconds(1e5)).height;
        if (size == 64)
            first = height;
        EXPECT_NEAR(height, first, 1e-9);
    }
}

TEST(Identity, I29_a_handful_of_waves_against_long_double_at_the_ends_of_space_and_time) {
    auto sea = std::make_shared<Realization>(*one_wave(512.0, 64, 3, 1, 0.8, 0.1));
    for (const auto& [nx, ny, a] : {std::tuple{7, -5, 0.5}, {-2, 9, 0.3}, {0, 12, 0.2}}) {
        const auto more = one_wave(512.0, 64, nx, ny, a, 0.7);
        for (std::size_t i = 0; i < more->cascades[0].h0.size(); ++i) {
            sea->cascades[0].h0[i] += more->cascades[0].h0[i];
            sea->cascades[0].rate[i] |= more->cascades[0].rate[i];
        }
    }
    const DirectSum sum(sea);
    const long double tau = 2.0L * 3.14159265358979323846264L;
    for (const double x : {0.0, 1e7, -1e7})
        for (const double t : {0.0, 12.34, 1e6, 1e9}) {
            long double eta = 0.0L, dx = 0.0L, slope = 0.0L;
            for (const auto& [nx, ny, a, ph] : {std::tuple{3, 1, 0.8L, 0.1L},
                                                {7, -5, 0.5L, 0.7L},
                                                {-2, 9, 0.3L, 0.7L},
                                                {0, 12, 0.2L, 0.7L}}) {
                const auto i = static_cast<std::size_t>((ny + 64) % 64 * 64 + (nx + 64) % 64);
                const auto rate = static_cast<long double>(sea->cascades[0].rate[i]);
                const long double turns =
                    std::remainder(rate / 0x1p64L * (static_cast<long double>(t) * 1e6L), 1.0L);
                const long double phase =
                    tau * ((nx * static_cast<long double>(x) + ny * 31.5L) / 512.0L - turns) + ph;
                eta += a * std::cos(phase);
                dx -= a * nx / std::hypot(static_cast<long double>(nx), ny) * std::sin(phase);
                slope -= a * tau / 512.0L * nx * std::sin(phase);
            }
            const LagrangianPoint p = sum.at(x, 31.5, us_from_seconds(t));
            // 64 bits of long double hold the turns of 1e9 s to 1e-9; the bound is the document's.
            EXPECT_NEAR(p.height, static_cast<double>(eta), 2e-5);
            EXPECT_NEAR(p.displacement_x, static_cast<double>(dx), 2e-5);
            EXPECT_NEAR(p.slope_x, static_cast<double>(slope), 2e-5);
        }
}

TEST(Identity, I30_the_envelope_of_a_beat_moves_at_the_group_speed) {
    auto sea = std::make_shared<Realization>(*one_wave(2000.0, 128, 40, 0, 1.0));
    const auto second = one_wave(2000.0, 128, 42, 0, 1.0);
    for (std::size_t i = 0; i < second->cascades[0].h0.size(); ++i) {
        sea->cascades[0].h0[i] += second->cascades[0].h0[i];
        sea->cascades[0].rate[i] |= second->cascades[0].rate[i];
    }
    const DirectSum sum(sea);
    const double group = Dispersion{}.group_speed(two_pi / 2000.0 * 41.0);
    const auto peak_near = [&](double guess, TimeUs t) {
        const auto moment = sum.at_time(t);
        double best = 0.0, where = 0.0;
        for (double x = guess - 100.0; x < guess + 100.0; x += 0.05) {
            const LagrangianPoint p = moment.at(x, 0.0);
            const double envelope = p.height * p.height + p.displacement_x * p.displacement_x;
            if (envelope > best) {
                best = envelope;
                where = x;
            }
        }
        return where;
    };
    const double seconds = 100.0;
    const double moved = peak_near(group * seconds, us_from_seconds(seconds)) - peak_near(0.0, 0);
    EXPECT_NEAR(moved / (group * seconds), 1.0, 0.01);
}

} // namespace
} // namespace seaway::sea
