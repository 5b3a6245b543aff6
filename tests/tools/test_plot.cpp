// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/folder.h"
#include "tools/plot/lettering.h"
#include "tools/plot/plot.h"

namespace seaway::plot {
namespace {

/// Black painted on a white canvas, in pixels.
double darkness(const Canvas& canvas) {
    double sum = 0.0;
    for (int y = 0; y < canvas.height(); ++y)
        for (int x = 0; x < canvas.width(); ++x)
            sum += (255 - canvas.pixel(x, y).red) / 255.0;
    return sum;
}

TEST(Plot, slanted_line_paints_its_length_times_its_width) {
    Canvas canvas(200, 200);
    canvas.line({20.3, 30.7}, {160.1, 141.9}, {black, 3.0});
    const double length = std::hypot(160.1 - 20.3, 141.9 - 30.7);
    const double caps = 0.25 * 3.14159 * 9.0;
    // Coverage by distance is exact along a straight edge; the round caps differ by a pixel or so.
    EXPECT_NEAR(darkness(canvas), 3.0 * length + caps, 4.0);
}

TEST(Plot, a_curve_is_dashed_alike_however_many_points_it_has) {
    const auto drawn = [](int points, double dash_px) {
        std::vector<Point> curve;
        for (int i = 0; i < points; ++i)
            curve.push_back({10.0 + 180.0 * i / (points - 1), 20.0});
        Canvas canvas(200, 40);
        canvas.line(curve, {black, 2.0, dash_px});
        return darkness(canvas);
    };
    const double solid = drawn(2, 0), dashed = drawn(2, 6);
    EXPECT_LT(dashed, 0.75 * solid) << "gaps as long as dashes, less their round ends";
    for (const int points : {3, 50, 600})
        EXPECT_NEAR(drawn(points, 6), dashed, 0.02 * solid) << points;
}

TEST(Plot, joints_of_a_translucent_line_are_painted_once) {
    Canvas canvas(60, 60);
    const std::vector<Point> corner{{10, 30}, {30, 30}, {30, 50}};
    canvas.line(corner, {black.faded(0.5), 4.0});
    for (int y = 0; y < 60; ++y)
        for (int x = 0; x < 60; ++x)
            EXPECT_GE(canvas.pixel(x, y).red, 127) << x << ' ' << y;
}

TEST(Plot, fractions_of_pixels_count_in_filled_areas) {
    Canvas canvas(40, 40);
    canvas.fill({10.25, 10.5, 20.75, 20.0}, black);
    EXPECT_NEAR(darkness(canvas), 10.5 * 9.5, 0.2); // 8-bit rounding of about 40 edge pixels
}

TEST(Plot, nothing_is_painted_outside_the_clip_or_the_canvas) {
    Canvas canvas(40, 40);
    canvas.set_clip({10, 10, 30, 30});
    canvas.line({-1e6, 20}, {1e6, 20}, {black, 2.0});
    canvas.fill({-100, -100, 5, 5}, black);
    canvas.disc({35, 35}, 3, black);
    EXPECT_EQ(canvas.pixel(5, 20).red, 255);
    EXPECT_EQ(canvas.pixel(35, 35).red, 255);
    EXPECT_NEAR(darkness(canvas), 40.0, 1.0); // 20 pixels of 2
}

TEST(Plot, every_printable_character_has_a_glyph_of_its_own) {
    const Lettering box = letter("\x01");
    for (char c = '!'; c <= '~'; ++c) {
        const Lettering glyph = letter(std::string(1, c));
        ASSERT_FALSE(glyph.strokes.empty()) << c;
        EXPECT_FALSE(glyph.width == box.width && glyph.strokes.size() == box.strokes.size() &&
                     glyph.strokes[0].size() == box.strokes[0].size())
            << c;
    }
    for (const char* c : {"ω", "θ", "°", "·", "×", "±", "Δ", "σ", "λ", "μ", "–", "—"})
        EXPECT_NE(letter(c).strokes.at(0).size(), box.strokes[0].size()) << c;
}

TEST(Plot, broken_utf8_is_drawn_as_boxes) {
    EXPECT_EQ(letter("\xff").strokes.size(), 1u);
    EXPECT_EQ(letter("\xce").strokes.size(), 1u); // the sequence ends early
}

// A stroke without a width of its own stands 2.4 from the next one, and the last one has no next.
TEST(Plot, letters_stand_their_gap_apart_and_none_stands_behind_the_last) {
    EXPECT_EQ(letter("").width, 0);
    EXPECT_EQ(letter("|").width, 0);
    EXPECT_NEAR(letter("|||").width, 4.8, 1e-12);
    EXPECT_NEAR(letter("MW").width, letter("M").width + letter("W").width + 2.4, 1e-12);
}

TEST(Plot, braces_raise_and_lower_and_cost_no_width_themselves) {
    const Lettering plain = letter("m2");
    const Lettering raised = letter("m^{2}");
    EXPECT_LT(raised.width, plain.width);
    EXPECT_GT(raised.strokes.back().front().y, plain.strokes.back().front().y);
    EXPECT_LT(letter("m_{2}").strokes.back().back().y, 0.0);
}

TEST(Plot, linear_ticks_are_round_numbers_inside_the_axis) {
    const std::vector<Tick> found = ticks({"", -0.3, 1.23});
    ASSERT_GE(found.size(), 4u);
    for (const Tick& tick : found) {
        EXPECT_GE(tick.value, -0.3);
        EXPECT_LE(tick.value, 1.23);
        EXPECT_NEAR(std::remainder(tick.value, 0.2), 0.0, 1e-12);
    }
    const std::vector<Tick> angles = ticks({"", -180, 180, Scale::linear, 90});
    ASSERT_EQ(angles.size(), 5u);
    EXPECT_EQ(angles[2].label, "0"); // and not "-0"
}

TEST(Plot, logarithmic_ticks_label_decades) {
    int labels = 0;
    for (const Tick& tick : ticks({"", 1e-4, 10, Scale::logarithmic}))
        if (!tick.label.empty()) {
            ++labels;
            const double decade = std::log10(tick.value);
            EXPECT_NEAR(decade, std::round(decade), 1e-9);
        }
    EXPECT_EQ(labels, 6);
}

TEST(Plot, chart_places_and_reads_back_the_same_value) {
    Canvas canvas(300, 200);
    const Chart chart(canvas, {50, 20, 280, 160}, {"x", 0.1, 100, Scale::logarithmic},
                      {"y", -2, 5});
    const Point there = chart.at({3.7, 1.5});
    EXPECT_TRUE(chart.area().contains(there));
    const Point back = chart.value_at(there);
    EXPECT_NEAR(back.x, 3.7, 1e-9);
    EXPECT_NEAR(back.y, 1.5, 1e-9);
}

TEST(Plot, values_that_an_axis_cannot_show_are_left_out) {
    Canvas canvas(300, 200);
    Chart chart(canvas, {50, 20, 280, 160}, {"x", 0.1, 100, Scale::logarithmic}, {"y", 0, 1});
    const std::vector<Point> bad{{-1, 0.5}, {NAN, 0.5}, {1, INFINITY}};
    chart.curve(bad, {black, 2.0});
    chart.points(bad, 3.0, black);
    EXPECT_EQ(darkness(canvas), 0.0);
}

TEST(Plot, picture_that_cannot_be_written_is_an_error_with_its_name) {
    const Result<void> written = Canvas(10, 10).write_png(tests::folder().file("no/p.png"));
    ASSERT_FALSE(written);
    EXPECT_NE(written.error().message.find("no/p.png"), std::string::npos);
}

} // namespace
} // namespace seaway::plot
