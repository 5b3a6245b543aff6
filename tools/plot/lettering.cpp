// SPDX-License-Identifier: Apache-2.0
#include "tools/plot/lettering.h"

#include <array>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <string>

namespace seaway::plot {

namespace {

/// A glyph is drawn with "M x y" (lift the pen and go), "L x y" (line), "O cx cy rx ry from to"
/// (arc between two angles in degrees, anticlockwise if they rise; joined to the line before it).
/// Base line 0, lower-case height 7, capitals 10, descenders -3.
struct Glyph {
    char32_t code;
    double width;
    const char* path;
};

constexpr std::array glyphs{
    Glyph{U' ', 2.6, ""},
    Glyph{U'!', 0, "M 0 10 L 0 3 M 0 0 L 0 .1"},
    Glyph{U'"', 2, "M 0 10 L 0 7.5 M 2 10 L 2 7.5"},
    Glyph{U'#', 6, "M 1.2 0 L 2.6 10 M 3.8 0 L 5.2 10 M 0 3.2 L 6 3.2 M .4 6.8 L 6.4 6.8"},
    Glyph{U'$', 6, "O 3 7.2 2.6 1.9 30 270 O 3 2.8 2.8 2.5 90 -150 M 3 -1.2 L 3 11"},
    Glyph{U'%', 8, "O 1.8 7.8 1.8 2.2 0 360 O 6.2 2.2 1.8 2.2 0 360 M 1.4 0 L 6.6 10"},
    Glyph{U'&', 7, "M 7 0 L 1.6 6.4 O 2.9 8 1.9 2 220 -50 L .7 4 O 2.8 2.4 2.8 2.4 140 360"},
    Glyph{U'\'', 0, "M 0 10 L 0 7.5"},
    Glyph{U'(', 2.4, "O 5 4 5 7 125 235"},
    Glyph{U')', 2.4, "O -2.6 4 5 7 55 -55"},
    Glyph{U'*', 4, "M 2 10 L 2 5.6 M .1 8.9 L 3.9 6.7 M .1 6.7 L 3.9 8.9"},
    Glyph{U'+', 5.6, "M 2.8 1.4 L 2.8 7 M 0 4.2 L 5.6 4.2"},
    Glyph{U',', .7, "M .7 .2 L 0 -1.8"},
    Glyph{U'-', 3.2, "M 0 3.8 L 3.2 3.8"},
    Glyph{U'.', 0, "M 0 0 L 0 .1"},
    Glyph{U'/', 4, "M 0 -1 L 4 10.6"},
    Glyph{U'0', 6, "O 3 6.6 3 3.4 0 180 L 0 3.4 O 3 3.4 3 3.4 180 360 L 6 6.6"},
    Glyph{U'1', 4, "M .8 8 L 3.4 10 L 3.4 0"},
    Glyph{U'2', 6, "O 3 7.1 2.9 2.9 165 -35 L 0 0 L 6 0"},
    Glyph{U'3', 6, "O 2.9 7.6 2.5 2.4 150 -90 O 2.9 2.6 3 2.6 90 -150"},
    Glyph{U'4', 6.2, "M 4.6 0 L 4.6 10 L 0 2.9 L 6.2 2.9"},
    Glyph{U'5', 6, "M 5.4 10 L 1 10 L .6 5.4 O 2.9 3.2 3.1 3.2 128 -145"},
    Glyph{U'6', 6, "O 3 3.1 3 3.1 0 360 M 0 3.1 L 0 4.6 O 4.6 4.6 4.6 5.4 180 82"},
    Glyph{U'7', 5.8, "M 0 10 L 5.8 10 L 1.9 0"},
    Glyph{U'8', 6, "O 3 7.6 2.5 2.4 -90 270 O 3 2.6 3 2.6 90 450"},
    Glyph{U'9', 6, "O 3 6.9 3 3.1 0 360 M 6 6.9 L 6 5.4 O 1.4 5.4 4.6 5.4 0 -98"},
    Glyph{U':', 0, "M 0 0 L 0 .1 M 0 6 L 0 6.1"},
    Glyph{U';', .7, "M .7 .2 L 0 -1.8 M .5 6 L .5 6.1"},
    Glyph{U'<', 5, "M 5 7 L 0 4.2 L 5 1.4"},
    Glyph{U'=', 5.6, "M 0 5.6 L 5.6 5.6 M 0 2.8 L 5.6 2.8"},
    Glyph{U'>', 5, "M 0 7 L 5 4.2 L 0 1.4"},
    Glyph{U'?', 5, "O 2.5 7.5 2.5 2.5 165 -60 L 2.5 3.4 L 2.5 3 M 2.5 0 L 2.5 .1"},
    Glyph{U'@', 8, "O 4 4 1.8 2.2 0 360 M 5.8 6 L 5.8 3 O 6.9 3 1.1 1.2 180 360 O 4 4 4 5 -10 305"},
    Glyph{U'A', 7, "M 0 0 L 3.5 10 L 7 0 M 1.2 3.4 L 5.8 3.4"},
    Glyph{U'B', 6,
          "M 0 0 L 0 10 L 3.2 10 O 3.2 7.6 2.4 2.4 90 -90 L 0 5.2 "
          "M 3.2 5.2 L 3.4 5.2 O 3.4 2.6 2.6 2.6 90 -90 L 0 0"},
    Glyph{U'C', 6.4, "O 3.6 6.4 3.6 3.6 40 180 L 0 3.6 O 3.6 3.6 3.6 3.6 180 320"},
    Glyph{U'D', 6.5, "M 0 0 L 0 10 L 2.5 10 O 2.5 6 4 4 90 0 L 6.5 4 O 2.5 4 4 4 0 -90 L 0 0"},
    Glyph{U'E', 5.4, "M 5.4 0 L 0 0 L 0 10 L 5.4 10 M 0 5.2 L 4.6 5.2"},
    Glyph{U'F', 5.2, "M 0 0 L 0 10 L 5.4 10 M 0 5.2 L 4.6 5.2"},
    Glyph{U'G', 7.2,
          "O 3.6 6.4 3.6 3.6 40 180 L 0 3.6 O 3.6 3.6 3.6 3.6 180 360 L 7.2 4.8 L 4 4.8"},
    Glyph{U'H', 6.5, "M 0 0 L 0 10 M 6.5 0 L 6.5 10 M 0 5.2 L 6.5 5.2"},
    Glyph{U'I', 0, "M 0 0 L 0 10"},
    Glyph{U'J', 4.4, "M 4.4 10 L 4.4 2.4 O 2.1 2.4 2.3 2.4 0 -165"},
    Glyph{U'K', 6, "M 0 0 L 0 10 M 5.8 10 L 0 3.9 M 2.1 6.1 L 6.2 0"},
    Glyph{U'L', 5, "M 0 10 L 0 0 L 5 0"},
    Glyph{U'M', 8, "M 0 0 L 0 10 L 4 3.4 L 8 10 L 8 0"},
    Glyph{U'N', 6.5, "M 0 0 L 0 10 L 6.5 0 L 6.5 10"},
    Glyph{U'O', 7, "O 3.5 6.4 3.5 3.6 0 180 L 0 3.6 O 3.5 3.6 3.5 3.6 180 360 L 7 6.4"},
    Glyph{U'P', 6, "M 0 0 L 0 10 L 3.3 10 O 3.3 7.3 2.7 2.7 90 -90 L 0 4.6"},
    Glyph{U'Q', 7,
          "O 3.5 6.4 3.5 3.6 0 180 L 0 3.6 O 3.5 3.6 3.5 3.6 180 360 L 7 6.4 M 4.5 2.6 L 7.2 -.6"},
    Glyph{U'R', 6.2, "M 0 0 L 0 10 L 3.3 10 O 3.3 7.3 2.7 2.7 90 -90 L 0 4.6 M 3 4.6 L 6.2 0"},
    Glyph{U'S', 6, "O 3 7.6 2.8 2.4 30 270 O 3 2.6 3 2.6 90 -150"},
    Glyph{U'T', 6.4, "M 3.2 0 L 3.2 10 M 0 10 L 6.4 10"},
    Glyph{U'U', 6.4, "M 0 10 L 0 3.2 O 3.2 3.2 3.2 3.2 180 360 L 6.4 10"},
    Glyph{U'V', 7, "M 0 10 L 3.5 0 L 7 10"},
    Glyph{U'W', 9.4, "M 0 10 L 2.4 0 L 4.7 8 L 7 0 L 9.4 10"},
    Glyph{U'X', 6.4, "M 0 0 L 6.4 10 M 0 10 L 6.4 0"},
    Glyph{U'Y', 6.6, "M 0 10 L 3.3 4.8 L 6.6 10 M 3.3 4.8 L 3.3 0"},
    Glyph{U'Z', 6, "M 0 10 L 6 10 L 0 0 L 6 0"},
    Glyph{U'[', 2, "M 2 11 L 0 11 L 0 -2 L 2 -2"},
    Glyph{U'\\', 4, "M 0 10.6 L 4 -1"},
    Glyph{U']', 2, "M 0 11 L 2 11 L 2 -2 L 0 -2"},
    Glyph{U'^', 5, "M 0 6.5 L 2.5 10 L 5 6.5"},
    Glyph{U'_', 5, "M 0 -1.6 L 5 -1.6"},
    Glyph{U'`', 1.4, "M 0 10 L 1.4 8.4"},
    Glyph{U'a', 5.4, "O 2.7 3.5 2.7 3.5 0 360 M 5.4 7 L 5.4 0"},
    Glyph{U'b', 5.4, "M 0 10 L 0 0 M 0 3.5 O 2.7 3.5 2.7 3.5 180 540"},
    Glyph{U'c', 4.8, "O 2.8 3.5 2.8 3.5 48 312"},
    Glyph{U'd', 5.4, "M 5.4 10 L 5.4 0 M 5.4 3.5 O 2.7 3.5 2.7 3.5 0 360"},
    Glyph{U'e', 5.4, "M 0 3.7 L 5.4 3.7 O 2.7 3.5 2.7 3.5 4 318"},
    Glyph{U'f', 3.3, "M 1.3 0 L 1.3 7.8 O 3.4 7.8 2.1 2.2 180 80 M 0 6.7 L 3.3 6.7"},
    Glyph{U'g', 5.4, "O 2.7 3.5 2.7 3.5 0 360 M 5.4 7 L 5.4 -.6 O 2.7 -.6 2.7 2.5 0 -155"},
    Glyph{U'h', 5, "M 0 10 L 0 0 M 0 4.4 O 2.5 4.4 2.5 2.6 180 0 L 5 0"},
    Glyph{U'i', 0, "M 0 0 L 0 7 M 0 9.7 L 0 9.8"},
    Glyph{U'j', 1.8, "M 1.8 7 L 1.8 -1 O 0 -1 1.8 2 0 -90 M 1.8 9.7 L 1.8 9.8"},
    Glyph{U'k', 4.7, "M 0 10 L 0 0 M 4.5 7 L 0 2.5 M 1.7 4.2 L 4.9 0"},
    Glyph{U'l', 0, "M 0 10 L 0 0"},
    Glyph{U'm', 8,
          "M 0 7 L 0 0 M 0 4.6 O 2 4.6 2 2.4 180 0 L 4 0 M 4 4.6 O 6 4.6 2 2.4 180 0 L 8 0"},
    Glyph{U'n', 5, "M 0 7 L 0 0 M 0 4.4 O 2.5 4.4 2.5 2.6 180 0 L 5 0"},
    Glyph{U'o', 5.6, "O 2.8 3.5 2.8 3.5 0 360"},
    Glyph{U'p', 5.4, "M 0 7 L 0 -3 M 0 3.5 O 2.7 3.5 2.7 3.5 180 540"},
    Glyph{U'q', 5.4, "M 5.4 7 L 5.4 -3 M 5.4 3.5 O 2.7 3.5 2.7 3.5 0 360"},
    Glyph{U'r', 3.1, "M 0 7 L 0 0 M 0 4.2 O 2.8 4.2 2.8 2.8 180 75"},
    Glyph{U's', 4.4, "O 2.2 5.3 2 1.7 30 270 O 2.2 1.8 2.2 1.8 90 -155"},
    Glyph{U't', 3.3, "M 1.3 9.3 L 1.3 2.2 O 3.3 2.2 2 2.2 180 285 M 0 6.8 L 3.3 6.8"},
    Glyph{U'u', 5, "M 0 7 L 0 2.6 O 2.5 2.6 2.5 2.6 180 360 M 5 7 L 5 0"},
    Glyph{U'v', 5.2, "M 0 7 L 2.6 0 L 5.2 7"},
    Glyph{U'w', 7.6, "M 0 7 L 1.9 0 L 3.8 6 L 5.7 0 L 7.6 7"},
    Glyph{U'x', 4.8, "M 0 0 L 4.8 7 M 0 7 L 4.8 0"},
    Glyph{U'y', 5.2, "M 0 7 L 2.7 .2 M 5.2 7 L 1.7 -3 L .5 -3"},
    Glyph{U'z', 4.6, "M 0 7 L 4.6 7 L 0 0 L 4.6 0"},
    Glyph{U'{', 2.4, "M 2.4 11 L 1.2 10 L 1.2 5.5 L 0 4.5 L 1.2 3.5 L 1.2 -1 L 2.4 -2"},
    Glyph{U'|', 0, "M 0 -2 L 0 11"},
    Glyph{U'}', 2.4, "M 0 11 L 1.2 10 L 1.2 5.5 L 2.4 4.5 L 1.2 3.5 L 1.2 -1 L 0 -2"},
    Glyph{U'~', 5.6, "O 1.4 3.8 1.4 1.2 180 0 O 4.2 3.8 1.4 1.2 180 360"},
    Glyph{U'°', 2.6, "O 1.3 8.6 1.3 1.4 0 360"},
    Glyph{U'±', 5.6, "M 2.8 2.4 L 2.8 8 M 0 5.2 L 5.6 5.2 M 0 .4 L 5.6 .4"},
    Glyph{U'·', 0, "M 0 4 L 0 4.1"},
    Glyph{U'×', 4.4, "M 0 1.8 L 4.4 6.2 M 0 6.2 L 4.4 1.8"},
    Glyph{U'Δ', 7.4, "M 0 0 L 3.7 10 L 7.4 0 L 0 0"},
    Glyph{U'θ', 5.2, "O 2.6 5 2.6 5 0 360 M 0 5 L 5.2 5"},
    Glyph{U'λ', 5.6, "M .2 10 L 1.2 10 L 5.6 0 M 3 5.8 L 0 0"},
    Glyph{U'μ', 5, "M 0 7 L 0 -3 M 0 2.6 O 2.5 2.6 2.5 2.6 180 360 M 5 7 L 5 0"},
    Glyph{U'σ', 5.8, "O 2.7 3.3 2.7 3.3 80 440 M 3.2 6.6 L 6 6.6"},
    Glyph{U'ω', 7.4, "M 1.2 7 O 2.1 3 2.1 3 150 340 M 3.7 5 L 3.7 3 M 3.7 3 O 5.4 3 2.0 3 205 390"},
    Glyph{U'–', 5, "M 0 3.8 L 5 3.8"},
    Glyph{U'—', 9, "M 0 3.8 L 9 3.8"},
};
constexpr Glyph unknown{U'\0', 5, "M 0 0 L 0 10 L 5 10 L 5 0 L 0 0"};
constexpr double gap_between = 2.4;

const Glyph& glyph_of(char32_t code) {
    for (const Glyph& glyph : glyphs)
        if (glyph.code == code)
            return glyph;
    return unknown;
}

/// The next code point of UTF-8; a broken sequence counts as one unknown character.
char32_t next_code(std::string_view text, std::size_t& at) {
    const auto byte = [&](std::size_t i) {
        return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u;
    };
    const unsigned lead = byte(at++);
    if (lead < 0x80)
        return lead;
    const int more = lead >= 0xf0 ? 3 : lead >= 0xe0 ? 2 : 1;
    char32_t code = lead & (0x3fu >> more);
    for (int i = 0; i < more; ++i) {
        if ((byte(at) & 0xc0u) != 0x80u)
            return U'\0';
        code = code << 6 | (byte(at++) & 0x3fu);
    }
    return code;
}

struct Place {
    double x;
    double y;
    double scale;
};

void draw(const Glyph& glyph, const Place& place, std::vector<std::vector<Point>>& strokes) {
    const char* at = glyph.path;
    const auto number = [&at] {
        char* end = nullptr;
        const double value = std::strtod(at, &end);
        at = end;
        return value;
    };
    bool lifted = true;
    const auto go = [&](double x, double y) {
        if (lifted)
            strokes.emplace_back();
        lifted = false;
        strokes.back().push_back({place.x + place.scale * x, place.y + place.scale * y});
    };
    while (*at != '\0') {
        const char command = *at++;
        if (command == 'M' || command == 'L') {
            lifted |= command == 'M';
            const double x = number();
            go(x, number());
        } else if (command == 'O') {
            const double cx = number(), cy = number(), rx = number(), ry = number();
            const double from = number(), to = number();
            const int steps = 4 + static_cast<int>(std::abs(to - from) / 12.0);
            for (int i = 0; i <= steps; ++i) {
                const double angle = (from + (to - from) * i / steps) * std::numbers::pi / 180.0;
                go(cx + rx * std::cos(angle), cy + ry * std::sin(angle));
            }
        }
        // A full arc that follows another one starts a stroke of its own.
        while (*at == ' ')
            ++at;
        if (*at == 'O' && command == 'O' && glyph.code == U'%')
            lifted = true;
    }
}

} // namespace

Lettering letter(std::string_view text) {
    Lettering lettering;
    Place place{0, 0, 1.0};
    bool shifted = false;
    for (std::size_t at = 0; at < text.size();) {
        if (!shifted && at + 1 < text.size() && text[at + 1] == '{' &&
            (text[at] == '^' || text[at] == '_')) {
            place.y = text[at] == '^' ? 5.0 : -2.6;
            place.scale = 0.72;
            shifted = true;
            at += 2;
            continue;
        }
        if (shifted && text[at] == '}') {
            place.y = 0;
            place.scale = 1.0;
            shifted = false;
            ++at;
            continue;
        }
        const Glyph& glyph = glyph_of(next_code(text, at));
        draw(glyph, place, lettering.strokes);
        place.x += place.scale * (glyph.width + gap_between);
    }
    lettering.width = std::max(0.0, place.x - gap_between);
    return lettering;
}

} // namespace seaway::plot
