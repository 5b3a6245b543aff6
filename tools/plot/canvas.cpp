// SPDX-License-Identifier: Apache-2.0
#include "tools/plot/canvas.h"

#include <array>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <png.h>

#include "base/whole_file.h"
#include "tools/plot/lettering.h"

namespace seaway::plot {

namespace {

double distance_to_segment(Point p, Point a, Point b) {
    const double dx = b.x - a.x;
    const double dy = b.y - a.y;
    const double length2 = dx * dx + dy * dy;
    const double along = length2 > 0 ? ((p.x - a.x) * dx + (p.y - a.y) * dy) / length2 : 0.0;
    const double t = std::clamp(along, 0.0, 1.0);
    return std::hypot(p.x - a.x - t * dx, p.y - a.y - t * dy);
}

bool finite(Point p) {
    return std::isfinite(p.x) && std::isfinite(p.y);
}

/// Cuts a line into dashes and gaps of the same length.
std::vector<std::vector<Point>> dashes(std::span<const Point> points, double dash_px) {
    std::vector<std::vector<Point>> strokes;
    bool down = true;
    double left = dash_px;
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
        Point from = points[i];
        const Point to = points[i + 1];
        if (down)
            strokes.push_back({from});
        double rest = std::hypot(to.x - from.x, to.y - from.y);
        while (rest > left) {
            const double t = left / rest;
            from = {from.x + t * (to.x - from.x), from.y + t * (to.y - from.y)};
            rest -= left;
            if (down)
                strokes.back().push_back(from);
            else
                strokes.push_back({from});
            down = !down;
            left = dash_px;
        }
        left -= rest;
        if (down)
            strokes.back().push_back(to);
    }
    return strokes;
}

} // namespace

/// Coverage 0 .. 1 of a rectangle of pixels.
struct Canvas::Mask {
    int left = 0, top = 0, width = 0, height = 0;
    std::vector<float> coverage;
};

Color series_color(std::size_t index) {
    constexpr std::array<Color, 7> colors{{{0, 114, 178},
                                           {213, 94, 0},
                                           {0, 158, 115},
                                           {204, 121, 167},
                                           {230, 159, 0},
                                           {86, 180, 233},
                                           {90, 90, 90}}};
    return colors[index % colors.size()];
}

Color sea_color(double share) {
    constexpr std::array<Color, 7> stops{{{255, 255, 255},
                                          {215, 238, 246},
                                          {144, 205, 228},
                                          {64, 156, 203},
                                          {30, 100, 163},
                                          {18, 56, 114},
                                          {9, 25, 62}}};
    const double place = std::clamp(share, 0.0, 1.0) * (stops.size() - 1);
    const auto i = std::min(static_cast<std::size_t>(place), stops.size() - 2);
    const double t = place - static_cast<double>(i);
    const auto mix = [t](std::uint8_t a, std::uint8_t b) {
        return static_cast<std::uint8_t>(std::lround(a + t * (b - a)));
    };
    return {mix(stops[i].red, stops[i + 1].red), mix(stops[i].green, stops[i + 1].green),
            mix(stops[i].blue, stops[i + 1].blue)};
}

Canvas::Canvas(int width_px, int height_px, Color background)
    : width_(width_px), height_(height_px),
      rgb_(static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px) * 3),
      clip_(frame()) {
    for (std::size_t i = 0; i < rgb_.size(); i += 3) {
        rgb_[i] = background.red;
        rgb_[i + 1] = background.green;
        rgb_[i + 2] = background.blue;
    }
}

void Canvas::blend(int x, int y, Color color, double coverage) {
    const double a = color.opacity * coverage;
    std::uint8_t* out = &rgb_[3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                                   static_cast<std::size_t>(x))];
    const std::array<std::uint8_t, 3> source{color.red, color.green, color.blue};
    for (std::size_t i = 0; i < 3; ++i)
        out[i] = static_cast<std::uint8_t>(std::lround(out[i] + a * (source[i] - out[i])));
}

void Canvas::blend(const Mask& mask, Color color) {
    for (int y = 0; y < mask.height; ++y)
        for (int x = 0; x < mask.width; ++x) {
            const float c = mask.coverage[static_cast<std::size_t>(y * mask.width + x)];
            if (c > 0 && clip_.contains({mask.left + x + 0.5, mask.top + y + 0.5}))
                blend(mask.left + x, mask.top + y, color, c);
        }
}

Canvas::Mask Canvas::mask_for(std::span<const std::vector<Point>> strokes, double width_px) const {
    const double reach = 0.5 * width_px + 1.0;
    Rect box{1e9, 1e9, -1e9, -1e9};
    for (const std::vector<Point>& stroke : strokes)
        for (const Point p : stroke)
            box = {std::min(box.left, p.x), std::min(box.top, p.y), std::max(box.right, p.x),
                   std::max(box.bottom, p.y)};
    Mask mask;
    const auto pixel = [](double v, int end) {
        return static_cast<int>(std::clamp(std::floor(v), 0.0, static_cast<double>(end)));
    };
    mask.left = pixel(box.left - reach, width_);
    mask.top = pixel(box.top - reach, height_);
    mask.width = std::max(0, pixel(box.right + reach + 1, width_) - mask.left);
    mask.height = std::max(0, pixel(box.bottom + reach + 1, height_) - mask.top);
    mask.coverage.assign(static_cast<std::size_t>(mask.width * mask.height), 0.0f);
    for (const std::vector<Point>& stroke : strokes)
        for (std::size_t i = 0; i < stroke.size(); ++i) {
            const Point a = stroke[i];
            const Point b = stroke[std::min(i + 1, stroke.size() - 1)];
            if (i > 0 && i + 1 == stroke.size())
                break;
            const int x0 = pixel(std::min(a.x, b.x) - reach, width_);
            const int x1 = pixel(std::max(a.x, b.x) + reach + 1, width_);
            const int y0 = pixel(std::min(a.y, b.y) - reach, height_);
            const int y1 = pixel(std::max(a.y, b.y) + reach + 1, height_);
            for (int y = y0; y < y1; ++y)
                for (int x = x0; x < x1; ++x) {
                    const double d = distance_to_segment({x + 0.5, y + 0.5}, a, b);
                    const auto c = static_cast<float>(
                        std::clamp(0.5 * width_px + 0.5 - d, 0.0, 1.0) * std::min(1.0, width_px));
                    float& out = mask.coverage[static_cast<std::size_t>(
                        (y - mask.top) * mask.width + x - mask.left)];
                    out = std::max(out, c);
                }
        }
    return mask;
}

void Canvas::fill(Rect area, Color color) {
    const auto overlap = [](int i, double lo, double hi) {
        return std::max(0.0, std::min(hi, i + 1.0) - std::max(lo, static_cast<double>(i)));
    };
    const Rect r{std::max(area.left, clip_.left), std::max(area.top, clip_.top),
                 std::min(area.right, clip_.right), std::min(area.bottom, clip_.bottom)};
    for (int y = std::max(0, static_cast<int>(r.top)); y < height_ && y < r.bottom; ++y)
        for (int x = std::max(0, static_cast<int>(r.left)); x < width_ && x < r.right; ++x)
            blend(x, y, color, overlap(x, r.left, r.right) * overlap(y, r.top, r.bottom));
}

void Canvas::line(std::span<const Point> points, const Stroke& stroke) {
    std::vector<std::vector<Point>> strokes(1);
    for (const Point p : points) {
        if (finite(p))
            strokes.back().push_back(p);
        else if (!strokes.back().empty())
            strokes.emplace_back();
    }
    if (stroke.dash_px > 0) {
        std::vector<std::vector<Point>> dashed;
        for (const std::vector<Point>& whole : strokes)
            for (std::vector<Point>& dash : dashes(whole, stroke.dash_px))
                dashed.push_back(std::move(dash));
        strokes = std::move(dashed);
    }
    blend(mask_for(strokes, stroke.width_px), stroke.color);
}

void Canvas::line(Point from, Point to, const Stroke& stroke) {
    const std::array<Point, 2> points{from, to};
    line(points, stroke);
}

void Canvas::disc(Point centre, double radius_px, Color color) {
    const std::array<Point, 1> point{centre};
    line(point, {color, 2.0 * radius_px});
}

void Canvas::circle(Point centre, double radius_px, const Stroke& stroke) {
    std::vector<Point> points;
    const int steps = 24 + static_cast<int>(radius_px);
    for (int i = 0; i <= steps; ++i) {
        const double angle = 2.0 * std::numbers::pi * i / steps;
        points.push_back(
            {centre.x + radius_px * std::cos(angle), centre.y + radius_px * std::sin(angle)});
    }
    line(points, stroke);
}

void Canvas::text(Point at, std::string_view text, const TextStyle& style) {
    Lettering lettering = letter(text);
    const double scale = style.size_px / 10.0;
    const double shift = style.align == Align::left     ? 0.0
                         : style.align == Align::centre ? -0.5 * lettering.width
                                                        : -lettering.width;
    for (std::vector<Point>& stroke : lettering.strokes)
        for (Point& p : stroke) {
            const double along = scale * (p.x + shift);
            const double up = scale * p.y;
            p = style.upwards ? Point{at.x - up, at.y - along} : Point{at.x + along, at.y - up};
        }
    blend(mask_for(lettering.strokes, style.size_px * (style.bold ? 0.19 : 0.125)), style.color);
}

double Canvas::text_width(std::string_view text, double size_px) {
    return letter(text).width * size_px / 10.0;
}

Color Canvas::pixel(int x, int y) const {
    const std::size_t i = 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                               static_cast<std::size_t>(x));
    return {rgb_[i], rgb_[i + 1], rgb_[i + 2]};
}

Result<void> Canvas::write_png(const std::string& path) const {
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.width = static_cast<png_uint_32>(width_);
    image.height = static_cast<png_uint_32>(height_);
    image.format = PNG_FORMAT_RGB;
    const auto write = [&](const std::string& beside) -> Result<void> {
        if (png_image_write_to_file(&image, beside.c_str(), 0, rgb_.data(), 3 * width_, nullptr) ==
            0)
            return Error{image.message};
        return {};
    };
    const Result<void> written = write_whole_file(path, write);
    return written
               ? written
               : Error{fmt::format("cannot write picture '{}': {}", path, written.error().message)};
}

} // namespace seaway::plot
