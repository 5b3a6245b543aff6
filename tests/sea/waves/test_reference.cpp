// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <iterator>
#include <limits>
#include <numbers>
#include <random>
#include <tuple>
#include <utility>
#include <vector>

#include "sea/basics/field.h"
#include "sea/waves/reference.h"
#include "sea/waves/wave_sums.h"
#include "tests/sea/csv.h"
#include "tests/sea/sea_fixture.h"
#include "tests/support/explicit_sea.h"

namespace seaway::sea {
namespace {

using testing::one_wave;
using testing::windy_sea;

using Real = long double;

/// Plain sum over the whole plane in long double, written once more from the definition.
class Definition {
  public:
    Definition(const Realization& sea, double x_m, double y_m, TimeUs t) {
        for (const CascadeModes& modes : sea.cascades)
            for (int iy = 0; iy < modes.spec.size; ++iy)
                for (int ix = 0; ix < modes.spec.size; ++ix)
                    add(modes, ix, iy, x_m, y_m, t);
    }
    Real value(Field field) const { return sums_[static_cast<std::size_t>(field)].value; }
    /// Of what is summed: the field's own amplitudes.
    Real amplitudes(Field field) const { return sums_[static_cast<std::size_t>(field)].amplitudes; }

  private:
    using Complex = std::complex<Real>;

    void add(const CascadeModes& modes, int ix, int iy, double x_m, double y_m, TimeUs t) {
        const int size = modes.spec.size;
        const auto i = static_cast<std::size_t>(iy * size + ix);
        const auto mirror =
            static_cast<std::size_t>((size - iy) % size * size + (size - ix) % size);
        if (modes.h0[i] == 0.0 && modes.h0[mirror] == 0.0)
            return;
        constexpr Real turn = 2 * std::numbers::pi_v<Real>;
        const auto length = static_cast<Real>(modes.spec.length_m);
        const int nx = signed_index(ix, size), ny = signed_index(iy, size);
        const Real kx = turn * nx / length, ky = turn * ny / length;
        const Real k = std::hypot(kx, ky);
        const Real d = k * std::tanh(k * modes.depth_m); // D = i k/|k| coth(kd) h
        const Real omega = omega_from_rate(modes.rate[i]);
        const Real place = nx * (std::fmod(Real(x_m), length) / length) +
                           ny * (std::fmod(Real(y_m), length) / length);
        const Real time = static_cast<Real>(phase_turns(modes.rate[i], t)) * 0x1p-64L;
        const Complex forward = Complex(modes.h0[i]) * std::polar(Real(1), -turn * time);
        const Complex backward =
            std::conj(Complex(modes.h0[mirror]) * std::polar(Real(1), -turn * time));
        const Complex there = std::polar(Real(1), turn * (place - std::floor(place)));
        const Complex i1(0, 1);
        const Complex h = (forward + backward) * there;
        const Complex r = i1 * omega * (backward - forward) * there;
        const Real amplitude = std::abs(forward) + std::abs(backward);
        add(Field::height, 1, h, amplitude);
        add(Field::displacement_x, i1 * kx / d, h, amplitude);
        add(Field::displacement_y, i1 * ky / d, h, amplitude);
        add(Field::height_rate, 1, r, omega * amplitude);
        add(Field::displacement_x_rate, i1 * kx / d, r, omega * amplitude);
        add(Field::displacement_y_rate, i1 * ky / d, r, omega * amplitude);
        add(Field::slope_x, i1 * kx, h, amplitude);
        add(Field::slope_y, i1 * ky, h, amplitude);
        add(Field::strain_xx, -kx * kx / d, h, amplitude);
        add(Field::strain_yy, -ky * ky / d, h, amplitude);
        add(Field::strain_xy, -kx * ky / d, h, amplitude);
    }
    void add(Field field, Complex factor, Complex wave, Real amplitude) {
        Sum& sum = sums_[static_cast<std::size_t>(field)];
        sum.value += (factor * wave).real();
        sum.amplitudes += std::abs(factor) * amplitude;
    }

    struct Sum {
        Real value = 0, amplitudes = 0;
    };
    std::array<Sum, field_table.size()> sums_;
};

/// The error that sea/waves/reference.h states.
constexpr Real stated_error = 1e-13L;

void expect_the_definition(const DirectSum& sum, double x_m, double y_m, TimeUs t) {
    const LagrangianPoint point = sum.at(x_m, y_m, t);
    const Definition exact(sum.sea(), x_m, y_m, sum.sea().phase_time(t));
    for (const Field field : linear_fields)
        EXPECT_LE(std::abs(value_of(point, field) - exact.value(field)),
                  stated_error * exact.amplitudes(field))
            << info(field).name << " at " << x_m << ", " << y_m << " m, " << t << " us";
}

TEST(Reference, equals_the_definition_term_by_term) {
    const DirectSum sum(testing::realized(windy_sea(), testing::three_cascades));
    for (const TimeUs t : {TimeUs{0}, us_from_seconds(12.34), us_from_seconds(-5.0)})
        for (const double x : {0.0, 13.7, -250.3, 9'999'999.7})
            expect_the_definition(sum, x, 2.0 * x + 1.0, t);
}

// Naive (trap T34): a loop rounds frequencies, and slopes and displacements of wavenumbers that are derived from these anew are of
// other waves than the heights.
TEST(Reference, wavenumbers_stay_on_the_lattice_where_a_loop_rounds_frequencies) {
    SeaState looping = windy_sea();
    looping.loop_period_s = 60;
    const DirectSum sum(testing::realized(looping, testing::three_cascades));
    for (const TimeUs t : {TimeUs{0}, us_from_seconds(12.34), us_from_seconds(6e9)})
        for (const double x : {0.0, 13.7, -250.3})
            expect_the_definition(sum, x, 2.0 * x + 1.0, t);
}

// Sums run over eight neighbours at a time, from west and east together: waves at the ends of eights, with
// gaps between them, alone on their side, on the axes.
TEST(Reference, finds_every_wave_of_a_sea_of_few) {
    CascadeModes few = tests::calm_cascade(200.0, 64);
    few.depth_m = 12.0;
    double phase = 0.0;
    for (const auto& [nx, ny] : std::initializer_list<std::pair<int, int>>{{7, 0},
                                                                           {8, 0},
                                                                           {-5, 0},
                                                                           {31, 0},
                                                                           {0, 3},
                                                                           {0, -9},
                                                                           {1, 7},
                                                                           {-8, 7},
                                                                           {15, 7},
                                                                           {-31, 7},
                                                                           {31, 8},
                                                                           {-16, 8},
                                                                           {3, -31},
                                                                           {-3, -31},
                                                                           {24, 31},
                                                                           {-24, 31},
                                                                           {-23, 16},
                                                                           {8, 16}}) {
        const RealizationPtr alone = one_wave(200.0, 64, nx, ny, 0.3, phase, few.depth_m);
        expect_the_definition(DirectSum(alone), 17.3, -4.1, 3'000'000);
        tests::add_wave(few, nx, ny, 0.3, phase += 1.0);
    }
    const DirectSum sum(tests::make_sea({few}));
    for (const double x : {0.0, 31.4, -77.7})
        expect_the_definition(sum, x, 50.1 - x, 3'000'000);
}

// The phase of wave 511 is 511 times that of the first one: rounded before it is multiplied, or while it is,
// it is wrong by some 2e-13. A tile of 1.3 m is seven million of them away from a place that is far off.
TEST(Reference, the_shortest_waves_of_a_large_tile_are_as_exact_as_the_longest) {
    for (const auto& [length_m, nx, ny] :
         {std::tuple{1021.7, 511, 0}, {1021.7, -509, 487}, {1021.7, 503, -511}, {1.3, 511, -511}}) {
        const DirectSum sum(one_wave(length_m, 1024, nx, ny, 1.0));
        for (const double x : {3.3, -401.9, 333.3, 509.1, 12345.6, -9'876'543.2, 1.2e13})
            expect_the_definition(sum, x, 0.7 * x + 11.1, 1'000'000);
    }
}

// The error of a sine or a cosine that sea/waves/wave_sums.h states.
constexpr Real stated_turn_error = 4e-16L;
constexpr Real rad_per_turn = 2 * std::numbers::pi_v<Real>;

/// 0.64 fixed point: 64 bits are what a long double holds.
Real rad_of(std::uint64_t turns) {
    return rad_per_turn * static_cast<Real>(static_cast<std::int64_t>(turns)) * 0x1p-64L;
}

// On both sides of every eighth of a turn, where quarters and signs change, and at phases that are drawn.
TEST(Reference, sines_and_cosines_are_as_exact_as_stated_at_any_phase) {
    std::vector<std::uint64_t> phases;
    for (std::uint64_t eighth = 0; eighth < 8; ++eighth)
        for (int bit = 0; bit < 61; ++bit)
            for (const std::uint64_t side : {std::uint64_t{1}, ~std::uint64_t{0}})
                phases.push_back((eighth << 61) + (side << bit));
    std::mt19937_64 random(1);
    std::generate_n(std::back_inserter(phases), 2000, std::ref(random));
    for (const Instructions instructions : supported_instructions())
        for (const std::uint64_t phase : phases) {
            std::array<Turns, 2> turns{};
            wave_sums(instructions).turns(phase, turns.size(), turns.data());
            for (std::size_t n = 0; n < turns.size() * sum_lanes; ++n) {
                const Turns& eight = turns[n / sum_lanes];
                const Real rad = rad_of(n * phase);
                ASSERT_LE(std::abs(eight.cos.at[n % sum_lanes] - std::cos(rad)), stated_turn_error)
                    << phase;
                ASSERT_LE(std::abs(eight.sin.at[n % sum_lanes] - std::sin(rad)), stated_turn_error)
                    << phase;
            }
        }
}

// What a place is rounded by is in it: wave 1023 of the largest grid, at 1024ths of a metre on a tile of 3 m,
// where whole numbers say which part of its length is left. Its height is a cosine, without another rounding.
TEST(Reference, the_shortest_wave_of_the_largest_tile_is_as_exact_as_stated) {
    const RealizationPtr sea = one_wave(3.0, 2048, 1023, 0, 1.0);
    for (const Instructions instructions : supported_instructions()) {
        const DirectSum sum(sea, instructions);
        const DirectSum::Moment moment = sum.at_time(0);
        for (int i = -5000; i <= 5000; i += 3) {
            const Real rad = rad_per_turn * static_cast<Real>(1023 * i % 3072) / 3072;
            ASSERT_LE(std::abs(moment.at(i / 1024.0, 0.0).height - std::cos(rad)),
                      stated_turn_error)
                << i;
        }
    }
}

// The rate of change is rounded once more, when it is multiplied by the frequency.
TEST(Reference, a_wave_is_where_it_must_be_at_both_ends_of_time) {
    const RealizationPtr sea = one_wave(100.0, 64, 2, 0, 1.0);
    const Rate rate = sea->cascades[0].rate[2];
    const Real omega = omega_from_rate(rate);
    using Limits = std::numeric_limits<TimeUs>;
    for (const Instructions instructions : supported_instructions()) {
        const DirectSum sum(sea, instructions);
        for (const TimeUs t : {Limits::min(), Limits::min() + 1, -time_us_max, TimeUs{-1},
                               TimeUs{1}, time_us_max, Limits::max() - 1, Limits::max()}) {
            const LagrangianPoint p = sum.at(0.0, 0.0, t);
            const Real rad = rad_of(phase_turns(rate, t));
            EXPECT_LE(std::abs(p.height - std::cos(rad)), stated_turn_error) << t;
            EXPECT_LE(std::abs(p.height_rate + omega * std::sin(rad)),
                      omega * (stated_turn_error + std::numeric_limits<double>::epsilon()))
                << t;
        }
    }
}

TEST(Reference, a_place_that_is_no_number_has_no_height) {
    const DirectSum sum(one_wave(100.0, 64, 3, 4, 1.0));
    for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL})
        for (const LagrangianPoint& p : {sum.at(bad, 0.0, 0), sum.at(0.0, bad, 0)})
            for (const Field field : linear_fields)
                EXPECT_TRUE(std::isnan(value_of(p, field))) << info(field).name;
}

TEST(Reference, is_the_same_bits_with_every_instruction_set) {
    const auto sea = testing::realized(windy_sea(), testing::three_cascades);
    const DirectSum portable(sea, Instructions::portable);
    const DirectSum::Moment expected = portable.at_time(-5'000'000'000'001);
    const SheetPatch expected_patch = expected.patch(1, -3.0, 9.0, 11.0, 19.0);
    for (const Instructions instructions : supported_instructions()) {
        SCOPED_TRACE(name(instructions));
        const DirectSum sum(sea, instructions);
        const DirectSum::Moment moment = sum.at_time(-5'000'000'000'001);
        for (const double x : {0.0, 13.7, -250.3}) {
            const LagrangianPoint a = moment.at(x, 7.7), b = expected.at(x, 7.7);
            for (const Field field : linear_fields)
                EXPECT_EQ(value_of(a, field), value_of(b, field)) << info(field).name;
        }
        const SheetPatch patch = moment.patch(1, -3.0, 9.0, 11.0, 19.0);
        EXPECT_EQ(patch.moved, expected_patch.moved);
        EXPECT_EQ(patch.height, expected_patch.height);
    }
}

// A field that nobody sums would be zero in every reference made from it.
TEST(Reference, fills_every_linear_field_of_the_table) {
    const LagrangianPoint p =
        DirectSum(testing::realized(windy_sea(), testing::three_cascades)).at(3.0, 4.0, 5'000'000);
    for (const Field field : linear_fields)
        EXPECT_NE(value_of(p, field), 0.0) << info(field).name;
}

// T28: with exp(+i w t) on h0 the sea runs upwind.
TEST(Reference, T28_a_one_mode_sea_travels_along_plus_k) {
    const DirectSum sum(one_wave(100.0, 64, 3, 4, 1.0));
    const double k = two_pi / 100.0 * 5.0;
    const double speed = omega_from_rate(sum.sea().cascades[0].rate[4 * 64 + 3]) / k;
    for (const double t : {0.0, 0.4, 0.8, 1.2}) {
        // The crest that was at the origin is c t further along (0.6, 0.8).
        const LagrangianPoint p = sum.at(0.6 * speed * t, 0.8 * speed * t, us_from_seconds(t));
        EXPECT_NEAR(p.height, 1.0, 1e-9); // time is whole microseconds
        EXPECT_NEAR(p.height_rate, 0.0, 1e-5);
    }
}

// I15, T27, D5: displacement -i k/|k| h would flatten crests.
TEST(Reference, T27_D08_displacement_sharpens_crests_into_a_trochoid) {
    const testing::Table table("D08_trochoid_harmonics");
    for (std::size_t r = 0; r < table.size(); ++r) {
        const double steepness = table.number(r, "lambda_k_a");
        const double k = two_pi / 10.0;
        const double a = steepness / k;
        const DirectSum sum(one_wave(10.0, 16, 1, 0, a));
        const auto moment = sum.at_time(0);
        EXPECT_NEAR(1.0 + moment.at(0, 0).strain_xx, table.number(r, "J_crest"), 1e-9);
        EXPECT_NEAR(1.0 + moment.at(5, 0).strain_xx, table.number(r, "J_trough"), 1e-9);
        // Harmonics of the Eulerian profile: integrals over the label X, dx = J dX.
        double mean = 0, b[5] = {};
        const int n = 4096;
        for (int i = 0; i < n; ++i) {
            const LagrangianPoint p = moment.at(10.0 * i / n, 0.0);
            const double x = 10.0 * i / n + p.displacement_x;
            const double weight = (1.0 + p.strain_xx) / n;
            mean += p.height * weight;
            for (int m = 1; m <= 4; ++m)
                b[m] += 2.0 * p.height * std::cos(m * k * x) * weight;
        }
        EXPECT_NEAR(mean / a, table.number(r, "mean/a"), 1e-9);
        for (int m = 1; m <= 4; ++m)
            EXPECT_NEAR(b[m] / a, table.number(r, "b" + std::to_string(m) + "/a"), 1e-9);
    }
}

TEST(Reference, rates_slopes_and_strains_are_derivatives) {
    const auto sea = testing::realized(windy_sea(), testing::three_cascades);
    const DirectSum sum(sea);
    const TimeUs t = us_from_seconds(100.0);
    const double h = 1e-3;
    const LagrangianPoint p = sum.at(5, 7, t);
    const LagrangianPoint later = sum.at(5, 7, t + 1000), earlier = sum.at(5, 7, t - 1000);
    const LagrangianPoint east = sum.at(5 + h, 7, t), west = sum.at(5 - h, 7, t);
    const LagrangianPoint north = sum.at(5, 7 + h, t), south = sum.at(5, 7 - h, t);
    const double tolerance = 1e-5; // h^2/6 times third derivatives of order 10, rounding 1e-11/h
    EXPECT_NEAR((later.height - earlier.height) / 2e-3, p.height_rate, tolerance);
    EXPECT_NEAR((later.displacement_x - earlier.displacement_x) / 2e-3, p.displacement_x_rate,
                tolerance);
    EXPECT_NEAR((later.displacement_y - earlier.displacement_y) / 2e-3, p.displacement_y_rate,
                tolerance);
    EXPECT_NEAR((east.height - west.height) / (2 * h), p.slope_x, tolerance);
    EXPECT_NEAR((north.height - south.height) / (2 * h), p.slope_y, tolerance);
    EXPECT_NEAR((east.displacement_x - west.displacement_x) / (2 * h), p.strain_xx, tolerance);
    EXPECT_NEAR((north.displacement_y - south.displacement_y) / (2 * h), p.strain_yy, tolerance);
    EXPECT_NEAR((north.displacement_x - south.displacement_x) / (2 * h), p.strain_xy, tolerance);
    EXPECT_NEAR((east.displacement_y - west.displacement_y) / (2 * h), p.strain_xy, tolerance);
}

// G1, T39: in float, or with k x multiplied out, the sea turns into steps far from the origin.
TEST(Reference, I29_far_away_and_long_after_a_wave_is_where_it_must_be) {
    const double length = 512.0; // a power of two: n * length is exact
    const DirectSum sum(one_wave(length, 64, 7, -5, 1.5, 0.3));
    const TimeUs t = us_from_seconds(1e9);
    for (const double turns : {0.0, 1.0, -1.0, 19531.0, -19531.0}) // 1e7 m
        EXPECT_NEAR(sum.at(100.25 + turns * length, -30.5 - turns * length, t).height,
                    sum.at(100.25, -30.5, t).height, 1e-12);
    // Against the stored frequency in long double: phase reduced in exact integers.
    const Rate rate = sum.sea().cascades[0].rate[(64 - 5) * 64 + 7];
    const long double turns = static_cast<long double>(rate) * 1e15L / 0x1p64L;
    const long double phase =
        2.0L * 3.14159265358979323846L *
        (7.0L * 100.25L / 512.0L + 5.0L * 30.5L / 512.0L - std::remainder(turns, 1.0L));
    EXPECT_NEAR(sum.at(100.25, -30.5, t).height, 1.5 * std::cos(double(phase) + 0.3), 2e-5);
}

TEST(Reference, B2_time_runs_backward_as_well) {
    const DirectSum sum(one_wave(100.0, 64, 2, 0, 1.0));
    const double omega = omega_from_rate(sum.sea().cascades[0].rate[2]);
    for (const double t : {-5.0, -1e6})
        EXPECT_NEAR(sum.at(0, 0, us_from_seconds(t)).height, std::cos(omega * t),
                    std::abs(t) * 1e-12 + 1e-12); // omega * t in double
}

} // namespace
} // namespace seaway::sea
