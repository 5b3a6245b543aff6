// SPDX-License-Identifier: Apache-2.0
// seaway-inspect --plot: what is drawn lies where it belongs. Places are read from the pixels; the axes
// are those of the two charts and of the compass, which are fixed.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <numbers>

#include <fmt/format.h>

#include "sea/scene/scene.h"
#include "sea/waves/statistics/moments.h"
#include "tests/support/program.h"
#include "tests/tools/pixels.h"

namespace seaway {
namespace {

using plot::Color;
using testing::Pixels;
using tests::folder;

using sea::two_pi;

/// As it is seen over white.
Color over_white(Color color) {
    const auto mix = [&](int part) {
        return static_cast<std::uint8_t>(std::lround(255 + (part - 255) * color.opacity));
    };
    return {mix(color.red), mix(color.green), mix(color.blue)};
}

int apart(Color a, Color b) {
    return std::max(
        {std::abs(a.red - b.red), std::abs(a.green - b.green), std::abs(a.blue - b.blue)});
}

struct Drawn {
    sea::Scene scene;
    sea::Realization sea;
    sea::SeaSummary summary;
    Pixels pixels;

    double omega(double k) const { return scene.sea.dispersion().omega(k); }
};

Drawn draw(const std::string& name, const std::string& text) {
    const std::string path = folder().write(name + ".toml", text);
    const std::string png = folder().file(name + ".png");
    const tests::Output ran = tests::run_program("seaway-inspect", path + " --plot " + png);
    EXPECT_EQ(ran.status, 0) << ran.err;
    sea::Scene scene = sea::read_scene(path).value();
    sea::Realization sea = sea::realize(scene).value();
    sea::SeaSummary summary = summarize(scene.sea, sea);
    return {std::move(scene), std::move(sea), std::move(summary), Pixels(png)};
}

/// A logarithmic axis of frequencies over some pixels.
struct FrequencyAxis {
    double lo_radps, hi_radps, left_px, right_px;

    double px(double omega) const {
        return left_px +
               (right_px - left_px) * std::log(omega / lo_radps) / std::log(hi_radps / lo_radps);
    }
};

/// Of the large chart, whose inside is 92 .. 720 by 112 .. 636 px.
FrequencyAxis axis_of(const Drawn& drawn, double lowest_peak, double highest_peak) {
    const double begin = drawn.omega(drawn.sea.cascades.front().band.k_lo_radpm);
    const double end = drawn.omega(drawn.sea.cascades.back().band.k_hi_radpm);
    if (!(highest_peak > 0))
        return {0.8 * begin, 1.3 * end, 92, 720};
    return {std::max(0.5 * begin, 0.45 * lowest_peak), std::max(1.4 * end, 3 * highest_peak), 92,
            720};
}

struct Wave {
    int nx, ny;
    double amplitude_m;
};

// Naive: the logarithm of no energy places marks anywhere.
TEST(InspectPicture, a_sea_whose_heights_are_scaled_to_nothing_is_drawn_flat) {
    const std::string scene = folder().write("nothing.toml", R"([sea]
height_scale = 0.0
[[sea.system]]
type = "swell"
spectrum = "jonswap"
significant_height_m = 2.0
peak_period_s = 10.0
from_deg = 300
spreading = "cos2s"
spreading_exponent = 10
[[cascade]]
length_m = 500.0
size = 64
)");
    const std::string path = folder().file("nothing.png");
    const tests::Output ran = tests::run_program("seaway-inspect", scene + " --plot " + path);
    EXPECT_EQ(ran.status, 0) << ran.err;
    EXPECT_EQ(ran.err, "");
    EXPECT_EQ(Pixels(path).width, 1200);
}

TEST(InspectPicture, each_wave_given_by_hand_stands_at_its_frequency_height_and_bearing) {
    const Wave waves[] = {{6, -2, 0.9}, {-3, 5, 0.4}, {1, 4, 0.15}};
    std::string rows = "nx,ny,amplitude_m,phase_rad\n";
    for (const Wave& wave : waves)
        rows += fmt::format("{},{},{},0.7\n", wave.nx, wave.ny, wave.amplitude_m);
    const Drawn drawn =
        draw("waves", "[sea]\n[[sea.system]]\ntype = \"modes\"\nlength_m = 200\ndata = \"\"\"\n" +
                          rows + "\"\"\"\n[[cascade]]\nlength_m = 200\nsize = 64\n");
    ASSERT_EQ(drawn.pixels.width, 1200);
    const FrequencyAxis axis = axis_of(drawn, 0, 0);
    const auto omega_of = [&](const Wave& wave) {
        return drawn.omega(two_pi / 200 * std::hypot(wave.nx, wave.ny));
    };
    double fastest = 0;
    for (const Wave& wave : waves)
        fastest = std::max(fastest, omega_of(wave));
    const auto blue = [&](double x, double y) {
        const Color at = drawn.pixels.at(x, y);
        return at.blue - at.red > 80;
    };
    for (const Wave& wave : waves) {
        // From the bottom to the height, 0 .. 1.15 of the largest.
        const double x = axis.px(omega_of(wave));
        const double top = 636 - (636 - 112) * wave.amplitude_m / (1.15 * 0.9);
        EXPECT_TRUE(blue(x, 0.5 * (top + 636))) << wave.nx;
        EXPECT_TRUE(blue(x, top + 1)) << wave.nx;
        EXPECT_FALSE(blue(x, top - 8)) << wave.nx;
        // North is up and east is right, and a wave stands where it comes from.
        const double n = std::hypot(wave.nx, wave.ny);
        const double radius = 150 * omega_of(wave) / (1.1 * fastest);
        const double east = -radius * wave.nx / n, north = -radius * wave.ny / n;
        EXPECT_TRUE(blue(936 + east, 262 - north)) << wave.nx;
        for (const auto& [x_px, y_px] : {std::pair(936 - east, 262 + north),
                                         {936 + east, 262 + north},
                                         {936 - east, 262 - north},
                                         {936 + north, 262 - east}})
            EXPECT_FALSE(blue(x_px, y_px)) << wave.nx << ": seen in a mirror";
    }
}

std::string swell(double height_m, double period_s, double from_deg) {
    return fmt::format("[[sea.system]]\ntype = \"swell\"\nsignificant_height_m = {}\n"
                       "peak_period_s = {}\nfrom_deg = {}\nspreading = \"cos2s\"\n"
                       "spreading_exponent = 60\n",
                       height_m, period_s, from_deg);
}

const std::string tiles = "[[cascade]]\nlength_m = 600\nsize = 64\n"
                          "[[cascade]]\nlength_m = 120\nsize = 64\n"
                          "[[cascade]]\nlength_m = 29\nsize = 64\n";

TEST(InspectPicture, energy_lies_on_the_compass_where_and_at_which_frequency_waves_come_from) {
    const Drawn drawn = draw("compass", "[sea]\n" + swell(2, 8, 75) + tiles);
    // The rim is three times the frequency of the peak. White is nothing.
    const auto darkness = [&](double bearing_deg, double peaks) {
        const double angle = bearing_deg * two_pi / 360, r = 50 * peaks;
        return 255 - drawn.pixels.at(936 + r * std::sin(angle), 262 - r * std::cos(angle)).red;
    };
    EXPECT_GT(darkness(75, 1.02), 215) << "the darkest colour at the peak";
    for (const double bearing_deg : {105.0, 255.0, 285.0, 15.0, 165.0})
        EXPECT_LT(darkness(bearing_deg, 1.02), 60) << bearing_deg << ": nothing comes from there";
    EXPECT_LT(darkness(75, 0.55), 40) << "nothing below the peak";
    // Amplitudes fall as w^-5/2: a sixth of the largest at twice the peak.
    EXPECT_LT(darkness(75, 1.9), 120);
    EXPECT_GT(darkness(75, 1.9), 5);
    // Beside it the scale, from nothing to the largest.
    EXPECT_LT(apart(drawn.pixels.at(1133, 135), plot::sea_color(0.985)), 12);
    EXPECT_LT(apart(drawn.pixels.at(1133, 389), plot::sea_color(0.015)), 12);
}

/// The row of the darkest pixel of a column.
int darkest_row(const Pixels& pixels, double x, int from, int to) {
    int darkest = from;
    for (int y = from; y < to; ++y)
        if (pixels.at(x, y).red < pixels.at(x, darkest).red)
            darkest = y;
    return darkest;
}

TEST(InspectPicture, directions_of_each_frequency_are_drawn_on_their_side_of_the_mean) {
    // Swell of 14 s from 60 degrees, waves of 5 s from 130.
    const Drawn drawn = draw("spreading", "[sea]\n" + swell(2, 14, 60) + swell(2, 5, 130) + tiles);
    const double mean_deg = std::round(
        std::fmod(270 - drawn.summary.requested.mean_towards_rad * 360 / two_pi + 720, 360.0));
    ASSERT_GT(mean_deg, 65);
    ASSERT_LT(mean_deg, 125);
    FrequencyAxis axis = axis_of(drawn, two_pi / 14, two_pi / 5);
    axis.left_px = 800;
    axis.right_px = 1090;
    // 180 degrees clockwise from the mean at the upper edge, 500 px; as much the other way at 636.
    const auto from_deg = [&](double omega) {
        const int row = darkest_row(drawn.pixels, axis.px(omega), 502, 634);
        return mean_deg + 180 - 360 * (row + 0.5 - 500) / 136;
    };
    // Beside the peaks, on which a line may stand; a pixel is 2.6 degrees.
    EXPECT_NEAR(from_deg(1.1 * two_pi / 14), 60, 4);
    EXPECT_NEAR(from_deg(1.1 * two_pi / 5), 130, 4);
}

TEST(InspectPicture, bands_and_the_peak_stand_at_their_frequencies) {
    const Drawn drawn = draw("chart", "[sea]\n" + swell(3, 9, 75) + tiles);
    const FrequencyAxis axis = axis_of(drawn, two_pi / 9, two_pi / 9);
    // Bands: below all lettering, inside each end and outside of all. Lines of the grid may pass.
    const auto tinted = [&](double x, Color color) {
        int pixels = 0;
        for (int i = -2; i <= 2; ++i)
            pixels += apart(drawn.pixels.at(x + i, 633), over_white(color)) <= 6;
        return pixels >= 3;
    };
    const Color white{255, 255, 255};
    for (std::size_t c = 0; c < 3; ++c) {
        const sea::Band& band = drawn.sea.cascades[c].band;
        const double lo = std::max(axis.px(drawn.omega(band.k_lo_radpm)), axis.left_px);
        const double hi = axis.px(drawn.omega(band.k_hi_radpm));
        const Color color = plot::series_color(c).faded(0.13);
        EXPECT_TRUE(tinted(lo + 5, color)) << c;
        EXPECT_TRUE(tinted(hi - 5, color)) << c;
        if (c > 0) {
            EXPECT_FALSE(tinted(lo - 5, color)) << c;
        }
        if (c == 2) {
            EXPECT_TRUE(tinted(hi + 5, white));
        }
    }
    // Periods stand above at their frequencies: longer ticks where they are numbered.
    for (const double period_s : {2.0, 5.0, 10.0}) {
        EXPECT_LT(apart(drawn.pixels.at(axis.px(two_pi / period_s), 108), plot::ink), 10)
            << period_s;
        EXPECT_GT(drawn.pixels.at(axis.px(two_pi / (1.05 * period_s)), 108).red, 200) << period_s;
    }
    // The peak is a red line of dashes.
    const auto reds = [&](double x) {
        int rows = 0;
        for (int y = 300; y < 600; ++y) {
            const Color at = drawn.pixels.at(x, y);
            rows += at.red > 150 && at.green < 120;
        }
        return rows;
    };
    const double peak = axis.px(two_pi / drawn.summary.requested.peak_period_s);
    EXPECT_GT(reds(peak), 100);
    EXPECT_LT(reds(peak), 240) << "gaps as long as dashes, less their round ends";
    EXPECT_EQ(reds(peak + 4) + reds(peak - 4), 0);
}

TEST(InspectPicture, the_density_is_drawn_on_logarithmic_scales) {
    const Drawn drawn = draw("chart", "[sea]\n" + swell(3, 9, 75) + tiles);
    const FrequencyAxis axis = axis_of(drawn, two_pi / 9, two_pi / 9);
    // On a logarithmic scale the height of the curve is straight in ln S(w).
    std::vector<double> row, density;
    for (double omega = 0.85 * two_pi / 9; omega < 3 * two_pi / 9; omega *= 1.03) {
        const double x = axis.px(omega);
        std::vector<int> inked;
        for (int y = 114; y < 634; ++y) {
            const Color at = drawn.pixels.at(x, y);
            if (at.red < 70 && at.green < 75 && at.blue < 90)
                inked.push_back(y);
        }
        if (inked.empty() || inked.back() - inked.front() > 12)
            continue; // under a point, or lettering
        row.push_back(0.5 * (inked.front() + inked.back()) + 0.5);
        density.push_back(std::log(requested_frequency_density(drawn.scene.sea, omega)));
    }
    ASSERT_GT(row.size(), 15u);
    double n = 0, x = 0, y = 0, xx = 0, xy = 0;
    for (std::size_t i = 0; i < row.size(); ++i) {
        n += 1;
        x += density[i];
        y += row[i];
        xx += density[i] * density[i];
        xy += density[i] * row[i];
    }
    const double slope = (n * xy - x * y) / (n * xx - x * x), level = (y - slope * x) / n;
    EXPECT_LT(slope, -10) << "more is higher up";
    for (std::size_t i = 0; i < row.size(); ++i)
        EXPECT_NEAR(row[i], level + slope * density[i], 4)
            << i; // where it is steep, a pixel is three
}

} // namespace
} // namespace seaway
