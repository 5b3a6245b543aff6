// SPDX-License-Identifier: Apache-2.0
// seaway-inspect --eval against sums that this file computes for itself in long double.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <sstream>

#include <fmt/format.h>

#include "sea/scene/scene.h"
#include "sea/surface/answer.h"
#include "tests/support/airy_waves.h"
#include "tests/support/program.h"

namespace seaway {
namespace {

using Real = long double;
using Complex = std::complex<Real>;
using tests::folder;
using tests::Output;
using tests::run_program;

constexpr Real turn_rad = 2.0L * std::numbers::pi_v<Real>;

const char* const two_swells = R"([sea]
seed = 7
depth_m = 40
[[sea.system]]
type = "swell"
significant_height_m = 2.5
peak_period_s = 11
from_deg = 250
spreading_exponent = 60
[[sea.system]]
type = "swell"
significant_height_m = 0.8
peak_period_s = 6
from_deg = 30
spreading_exponent = 200
[[cascade]]
length_m = 1024
size = 64
[[cascade]]
length_m = 191
size = 32
)";

struct Row {
    std::array<double, 11> numbers; ///< x y t height nx ny nz vx vy vz error
    unsigned flags;
};

std::vector<Row> evaluate(const std::string& scene, const std::string& points) {
    const Output output = run_program("seaway-inspect", scene + " --eval -", points);
    EXPECT_EQ(output.status, 0) << output.err;
    std::istringstream lines(output.out);
    std::string line;
    std::getline(lines, line);
    EXPECT_EQ(line, "x_m,y_m,t_s,height_m,normal_x,normal_y,normal_z,velocity_x_mps,"
                    "velocity_y_mps,velocity_z_mps,error_m,flags");
    std::vector<Row> rows;
    while (std::getline(lines, line)) {
        Row& row = rows.emplace_back();
        const char* at = line.c_str();
        for (double& number : row.numbers) {
            char* end = nullptr;
            number = std::strtod(at, &end);
            at = end + 1;
        }
        row.flags = static_cast<unsigned>(std::strtoul(at, nullptr, 10));
    }
    return rows;
}

/// The sea straight from the formulas of docs/conventions.md: every k by itself, no symmetry used.
class LongSum {
  public:
    enum class Frequencies { stored, from_dispersion };

    LongSum(const sea::Scene& scene, Frequencies frequencies)
        : scene_(scene), sea_(*realize(scene)), frequencies_(frequencies) {}

    struct Point {
        Real eta, dx, dy, eta_t, dx_t, dy_t, eta_x, eta_y, dxx, dyy, dxy;
    };

    Point at(Real x, Real y, std::int64_t time_us) const {
        Point p{};
        for (const sea::CascadeModes& tile : sea_.cascades) {
            const Real length = tile.spec.length_m;
            const int n = tile.spec.size;
            for (int i = 0; i < n * n; ++i) {
                const Complex h0(tile.h0[static_cast<std::size_t>(i)]);
                if (h0 == Complex())
                    continue;
                const int nx = sea::signed_index(i % n, n);
                const int ny = sea::signed_index(i / n, n);
                const Real kx = turn_rad * nx / length;
                const Real ky = turn_rad * ny / length;
                const Real k = std::hypot(kx, ky);
                // Water moves coth(kd) times as far sideways.
                const Real d = k * std::tanh(k * static_cast<Real>(scene_.sea.depth_m));
                // eta = 2 Re h0 exp(i (k.x - w t)): h0(k) and the conjugate that h(-k) carries.
                const Real turns = nx * std::fmod(x, length) / length +
                                   ny * std::fmod(y, length) / length -
                                   turns_in_time(tile, i, k, time_us);
                const Complex e =
                    2.0L * h0 * std::polar(1.0L, turn_rad * std::remainder(turns, 1.0L));
                const Complex rate = Complex(0, -omega(tile, i, k)) * e;
                const Complex i_unit(0, 1);
                p.eta += e.real();
                p.dx += (i_unit * kx / d * e).real();
                p.dy += (i_unit * ky / d * e).real();
                p.eta_t += rate.real();
                p.dx_t += (i_unit * kx / d * rate).real();
                p.dy_t += (i_unit * ky / d * rate).real();
                p.eta_x += (i_unit * kx * e).real();
                p.eta_y += (i_unit * ky * e).real();
                p.dxx -= (kx * kx / d * e).real();
                p.dyy -= (ky * ky / d * e).real();
                p.dxy -= (kx * ky / d * e).real();
            }
        }
        return p;
    }

    /// The surface above (x, y) by fixed-point iteration; these seas are too gentle to fold.
    Point above(double x, double y, std::int64_t time_us) const {
        Real offset_x = 0, offset_y = 0;
        Point p{};
        for (int step = 0; step < 100; ++step) {
            p = at(x - offset_x, y - offset_y, time_us);
            const Real change = std::hypot(p.dx - offset_x, p.dy - offset_y);
            offset_x = p.dx;
            offset_y = p.dy;
            if (change < 1e-15L)
                break;
        }
        return at(x - offset_x, y - offset_y, time_us);
    }

  private:
    Real omega(const sea::CascadeModes& tile, int i, Real k) const {
        if (frequencies_ == Frequencies::stored)
            return static_cast<Real>(tile.rate[static_cast<std::size_t>(i)]) * 0x1p-64L * turn_rad *
                   1e6L;
        const Real g = scene_.sea.gravity_mps2;
        return std::sqrt((g * k + 7.4e-5L * k * k * k) *
                         std::tanh(k * static_cast<Real>(scene_.sea.depth_m)));
    }
    Real turns_in_time(const sea::CascadeModes& tile, int i, Real k, std::int64_t time_us) const {
        if (frequencies_ == Frequencies::from_dispersion)
            return omega(tile, i, k) * static_cast<Real>(time_us) / 1e6L / turn_rad;
        // Whole turns drop out of the product modulo 2^64.
        const std::uint64_t product =
            tile.rate[static_cast<std::size_t>(i)] * static_cast<std::uint64_t>(time_us);
        return static_cast<Real>(product) * 0x1p-64L;
    }

    const sea::Scene& scene_;
    sea::Realization sea_;
    Frequencies frequencies_;
};

struct Place {
    double x_m, y_m, t_s;
};

std::string csv_of(const std::vector<Place>& places) {
    std::string text;
    for (const Place& p : places)
        text += fmt::format("{:.17g},{:.17g},{:.17g}\n", p.x_m, p.y_m, p.t_s);
    return text;
}

TEST(InspectPoints, far_out_and_late_rows_equal_a_long_double_sum_of_the_stored_waves) {
    const std::string path = folder().write("two_swells.toml", two_swells);
    const Result<sea::Scene> scene = sea::read_scene(path);
    ASSERT_TRUE(scene);
    const LongSum truth(*scene, LongSum::Frequencies::stored);
    const std::vector<Place> places{
        {0, 0, 0},         {1e6, -1e6, 0},          {-1e6, 1e6, 1e9},
        {1e6, 12.5, -1e9}, {-999999.75, 3.25, 1e6}, {17.0, -4.5, 12.34}};
    const std::vector<Row> rows = evaluate(path, csv_of(places));
    ASSERT_EQ(rows.size(), places.size());
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const auto& n = rows[i].numbers;
        const LongSum::Point p =
            truth.above(places[i].x_m, places[i].y_m, std::llround(places[i].t_s * 1e6));
        // Position is solved to 1e-9 m, slopes are below 0.3; sums in double round to 1e-12 m.
        EXPECT_NEAR(n[3], static_cast<double>(p.eta), 1e-9) << "row " << i;
        EXPECT_LE(std::abs(n[3] - static_cast<double>(p.eta)), n[10]) << "stated error, row " << i;
        EXPECT_LT(n[10], 1e-8);
        EXPECT_NEAR(n[7], static_cast<double>(p.dx_t), 1e-9);
        EXPECT_NEAR(n[8], static_cast<double>(p.dy_t), 1e-9);
        EXPECT_NEAR(n[9], static_cast<double>(p.eta_t), 1e-9);
        const Real normal[3] = {p.dxy * p.eta_y - (1 + p.dyy) * p.eta_x,
                                p.dxy * p.eta_x - (1 + p.dxx) * p.eta_y,
                                (1 + p.dxx) * (1 + p.dyy) - p.dxy * p.dxy};
        const Real length = std::hypot(normal[0], normal[1], normal[2]);
        for (std::size_t axis = 0; axis < 3; ++axis)
            EXPECT_NEAR(n[4 + axis], static_cast<double>(normal[axis] / length), 1e-9);
        EXPECT_EQ(rows[i].flags, sea::answer_exact);
    }
}

TEST(InspectPoints, frequencies_are_those_of_the_dispersion_relation) {
    const std::string path = folder().write("two_swells.toml", two_swells);
    const Result<sea::Scene> scene = sea::read_scene(path);
    ASSERT_TRUE(scene);
    const LongSum truth(*scene, LongSum::Frequencies::from_dispersion);
    const std::vector<Row> rows = evaluate(path, "3,4,1e6\n-250,1e5,-1e6\n3,4,1e9\n");
    ASSERT_EQ(rows.size(), 3u);
    for (const Row& row : rows) {
        const auto& n = row.numbers;
        const LongSum::Point p = truth.above(n[0], n[1], std::llround(n[2] * 1e6));
        // A frequency is stored in steps of 2^-64 turns/us: phases are off by up to 1.7e-7 rad
        // after 1e6 s and 1.7e-4 rad after 1e9 s; all waves together are below 40 m.
        const double phase_error = std::abs(n[2]) * 1.8e-13;
        EXPECT_NEAR(n[3], static_cast<double>(p.eta), 40.0 * phase_error) << n[2];
    }
}

TEST(InspectPoints, explicit_waves_are_the_cosines_that_their_file_names) {
    folder().write("three.csv", "nx,ny,amplitude_m,phase_rad\n3,1,0.5,0.25\n-2,4,0.25,-1.5\n"
                                "0,10,0.125,3\n");
    const std::string path = folder().write(
        "three.toml", "[sea]\nchoppiness = 0\ndepth_m = 20\n[[sea.system]]\ntype = \"modes\"\n"
                      "length_m = 512\nfile = \"three.csv\"\n[[cascade]]\nlength_m = 512\n"
                      "size = 64\n");
    const std::vector<Row> rows =
        evaluate(path, "0,0,0\n1e6,-1e6,1e6\n-123456.75,7,-1e6\n31,1e6,1e9\n");
    ASSERT_EQ(rows.size(), 4u);
    const std::array<std::array<Real, 4>, 3> waves{
        {{3, 1, 0.5L, 0.25L}, {-2, 4, 0.25L, -1.5L}, {0, 10, 0.125L, 3}}};
    for (const Row& row : rows) {
        const auto& n = row.numbers;
        Real eta = 0;
        for (const auto& [nx, ny, amplitude, phase] : waves) {
            const Real k = turn_rad / 512 * std::hypot(nx, ny);
            const Real omega = std::sqrt((9.81L * k + 7.4e-5L * k * k * k) * std::tanh(k * 20));
            eta += amplitude *
                   std::cos(turn_rad / 512 *
                                (nx * static_cast<Real>(n[0]) + ny * static_cast<Real>(n[1])) -
                            omega * static_cast<Real>(n[2]) + phase);
        }
        // 9.81 and 7.4e-5 differ from their doubles by 1e-17 of themselves; frequencies are stored
        // in steps of 2^-64 turns/us, which is 1.8e-13 rad a second; amplitudes add up to 0.875 m.
        EXPECT_NEAR(n[3], static_cast<double>(eta), 1e-9 + 0.875 * 1.8e-13 * std::abs(n[2]));
    }
}

TEST(InspectPoints, ten_waves_at_finite_depth_move_water_as_linear_theory_says) {
    for (const tests::AiryWave& wave : tests::airy_waves)
        for (const double choppiness : {1.0, 0.0, 0.5}) {
            const std::string path =
                folder().write("airy.toml", tests::airy_scene(wave, choppiness));
            std::string rows;
            const std::vector<tests::AiryPoint> points = tests::airy_points(wave, choppiness);
            for (const tests::AiryPoint& p : points)
                rows += fmt::format("{:.17g},{:.17g},{:.17g}\n", p.x_m, p.y_m,
                                    static_cast<double>(p.time_us) * 1e-6);
            const std::vector<Row> answers = evaluate(path, rows);
            ASSERT_EQ(answers.size(), points.size());
            for (std::size_t i = 0; i < points.size(); ++i) {
                const auto& n = answers[i].numbers;
                EXPECT_NEAR(n[3], points[i].height_m, 1e-6 * wave.amplitude_m());
                for (std::size_t axis = 0; axis < 3; ++axis)
                    EXPECT_NEAR(n[7 + axis], points[i].velocity_mps[axis],
                                1e-6 * wave.horizontal_speed_mps())
                        << wave.period_s << " s on " << wave.depth_m << " m, axis " << axis;
            }
        }
}

TEST(InspectPoints, rows_keep_their_order_and_the_header_is_optional) {
    const std::string path = folder().write("two_swells.toml", two_swells);
    const std::vector<Row> bare = evaluate(path, "5,6,100\n1,2,0\n5,6,50\n");
    const std::vector<Row> dressed =
        evaluate(path, "x_m, y_m, t_s\r\n 5 , 6,1e2\r\n\r\n1,2,0\r\n5,6,50");
    ASSERT_EQ(bare.size(), 3u);
    ASSERT_EQ(dressed.size(), 3u);
    const double times[] = {100, 0, 50};
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(bare[i].numbers, dressed[i].numbers);
        EXPECT_EQ(bare[i].numbers[2], times[i]);
    }
    EXPECT_NE(bare[0].numbers[3], bare[2].numbers[3]); // the sea moved
}

// Naive: what int64 holds is taken, nine times what the sea is asked for anywhere else.
TEST(InspectPoints, times_are_those_that_every_program_takes) {
    const std::string scene = folder().write("times.toml", "[sea]\n");
    EXPECT_EQ(evaluate(scene, "0,0,1e12\n0,0,-1e12\n").size(), 2u);
    for (const char* time : {"1.000000000001e12", "-9.2e12", "9.2e12", "nan"}) {
        const Output output =
            run_program("seaway-inspect", scene + " --eval -", std::string("0,0,") + time + "\n");
        EXPECT_EQ(output.status, 2) << time;
        EXPECT_THAT(output.err, ::testing::HasSubstr("between -1e+12 and 1e+12")) << time;
    }
}

TEST(InspectPoints, places_are_taken_up_to_their_limit_east_and_north_and_refused_beyond_it) {
    const std::string scene = folder().write("places.toml", "[sea]\n");
    EXPECT_EQ(evaluate(scene, "1e9,0,0\n-1e9,0,0\n0,1e9,0\n0,-1e9,0\n").size(), 4u);
    for (const char* axis : {"x_m", "y_m"})
        for (const char* place : {"1.000000000001e9", "-1.1e9", "1e12", "inf"}) {
            const std::string row =
                *axis == 'x' ? place + std::string(",0,0\n") : std::string("0,") + place + ",0\n";
            const Output output = run_program("seaway-inspect", scene + " --eval -", row);
            EXPECT_EQ(output.status, 2) << row;
            EXPECT_THAT(output.err, ::testing::HasSubstr(std::string(axis) + " = '" + place +
                                                         "': not a number between -1e+09 and "
                                                         "1e+09"))
                << row;
        }
}

// Naive: a line goes on for as long as its file does, in memory.
TEST(InspectPoints, a_line_that_does_not_end_is_named) {
    const std::string scene = folder().write("swells.toml", two_swells);
    const Output ran =
        run_program("seaway-inspect", scene + " --eval -", "1,2,3\n" + std::string(5000, ' '));
    EXPECT_EQ(ran.status, 2);
    EXPECT_EQ(ran.err, "seaway-inspect: standard input:2: the line has more than 4096 bytes\n");
}

TEST(InspectPoints, no_rows_give_the_header_alone) {
    const std::string path = folder().write("two_swells.toml", two_swells);
    EXPECT_TRUE(evaluate(path, "").empty());
}

// A folder is opened as a file is, and cannot be read. Naive: std::cin says that it ended, and no rows are all that were asked for.
TEST(InspectPoints, that_cannot_be_read_to_their_end_are_an_error) {
    const std::string scene = folder().write("sea.toml", two_swells);
    const Output output = run_program("seaway-inspect", scene + " --eval - </");
    EXPECT_EQ(output.status, 2);
    EXPECT_NE(output.err.find("standard input:1: cannot be read to its end"), std::string::npos);
}

} // namespace
} // namespace seaway
