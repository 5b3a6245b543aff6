// SPDX-License-Identifier: Apache-2.0
#include "client/view/debug/legend.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "client/view/debug/small_font.h"

namespace seaway::client {

namespace {

constexpr int bar_parts = 65;                           ///< odd: one has the colour of the middle
constexpr int bar_letters = 30, brief_bar_letters = 18; ///< width of a bar in letters
constexpr int line_dots = letter_rows + 3;
const glm::dvec3 ink(0.95, 0.95, 0.92), paper(0.06, 0.07, 0.09);
constexpr double paper_opacity = 0.8;
constexpr std::array<const char*, 3> colour_names{"red", "green", "blue"};

/// Pixels a dot: letters stay as large beside the picture as it grows.
int dot_pixels(int width) {
    return std::max(1, width / 640);
}

/// Draws from the top down.
class Writer {
  public:
    Writer(Legend& out, int dot) : out_(out), dot_(dot) {}

    void box(int left, int top, int width, int height, const glm::dvec3& colour,
             double opacity = 1) {
        out_.boxes.push_back({left, top, width, height, colour, opacity});
    }
    /// Runs of dots of a column are one box.
    void text(int left, int top, const std::string& text) {
        out_.words.push_back({left, top, dot_, text});
        for (std::size_t i = 0; i < text.size(); ++i)
            for (int column = 0; column < letter_columns; ++column)
                for (int row = 0; row < letter_rows;) {
                    int end = row;
                    while (end < letter_rows && letter_dot(text[i], column, end))
                        ++end;
                    if (end > row)
                        box(left + dot_ * (letter_advance * static_cast<int>(i) + column),
                            top + dot_ * row, dot_, dot_ * (end - row), ink);
                    row = std::max(end, row + 1);
                }
    }
    void bar(const LegendBar& bar) {
        for (int i = 0; i < bar_parts; ++i) {
            const int from = bar.width * i / bar_parts, to = bar.width * (i + 1) / bar_parts;
            // The first and the last part have the colours of the ends.
            const double place = static_cast<double>(i) / (bar_parts - 1);
            glm::dvec3 colour(0.0);
            if (bar.channel < 0)
                colour = bar.scale.colour(place);
            else
                colour[bar.channel] = place;
            box(bar.left + from, bar.top, to - from, bar.height, colour);
        }
        out_.bars.push_back(bar);
    }

  private:
    Legend& out_;
    int dot_;
};

/// Three digits that count, without an exponent where that is short.
std::string number_text(double number) {
    const double size = std::abs(number);
    if (size == 0 || size < 1e-3 || size >= 1e5)
        return size == 0 ? "0" : fmt::format("{:.1e}", number);
    const int decimals = std::clamp(2 - static_cast<int>(std::floor(std::log10(size))), 0, 5);
    std::string text = fmt::format("{:.{}f}", number, decimals);
    if (decimals > 0)
        text.erase(text.find_last_not_of('0') + 1);
    if (text.back() == '.')
        text.pop_back();
    return text;
}

/// "slope: x red, y green", "height, m".
std::string title_of(const LegendText& text, const ShownChannel& shown) {
    const DebugViewInfo& row = info(text.choice.view);
    const auto channel = static_cast<std::size_t>(std::max(shown.channel, 0));
    std::string title(row.name);
    if (shown.channel >= 0 && row.channel_count() > 1)
        title += " " + std::string(row.channels[channel].name);
    if (!row.channels[channel].unit.empty())
        title += ", " + std::string(row.channels[channel].unit);
    for (std::size_t i = 0; shown.channel < 0 && i < row.channels.size(); ++i)
        if (!row.channels[i].name.empty() && row.channels[i].name != colour_names[i])
            title +=
                fmt::format("{} {} {}", i == 0 ? ":" : ",", row.channels[i].name, colour_names[i]);
    return title;
}

/// What is set; empty: nothing to say.
std::string settings_of(const LegendText& text) {
    const DebugViewInfo& row = info(text.choice.view);
    const Colouring& colouring = text.choice.colouring;
    std::string out;
    const auto add = [&](const std::string& part) { out += (out.empty() ? "" : ", ") + part; };
    if (row.takes(DebugKey::cascade))
        add(text.cascade < 0 ? fmt::format("all {} cascades", text.cascades)
                             : fmt::format("cascade {} of {}", text.cascade, text.cascades));
    if (row.takes(DebugKey::mip))
        add(fmt::format("mip {}", text.choice.mip));
    if (colouring.gain != 1)
        add(fmt::format("gain {:g}", colouring.gain));
    if (colouring.bias != 0)
        add(fmt::format("bias {:g}", colouring.bias));
    if (colouring.flip)
        add("flipped");
    return out;
}

struct Lines {
    std::vector<std::string> above, below; ///< the bars
    std::string numbers[3];                ///< at the bar's ends and its middle
};

Lines lines_of(const LegendText& text, const ShownChannel& shown) {
    Lines lines;
    for (int i = 0; i < 3; ++i)
        lines.numbers[i] = number_text(shown.scale.number(0.5 * i));
    if (text.brief) {
        const DebugViewInfo& row = info(text.choice.view);
        const auto channel = static_cast<std::size_t>(std::max(shown.channel, 0));
        if (!row.channels[channel].unit.empty())
            lines.numbers[2] += " " + std::string(row.channels[channel].unit);
        return lines;
    }
    lines.above.push_back(title_of(text, shown));
    if (const std::string settings = settings_of(text); !settings.empty())
        lines.above.push_back(settings);
    if (shown.scale.spacing == Spacing::repeated)
        lines.below.push_back("colours repeat");
    lines.below.insert(lines.below.end(), text.notes.begin(), text.notes.end());
    lines.below.push_back(fmt::format("t = {:.3f} s", text.time_s));
    return lines;
}

bool shows_folds(const LegendText& text) {
    return info(text.choice.view).folds || text.choice.view == DebugView::bound;
}

/// `box`: of the bar, in the lower left corner.
void write_axes(Writer& writer, const LegendText& text, int dot, const glm::ivec2& box) {
    const FlatArea& area = text.area;
    const int line = dot * letter_rows, gap = 2 * dot;
    const auto put = [&](int wanted_left, int top, const std::string& words) {
        const int left = std::max(wanted_left, gap);
        writer.box(left - dot, top - dot, dot * (text_columns(words) + 2), line + dot, paper,
                   paper_opacity);
        writer.text(left, top, words);
    };
    // Away from the lower left corner, where the bar stands, and beside a narrow one from the upper left, where the label does.
    const int right = area.left + area.width - gap;
    const int left = right - dot * text_columns(text.across), bottom = area.top + area.height;
    const int lifted = left - gap < box.x ? box.y + gap : 0, lowered = text.brief ? line + gap : 0;
    put(left, bottom - line - gap - lifted, text.across);
    put(right - dot * text_columns(text.up), area.top + gap + lowered, text.up);
}

} // namespace

Legend make_legend(const LegendText& text, int width, int height) {
    Legend legend;
    if (width < legend_width_min || !text.choice.legend ||
        info(text.choice.view).source == DebugSource::light)
        return legend;
    const int dot = dot_pixels(width);
    const ShownChannel shown = shown_channel(text.display);
    const Lines lines = lines_of(text, shown);
    const int bars = shown.channel < 0 ? info(text.choice.view).channel_count() : 1;
    const int line = dot * line_dots, margin = (text.brief ? 2 : 4) * dot;
    const int across = text.brief ? brief_bar_letters : bar_letters;
    const int bar_height = dot * (bars > 1 ? 4 : 8) / (text.brief ? 2 : 1);
    const int bar_width = dot * letter_advance * across;
    auto letters = static_cast<std::size_t>(across);
    for (const std::vector<std::string>* some : {&lines.above, &lines.below})
        for (const std::string& words : *some)
            letters = std::max(letters, words.size());
    const int folds = shows_folds(text) && !text.brief ? 1 : 0;
    const auto count = static_cast<int>(lines.above.size() + lines.below.size()) + 1 + folds;
    const int box_width = dot * letter_advance * static_cast<int>(letters) + 2 * margin;
    const int box_height = line * count + bars * (bar_height + dot) + 2 * dot + 2 * margin;

    Writer writer(legend, dot);
    if (text.flat)
        write_axes(writer, text, dot, {margin + box_width, margin + box_height});
    int top = std::max(height - box_height - margin, 0);
    const int left = 2 * margin;
    writer.box(margin, top, box_width, box_height, paper, paper_opacity);
    top += margin;
    for (const std::string& words : lines.above) {
        writer.text(left, top, words);
        top += line;
    }
    for (int i = 0; i < bars; ++i) {
        writer.bar({left, top, bar_width, bar_height, shown.scale, shown.channel < 0 ? i : -1});
        top += bar_height + dot;
    }
    top += 2 * dot;
    const int ends[] = {0, bar_width / 2 - dot * text_columns(lines.numbers[1]) / 2,
                        bar_width - dot * text_columns(lines.numbers[2])};
    for (int i = 0; i < 3; ++i)
        if (i != 1 ||
            ends[1] + dot * text_columns(lines.numbers[1]) + dot * letter_advance < ends[2])
            writer.text(left + ends[i], top, lines.numbers[i]);
    top += line;
    if (folds > 0) {
        writer.box(left, top, 2 * letter_advance * dot, dot * (letter_rows - 1), fold_colour);
        writer.text(left + 3 * letter_advance * dot, top, "folds");
        top += line;
    }
    for (const std::string& words : lines.below) {
        writer.text(left, top, words);
        top += line;
    }
    return legend;
}

Legend make_label(const std::string& text, int width) {
    Legend legend;
    const int dot = dot_pixels(width);
    Writer writer(legend, dot);
    writer.box(0, 0, dot * (text_columns(text) + 4), dot * (letter_rows + 3), paper, paper_opacity);
    writer.text(2 * dot, 2 * dot, text);
    return legend;
}

void lay_over(ShownPicture& picture, const Legend& legend) {
    for (const LegendBox& box : legend.boxes) {
        const int right = std::min(box.left + box.width, picture.width);
        const int bottom = std::min(box.top + box.height, picture.height);
        for (int y = std::max(box.top, 0); y < bottom; ++y)
            for (int x = std::max(box.left, 0); x < right; ++x)
                for (int c = 0; c < 3; ++c) {
                    std::uint8_t& byte =
                        picture.rgba[4 * (static_cast<std::size_t>(y) *
                                              static_cast<std::size_t>(picture.width) +
                                          static_cast<std::size_t>(x)) +
                                     static_cast<std::size_t>(c)];
                    const double under = byte, over = 255 * box.colour[c];
                    byte = static_cast<std::uint8_t>(
                        std::lround(under + box.opacity * (over - under)));
                }
    }
}

} // namespace seaway::client
