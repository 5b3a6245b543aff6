// SPDX-License-Identifier: Apache-2.0
// Where charts put what they draw: text, marks, legends, scales. Nothing is symmetrical.
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <tuple>

#include "tools/plot/plot.h"

namespace seaway::plot {
namespace {

/// The box around all that is not white, in pixels; empty boxes are {0, 0, 0, 0}.
Rect inked(const Canvas& canvas, Rect within) {
    Rect box{1e9, 1e9, -1e9, -1e9};
    for (int y = static_cast<int>(within.top); y < static_cast<int>(within.bottom); ++y)
        for (int x = static_cast<int>(within.left); x < static_cast<int>(within.right); ++x) {
            const Color c = canvas.pixel(x, y);
            if (c.red + c.green + c.blue < 3 * 200)
                box = {std::min<double>(box.left, x), std::min<double>(box.top, y),
                       std::max<double>(box.right, x + 1), std::max<double>(box.bottom, y + 1)};
        }
    return box.left > box.right ? Rect{} : box;
}
Rect inked(const Canvas& canvas) {
    return inked(canvas, canvas.frame());
}

double darkness(const Canvas& canvas, Rect within) {
    double sum = 0;
    for (int y = static_cast<int>(within.top); y < static_cast<int>(within.bottom); ++y)
        for (int x = static_cast<int>(within.left); x < static_cast<int>(within.right); ++x)
            sum += (255 - canvas.pixel(x, y).red) / 255.0;
    return sum;
}

bool same(Color a, Color b) {
    return a.red == b.red && a.green == b.green && a.blue == b.blue;
}

TEST(Chart, text_stands_on_its_line_beside_around_or_before_its_place) {
    const double width = Canvas::text_width("MLLL", 20);
    ASSERT_GT(width, 40);
    for (const auto& [align, left] : {std::pair(Align::left, 200.0),
                                      {Align::centre, 200.0 - 0.5 * width},
                                      {Align::right, 200.0 - width}}) {
        Canvas canvas(400, 100);
        canvas.text({200, 60}, "MLLL", {black, 20, align});
        const Rect box = inked(canvas);
        // Strokes are 2.5 px wide.
        EXPECT_NEAR(box.left, left, 2.5);
        EXPECT_NEAR(box.right, left + width, 2.5);
        EXPECT_NEAR(box.bottom, 60, 2.5);
        EXPECT_NEAR(box.top, 40, 2.5) << "a capital letter is as high as its size";
    }
}

TEST(Chart, text_upwards_reads_from_bottom_to_top) {
    Canvas canvas(200, 300);
    canvas.text({100, 250}, "M   .", {black, 20, Align::left, false, true});
    const Rect box = inked(canvas);
    EXPECT_NEAR(box.right, 100, 2.5) << "its base line is on the right";
    EXPECT_NEAR(box.left, 80, 2.5);
    EXPECT_NEAR(box.bottom, 250, 2.5);
    EXPECT_NEAR(box.top, 250 - Canvas::text_width("M   .", 20), 2.5);
    // The M, which comes first, is below and has most of the ink.
    const double middle = 0.5 * (box.top + box.bottom);
    EXPECT_GT(darkness(canvas, {0, middle, 200, 300}), 2 * darkness(canvas, {0, 0, 200, middle}));
}

TEST(Chart, bold_text_is_half_as_thick_again) {
    const auto ink_of = [](bool bold) {
        Canvas canvas(300, 60);
        canvas.text({10, 40}, "Hs 3", {black, 24, Align::left, bold});
        return darkness(canvas, canvas.frame());
    };
    EXPECT_NEAR(ink_of(true) / ink_of(false), 0.19 / 0.125, 0.1);
}

TEST(Chart, discs_and_circles_have_their_radius_and_their_place) {
    Canvas canvas(200, 120);
    canvas.disc({50, 70}, 11, black);
    const Rect disc = inked(canvas);
    EXPECT_NEAR(0.5 * (disc.left + disc.right), 50, 1);
    EXPECT_NEAR(0.5 * (disc.top + disc.bottom), 70, 1);
    EXPECT_NEAR(disc.width(), 22, 1);
    EXPECT_NEAR(darkness(canvas, canvas.frame()), 3.14159 * 121, 10);
    Canvas round(200, 120);
    round.circle({120, 50}, 40, {black, 2});
    const Rect circle = inked(round);
    EXPECT_NEAR(circle.left, 79, 1);
    EXPECT_NEAR(circle.bottom, 91, 1);
    EXPECT_NEAR(darkness(round, round.frame()), 2 * 3.14159 * 40 * 2, 15);
}

struct CornerPlace {
    Corner corner;
    bool right, bottom;
};

TEST(Chart, a_legend_stands_in_its_corner_and_names_series_in_their_order) {
    for (const CornerPlace& place :
         {CornerPlace{Corner::top_left, false, false}, CornerPlace{Corner::top_right, true, false},
          CornerPlace{Corner::bottom_left, false, true},
          CornerPlace{Corner::bottom_right, true, true}}) {
        Canvas canvas(500, 400);
        const Rect area{60, 30, 460, 350};
        Chart chart(canvas, area, {"", 0, 1}, {"", 0, 1});
        const std::vector<Point> nowhere; // a legend alone
        chart.curve(nowhere, {series_color(0), 3.0}, "a");
        chart.points(nowhere, 4.0, series_color(1), "bb");
        chart.band(2, 3, series_color(2), "ccc");
        chart.curve(nowhere, {series_color(3), 3.0}); // no name, no place
        chart.draw_legend(place.corner);
        const Rect box = inked(canvas);
        EXPECT_EQ(box.left > 260, place.right);
        EXPECT_EQ(box.right > 260, place.right);
        EXPECT_EQ(box.top > 190, place.bottom);
        EXPECT_EQ(box.bottom > 190, place.bottom);
        EXPECT_TRUE(area.contains({box.left, box.top}) && area.contains({box.right, box.bottom}));
        // Marks one below the other, on the left of their names: a line, a dot and a patch.
        const auto rows_of = [&](Color color) {
            Rect rows{1e9, 1e9, -1e9, -1e9};
            for (int y = 0; y < canvas.height(); ++y)
                for (int x = 0; x < canvas.width(); ++x)
                    if (same(canvas.pixel(x, y), color))
                        rows = {std::min<double>(rows.left, x), std::min<double>(rows.top, y),
                                std::max<double>(rows.right, x + 1),
                                std::max<double>(rows.bottom, y + 1)};
            return rows;
        };
        const Rect line = rows_of(series_color(0)), dot = rows_of(series_color(1)),
                   patch = rows_of(series_color(2));
        EXPECT_NEAR(line.width(), 24, 4);
        EXPECT_NEAR(line.height(), 3, 1);
        EXPECT_NEAR(dot.width(), 8, 2);
        EXPECT_NEAR(patch.width(), 24, 1);
        EXPECT_NEAR(patch.height(), 10, 1);
        EXPECT_LT(line.bottom, dot.top);
        EXPECT_LT(dot.bottom, patch.top);
        EXPECT_LT(rows_of(series_color(3)).right, 0) << "it has no name";
        EXPECT_GT(inked(canvas, {patch.right + 2, patch.top - 2, 500, patch.bottom + 2}).width(),
                  inked(canvas, {line.right + 2, line.top - 5, 500, line.bottom + 5}).width())
            << "three letters are wider than one";
    }
}

TEST(Chart, bars_bands_and_lines_stand_at_their_values_and_within_the_axes) {
    Canvas canvas(500, 400);
    const Rect area{100, 50, 420, 330};
    Chart chart(canvas, area, {"", 10, 50}, {"", 0, 7});
    // x = 20 is at 180 px, y = 2 at 250 px.
    chart.bar(20, 2, 6, series_color(0));
    EXPECT_TRUE(same(canvas.pixel(178, 251), series_color(0)));
    EXPECT_TRUE(same(canvas.pixel(182, 329), series_color(0)));
    EXPECT_TRUE(same(canvas.pixel(180, 248), white)) << "above it";
    EXPECT_TRUE(same(canvas.pixel(180, 331), white)) << "below the axis";
    EXPECT_TRUE(same(canvas.pixel(175, 300), white));
    EXPECT_TRUE(same(canvas.pixel(184, 300), white));
    chart.band(40, 80, series_color(1)); // from 340 px, and the axis ends at 420
    EXPECT_TRUE(same(canvas.pixel(341, 51), series_color(1)));
    EXPECT_TRUE(same(canvas.pixel(419, 329), series_color(1)));
    EXPECT_TRUE(same(canvas.pixel(338, 200), white));
    EXPECT_TRUE(same(canvas.pixel(421, 200), white));
    EXPECT_TRUE(same(canvas.pixel(400, 49), white));
    chart.vertical(30, {series_color(2), 1.0}); // 260 px
    EXPECT_TRUE(same(canvas.pixel(260, 60), series_color(2)));
    EXPECT_TRUE(same(canvas.pixel(260, 320), series_color(2)));
    EXPECT_TRUE(same(canvas.pixel(260, 40), white));
    chart.vertical(70, {series_color(2), 1.0});
    EXPECT_TRUE(same(canvas.pixel(480, 200), white)) << "beyond the axis";
    Canvas noted(500, 400);
    Chart(noted, area, {"", 10, 50}, {"", 0, 7}).note({20, 2}, {15, -40}, "M", {black, 20});
    const Rect note = inked(noted);
    EXPECT_NEAR(note.left, 195, 3);
    EXPECT_NEAR(note.bottom, 210, 3);
}

TEST(Chart, curves_end_at_the_axes_and_points_beyond_are_left_out) {
    Canvas canvas(500, 400);
    const Rect area{100, 50, 420, 330};
    Chart chart(canvas, area, {"", 0, 1}, {"", 0, 1});
    const std::vector<Point> across{{-1, 0.25}, {2, 0.25}};
    chart.curve(across, {black, 2.0});
    const Rect line = inked(canvas);
    EXPECT_NEAR(line.left, 100, 1);
    EXPECT_NEAR(line.right, 420, 1);
    EXPECT_NEAR(line.bottom, 261, 1) << "a quarter up";
    Canvas dotted(500, 400);
    const std::vector<Point> dots{{-0.1, 0.5}, {0.75, 0.25}, {0.5, 1.1}};
    Chart(dotted, area, {"", 0, 1}, {"", 0, 1}).points(dots, 5.0, black);
    const Rect dot = inked(dotted);
    EXPECT_NEAR(dot.left, 335, 1);
    EXPECT_NEAR(dot.right, 345, 1);
    EXPECT_NEAR(dot.top, 255, 1);
}

TEST(Chart, the_frame_has_ticks_and_numbers_below_and_on_the_left_and_titles_beyond_them) {
    Canvas canvas(500, 400);
    const Rect area{100, 50, 420, 330};
    Chart chart(canvas, area, {"MMMM", 0, 4, Scale::linear, 1}, {"M", 0, 2, Scale::linear, 1});
    chart.draw_frame();
    // The border is one pixel wide on all four sides.
    for (const auto& [x, y] : {std::pair(100, 200), {420, 200}, {260, 50}, {260, 330}})
        EXPECT_TRUE(same(canvas.pixel(x, y), ink)) << x << ", " << y;
    EXPECT_TRUE(same(canvas.pixel(260, 200), white)) << "nothing within";
    // Ticks at 0, 1 .. 4 below, at 0, 1, 2 on the left, and nowhere else.
    for (int i = 0; i <= 4; ++i)
        EXPECT_TRUE(same(canvas.pixel(100 + 80 * i, 334), ink)) << i;
    EXPECT_FALSE(same(canvas.pixel(140, 334), ink));
    for (int i = 0; i <= 2; ++i)
        EXPECT_TRUE(same(canvas.pixel(96, 330 - 140 * i), ink)) << i;
    EXPECT_FALSE(same(canvas.pixel(96, 260), ink));
    EXPECT_EQ(inked(canvas, {422, 60, 500, 325}).width(), 0) << "none on the right";
    EXPECT_EQ(inked(canvas, {102, 0, 418, 48}).width(), 0) << "none above";
    // The wide title is below, the narrow one on the left, each in the middle.
    const Rect below = inked(canvas, {101, 354, 420, 400});
    EXPECT_NEAR(below.width(), Canvas::text_width("MMMM", 9), 3);
    EXPECT_NEAR(0.5 * (below.left + below.right), 260, 2);
    const Rect beside = inked(canvas, {0, 100, 78, 300});
    EXPECT_NEAR(beside.height(), Canvas::text_width("M", 9), 3);
    EXPECT_NEAR(0.5 * (beside.top + beside.bottom), 190, 2);
}

TEST(Chart, the_grid_is_at_the_ticks_and_fainter_where_they_have_no_number) {
    Canvas canvas(500, 400);
    Chart chart(canvas, {100, 50, 420, 330}, {"", 1, 1e5, Scale::logarithmic},
                {"", 0, 2, Scale::linear, 1});
    chart.draw_grid();
    const auto red_at = [&](double x, double y) {
        return canvas
            .pixel(static_cast<int>(chart.at({x, 1}).x), static_cast<int>(chart.at({1, y}).y))
            .red;
    };
    EXPECT_EQ(red_at(100, 0.5), 226);
    EXPECT_NEAR(red_at(300, 0.5), 0.5 * (226 + 255), 1) << "no number stands at 300";
    EXPECT_EQ(red_at(550, 0.5), 255) << "no tick";
    EXPECT_EQ(red_at(550, 1), 226);
}

std::multiset<std::string> labels_of(const std::vector<Tick>& ticks) {
    std::multiset<std::string> labels;
    for (const Tick& tick : ticks)
        if (!tick.label.empty())
            labels.insert(tick.label);
    return labels;
}

TEST(Chart, ticks_are_numbered_as_closely_as_there_is_room) {
    using Labels = std::multiset<std::string>;
    const Scale logarithmic = Scale::logarithmic;
    // Few decades: ones, twos and fives. Many: each, or every other one.
    EXPECT_EQ(labels_of(ticks({"", 0.4, 30, logarithmic})),
              (Labels{"0.5", "1", "2", "5", "10", "20"}));
    EXPECT_EQ(labels_of(ticks({"", 0.02, 3000, logarithmic})),
              (Labels{"0.1", "1", "10", "100", "10^{3}"}));
    EXPECT_EQ(labels_of(ticks({"", 1e-6, 1e3, logarithmic}, 5)),
              (Labels{"10^{-6}", "10^{-4}", "0.01", "1", "100"}));
    // Every tick that has no number is there all the same.
    EXPECT_EQ(ticks({"", 1, 100, logarithmic}).size(), 19u);
    // Linear: steps of 1, 2 or 5 of some power.
    EXPECT_EQ(labels_of(ticks({"", 0, 7})), (Labels{"0", "1", "2", "3", "4", "5", "6", "7"}));
    EXPECT_EQ(labels_of(ticks({"", 0, 20}, 8)),
              (Labels{"0", "2", "4", "6", "8", "10", "12", "14", "16", "18", "20"}));
    EXPECT_EQ(labels_of(ticks({"", -30, 10}, 8)),
              (Labels{"-30", "-25", "-20", "-15", "-10", "-5", "0", "5", "10"}));
    EXPECT_EQ(labels_of(ticks({"", 0, 55}, 7)), (Labels{"0", "10", "20", "30", "40", "50"}));
    EXPECT_EQ(short_number(0.123456), "0.123");
    EXPECT_EQ(short_number(0.123456, 5), "0.12346");
    EXPECT_EQ(short_number(-0.0), "0");
}

TEST(Chart, a_scale_of_colours_is_darkest_at_its_upper_end_and_numbered_on_the_right) {
    Canvas canvas(200, 300);
    draw_color_bar(canvas, {50, 60, 70, 260}, {"M", 0, 10, Scale::linear, 5});
    EXPECT_TRUE(same(canvas.pixel(60, 61), sea_color((260 - 61.5) / 200)));
    EXPECT_TRUE(same(canvas.pixel(60, 258), sea_color((260 - 258.5) / 200)));
    for (const int y : {60, 160, 260})
        EXPECT_TRUE(same(canvas.pixel(73, y), ink)) << y;
    EXPECT_FALSE(same(canvas.pixel(73, 110), ink));
    EXPECT_EQ(inked(canvas, {0, 60, 48, 262}).width(), 0) << "nothing on the left";
    // "10" at the top is wider than "0" at the bottom; the title is above.
    EXPECT_GT(inked(canvas, {76, 50, 200, 70}).width(),
              1.5 * inked(canvas, {76, 250, 200, 270}).width());
    EXPECT_NEAR(inked(canvas, {0, 30, 200, 56}).bottom, 51, 2);
}

TEST(Chart, colours_of_series_differ_and_those_of_the_sea_grow_darker) {
    std::set<std::tuple<int, int, int>> colours;
    for (std::size_t i = 0; i < 7; ++i)
        colours.insert({series_color(i).red, series_color(i).green, series_color(i).blue});
    EXPECT_EQ(colours.size(), 7u);
    EXPECT_TRUE(same(series_color(7), series_color(0)));
    int before = 3 * 255 + 1;
    for (int i = 0; i <= 60; ++i) {
        const Color c = sea_color(i / 60.0);
        EXPECT_LT(c.red + c.green + c.blue, before) << i;
        EXPECT_GE(c.blue, c.red) << i;
        before = c.red + c.green + c.blue;
    }
    EXPECT_TRUE(same(sea_color(-1), white));
    EXPECT_TRUE(same(sea_color(2), Color{9, 25, 62}));
}

} // namespace
} // namespace seaway::plot
