// SPDX-License-Identifier: Apache-2.0
// A raster picture: filled areas, anti-aliased lines, discs, lettering; written as PNG.
//
// Coordinates are pixels, x right, y down, the top left corner of the picture is (0, 0); fractions
// of a pixel count. Colours are sRGB and blend as such. Lettering is drawn as strokes, so it has
// any size and needs no font file: printable ASCII, Greek Δ θ λ μ σ ω, and ° · × ± – —; other
// characters show as a box.
//
// One canvas belongs to one thread. 1200 x 700 pixels take 2.5 MB; a line about 50 ns a pixel near
// it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace seaway::plot {

struct Point {
    double x;
    double y;
};

struct Rect {
    double left;
    double top;
    double right;
    double bottom;

    double width() const { return right - left; }
    double height() const { return bottom - top; }
    bool contains(Point p) const {
        return p.x >= left && p.x <= right && p.y >= top && p.y <= bottom;
    }
};

struct Color {
    std::uint8_t red = 0;
    std::uint8_t green = 0;
    std::uint8_t blue = 0;
    double opacity = 1.0; ///< 0 .. 1

    constexpr Color faded(double share) const { return {red, green, blue, opacity * share}; }
};

inline constexpr Color white{255, 255, 255};
inline constexpr Color black{0, 0, 0};
inline constexpr Color ink{38, 44, 54}; ///< text and axes
inline constexpr Color grey{120, 128, 138};

/// Colours that remain distinct to colour-blind readers (Okabe and Ito 2008); wraps around.
Color series_color(std::size_t index);
/// White, through sea blue, to almost black; share 0 .. 1.
Color sea_color(double share);

struct Stroke {
    Color color = ink;
    double width_px = 1.0;
    double dash_px = 0.0; ///< length of dashes and gaps; 0: solid
};

enum class Align : std::uint8_t { left, centre, right };

struct TextStyle {
    Color color = ink;
    double size_px = 9.0; ///< height of a capital letter
    Align align = Align::left;
    bool bold = false;
    bool upwards = false; ///< turned by a quarter, reading from bottom to top
};

class Canvas {
  public:
    Canvas(int width_px, int height_px, Color background = white);

    int width() const { return width_; }
    int height() const { return height_; }
    Rect frame() const { return {0, 0, static_cast<double>(width_), static_cast<double>(height_)}; }

    /// Nothing is painted outside; frame() takes the limit away.
    void set_clip(Rect clip) { clip_ = clip; }

    void fill(Rect area, Color color);
    /// Each pixel whose centre lies in `area` gets color(x, y) of its centre.
    template <class F>
    void paint(Rect area, const F& color) {
        for (int y = std::max(0, static_cast<int>(area.top)); y < height_ && y < area.bottom; ++y)
            for (int x = std::max(0, static_cast<int>(area.left)); x < width_ && x < area.right;
                 ++x) {
                const Point centre{x + 0.5, y + 0.5};
                if (area.contains(centre) && clip_.contains(centre))
                    blend(x, y, color(centre.x, centre.y), 1.0);
            }
    }
    /// Round caps and joints. Points that are not finite break the line.
    void line(std::span<const Point> points, const Stroke& stroke);
    void line(Point from, Point to, const Stroke& stroke);
    void disc(Point centre, double radius_px, Color color);
    void circle(Point centre, double radius_px, const Stroke& stroke);

    /// `at` is on the base line. "^{...}" raises and "_{...}" lowers what is in the braces.
    void text(Point at, std::string_view text, const TextStyle& style = {});
    static double text_width(std::string_view text, double size_px);

    /// 8-bit RGB.
    Result<void> write_png(const std::string& path) const;

    Color pixel(int x, int y) const;

  private:
    struct Mask;
    void blend(int x, int y, Color color, double coverage);
    void blend(const Mask& mask, Color color);
    Mask mask_for(std::span<const std::vector<Point>> strokes, double width_px) const;

    int width_;
    int height_;
    std::vector<std::uint8_t> rgb_; ///< [y][x][3]
    Rect clip_;
};

} // namespace seaway::plot
