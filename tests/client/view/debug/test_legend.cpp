// SPDX-License-Identifier: Apache-2.0
// Legends: the letters, the bars beside what the picture shows, and where there is none.
#include <set>

#include <gmock/gmock.h>

#include "tests/client/view/debug/read_label.h"
#include "tests/client/view/renderer_fixture.h"

namespace seaway::client {
namespace {

ShownPicture blank(int width, int height) {
    return {width, height,
            std::vector<std::uint8_t>(
                4 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 128)};
}

bool bright(const ShownPicture& picture, int x, int y) {
    return picture.rgba[4 * static_cast<std::size_t>(y * picture.width + x)] > 200;
}

// Drawn by hand: what a reader should see.
TEST(Lettering, a_line_of_text_looks_as_it_was_drawn_by_hand) {
    const char* art[] = {
        "#...#................#.........###.", "#...#...............##........#...#",
        "#...#..###.........#.#............#", "#####.#...........#..#...........#.",
        "#...#..###........#####.........#..", "#...#.....#..........#...##....#...",
        "#...#.####...........#...##...#####", "...................................",
    };
    for (const int width : {320, 1280}) { // dots of one and of two pixels
        const int dot = width / 640 > 1 ? width / 640 : 1;
        ShownPicture picture = blank(width, 64);
        lay_over(picture, make_label("Hs 4.2", width));
        for (int row = 0; row < 8; ++row)
            for (int column = 0; column < 35; ++column)
                for (int part = 0; part < dot; ++part)
                    EXPECT_EQ(bright(picture, dot * (2 + column) + part, dot * (2 + row) + part),
                              art[row][column] == '#')
                        << column << " of row " << row;
    }
}

TEST(Lettering, every_printable_letter_is_seen_and_differs_from_all_others) {
    std::set<std::string> shapes;
    for (char letter = ' '; letter <= '~'; ++letter) {
        std::string shape;
        for (int row = 0; row < letter_rows; ++row)
            for (int column = 0; column < letter_columns; ++column)
                shape += letter_dot(letter, column, row) ? '#' : '.';
        EXPECT_EQ(shape.find('#') != std::string::npos, letter != ' ') << letter;
        EXPECT_TRUE(shapes.insert(shape).second) << letter;
    }
    EXPECT_TRUE(letter_dot('\x80', 0, 0)) << "a box";
}

class LegendTest : public RendererTest {
  protected:
    static LegendText text_of(const std::string& words, double largest = 1) {
        const Result<DebugChoice> choice = parse_debug_view(words);
        EXPECT_TRUE(choice) << words;
        return {.choice = *choice,
                .display = {.view = choice->view,
                            .significant_height_m = 4,
                            .colouring = choice->colouring,
                            .largest = largest},
                .cascades = 3,
                .time_s = 100};
    }
    std::array<int, 3> colour_of(const Display& display, double number, float alpha = 1) {
        const auto value = static_cast<float>(number);
        const Result<ShownPicture> shown =
            renderer_of(1, 1, {}).develop({1, 1, {value, value, value, alpha}}, display);
        EXPECT_TRUE(shown);
        return {shown->rgba[0], shown->rgba[1], shown->rgba[2]};
    }
};

// The shader's colours and the bar's, read from bytes: at both ends and in the middle of each bar of each view.
TEST_F(LegendTest, bars_have_the_colours_that_the_picture_gives_to_their_numbers) {
    for (const DebugViewInfo& row : debug_view_table())
        for (int channel = -1; channel < row.channel_count(); ++channel)
            for (const char* set : {"", ",gain=3,flip=on", ",flip=on"}) {
                if (row.source == DebugSource::light)
                    continue;
                LegendText text = text_of(std::string(row.name) + ":legend=on" + set, 20);
                if (row.channel_count() > 1)
                    text.choice.colouring.channel = text.display.colouring.channel = channel;
                const Legend legend = make_legend(text, 640, 360);
                ASSERT_EQ(legend.bars.size(), row.together && text.choice.colouring.channel < 0
                                                  ? static_cast<std::size_t>(row.channel_count())
                                                  : 1u);
                ShownPicture picture = blank(640, 360);
                lay_over(picture, legend);
                for (const LegendBar& bar : legend.bars)
                    for (const double place : {0.0, 0.5, 1.0}) {
                        // Where colours repeat, the end is the beginning.
                        const bool again = bar.scale.spacing == Spacing::repeated;
                        const double near_end =
                            again && place == (bar.scale.flip ? 0.0 : 1.0) ? 0.9999 : place;
                        const double at = again && bar.scale.flip && place == 0 ? 1e-4 : near_end;
                        const std::array<int, 3> seen =
                            colour_of(text.display, bar.scale.number(at));
                        const int x =
                            bar.left + static_cast<int>(std::lround(place * (bar.width - 1)));
                        const std::uint8_t* in_bar =
                            &picture.rgba[4 * static_cast<std::size_t>(
                                                  (bar.top + bar.height / 2) * 640 + x)];
                        for (int c = 0; c < 3; ++c)
                            if (bar.channel < 0 || bar.channel == c) {
                                EXPECT_NEAR(seen[static_cast<std::size_t>(c)], in_bar[c], 1)
                                    << debug_text(text.choice) << " at " << place << " channel "
                                    << c;
                            }
                    }
            }
}

// Naive: the gain is applied to what is shown, so that what was dark stays dark.
TEST_F(LegendTest, a_gain_and_a_bias_show_what_a_number_so_changed_shows) {
    const LegendText plain = text_of("height");
    const LegendText changed = text_of("height:gain=4,bias=0.1");
    for (const double number : {-0.3, 0.0, 0.05, 0.2})
        EXPECT_EQ(colour_of(changed.display, number), colour_of(plain.display, 4 * (number + 0.1)))
            << number;
}

TEST_F(LegendTest, folds_and_places_without_a_number_have_colours_of_their_own) {
    const Display jacobian = text_of("jacobian").display, bound = text_of("bound").display;
    // 0.9, 0.05 and 0.1: 229.5, 12.75 and 25.5 steps, of which a device stores one that is less than one away.
    const auto red = [](const std::array<int, 3>& seen) {
        const std::array<double, 3> steps{229.5, 12.75, 25.5};
        bool is = true;
        for (std::size_t c = 0; c < 3; ++c)
            is = is && std::abs(seen[c] - steps[c]) < 1;
        return is;
    };
    EXPECT_TRUE(red(colour_of(jacobian, -0.001)));
    EXPECT_TRUE(red(colour_of(text_of("jacobian:gain=4").display, -0.001)));
    EXPECT_TRUE(red(colour_of(bound, 0.2, 2)));
    EXPECT_FALSE(red(colour_of(bound, 0.2)));
    for (const Display& display : {jacobian, bound, text_of("slope").display})
        EXPECT_EQ(colour_of(display, 0.5, 0), (std::array<int, 3>{33, 36, 43})) << "nothing";
    EXPECT_EQ(colour_of(bound, std::nan("")), (std::array<int, 3>{255, 0, 255}));
}

TEST_F(LegendTest, says_name_unit_settings_numbers_and_time) {
    using testing::ElementsAre;
    const auto read = [](const LegendText& text, int width) {
        ShownPicture picture = blank(width, width * 9 / 16);
        const Legend legend = make_legend(text, width, picture.height);
        lay_over(picture, legend);
        return read_words(picture, legend);
    };
    LegendText slope = text_of("slope:cascade=1,gain=4");
    slope.cascade = 1;
    for (const int width : {640, 1280})
        EXPECT_THAT(read(slope, width),
                    ElementsAre("slope: x red, y green", "cascade 1 of 3, gain 4", "-0.25", "0",
                                "0.25", "t = 100.000 s"));
    EXPECT_THAT(read(text_of("jacobian"), 640),
                ElementsAre("jacobian", "all 3 cascades", "0", "1", "2", "folds", "t = 100.000 s"));
    EXPECT_THAT(read(text_of("density"), 640),
                ElementsAre("density, px a cell", "0.1", "10", "1000", "t = 100.000 s"));
    EXPECT_THAT(
        read(text_of("height:bias=0.1,flip=on"), 640),
        ElementsAre("height, m", "bias 0.1, flipped", "1.9", "-0.1", "-2.1", "t = 100.000 s"));
    LegendText brief = text_of("h0:channel=phase");
    brief.brief = true;
    EXPECT_THAT(read(brief, 320), ElementsAre("-3.14", "3.14 rad"));
    brief = text_of("h0", 0.2);
    brief.flat = true;
    brief.area = {70, 0, 180, 180};
    brief.across = "kx to 1 rad/m east";
    brief.up = "ky to 1 rad/m north";
    EXPECT_THAT(read(brief, 320),
                ElementsAre("kx to 1 rad/m east", "ky to 1 rad/m north", "h0 magnitude, m",
                            "all 3 cascades", "2.0e-07", "2.0e-04", "0.2", "t = 100.000 s"));
}

TEST_F(LegendTest, there_is_none_in_small_pictures_of_the_picture_itself_and_where_it_is_off) {
    EXPECT_FALSE(make_legend(text_of("slope"), 200, 112).boxes.empty());
    EXPECT_TRUE(make_legend(text_of("slope"), 199, 112).boxes.empty());
    EXPECT_TRUE(make_legend(text_of("slope:legend=off"), 640, 360).boxes.empty());
    EXPECT_TRUE(make_legend(text_of("final"), 640, 360).boxes.empty());
}

} // namespace
} // namespace seaway::client
