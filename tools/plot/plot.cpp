// SPDX-License-Identifier: Apache-2.0
#include "tools/plot/plot.h"

#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "base/check.h"

namespace seaway::plot {

namespace {

constexpr double number_size_px = 8.0;
constexpr double title_size_px = 9.0;
constexpr Color grid_color{226, 230, 235};

/// Lines of one pixel look sharp only on pixel centres.
double sharp(double v) {
    return std::floor(v) + 0.5;
}

std::vector<Tick> linear_ticks(const Axis& axis, int count) {
    const double rough = (axis.hi - axis.lo) / count;
    const double power = std::pow(10.0, std::floor(std::log10(rough)));
    const double lead = rough / power;
    const double chosen = power * (lead < 1.5 ? 1.0 : lead < 3.5 ? 2.0 : lead < 7.5 ? 5.0 : 10.0);
    const double step = axis.step > 0 ? axis.step : chosen;
    std::vector<Tick> result;
    const double slack = 1e-9 * step;
    for (double n = std::ceil((axis.lo - slack) / step); n * step <= axis.hi + slack; ++n)
        result.push_back({n * step, short_number(n * step)});
    return result;
}

std::vector<Tick> decade_ticks(const Axis& axis, int count) {
    const int first = static_cast<int>(std::floor(std::log10(axis.lo) + 1e-9));
    const int last = static_cast<int>(std::floor(std::log10(axis.hi) + 1e-9));
    const int every = std::max(1, (last - first + count - 1) / count);
    const bool few = std::log10(axis.hi / axis.lo) < 2.6;
    std::vector<Tick> result;
    for (int decade = first; decade <= last; ++decade)
        for (int lead = 1; lead <= 9; ++lead) {
            const double value = lead * std::pow(10.0, decade);
            if (value < axis.lo * (1 - 1e-9) || value > axis.hi * (1 + 1e-9))
                continue;
            std::string label;
            if (lead == 1 && decade % every == 0)
                label =
                    std::abs(decade) <= 2 ? short_number(value) : fmt::format("10^{{{}}}", decade);
            else if (few && (lead == 2 || lead == 5))
                label = short_number(value);
            result.push_back({value, label});
        }
    return result;
}

} // namespace

double Axis::place(double value) const {
    if (scale == Scale::linear)
        return (value - lo) / (hi - lo);
    if (!(value > 0))
        return std::numeric_limits<double>::quiet_NaN();
    return std::log(value / lo) / std::log(hi / lo);
}

double Axis::value(double place) const {
    return scale == Scale::linear ? lo + place * (hi - lo) : lo * std::pow(hi / lo, place);
}

std::vector<Tick> ticks(const Axis& axis, int count) {
    return axis.scale == Scale::linear ? linear_ticks(axis, count) : decade_ticks(axis, count);
}

std::string short_number(double value, int digits) {
    return fmt::format("{:.{}g}", value + 0.0, digits);
}

Chart::Chart(Canvas& canvas, Rect area, Axis x, Axis y)
    : canvas_(canvas), area_(area), x_(std::move(x)), y_(std::move(y)) {
    for (const Axis& axis : {x_, y_})
        SEAWAY_CHECK(axis.lo < axis.hi && (axis.scale == Scale::linear || axis.lo > 0),
                     "an axis goes up, a logarithmic one from above 0");
}

Point Chart::at(Point value) const {
    return {area_.left + x_.place(value.x) * area_.width(),
            area_.bottom - y_.place(value.y) * area_.height()};
}

Point Chart::value_at(Point pixel) const {
    return {x_.value((pixel.x - area_.left) / area_.width()),
            y_.value((area_.bottom - pixel.y) / area_.height())};
}

void Chart::draw_grid() {
    for (const Tick& tick : ticks(x_)) {
        const double x = sharp(at({tick.value, y_.lo}).x);
        canvas_.line({x, area_.top}, {x, area_.bottom},
                     {grid_color.faded(tick.label.empty() ? 0.5 : 1.0)});
    }
    for (const Tick& tick : ticks(y_)) {
        const double y = sharp(at({x_.lo, tick.value}).y);
        canvas_.line({area_.left, y}, {area_.right, y},
                     {grid_color.faded(tick.label.empty() ? 0.5 : 1.0)});
    }
}

void Chart::draw_frame() {
    const Rect r{sharp(area_.left), sharp(area_.top), sharp(area_.right), sharp(area_.bottom)};
    const std::array<Point, 5> border{{{r.left, r.top},
                                       {r.right, r.top},
                                       {r.right, r.bottom},
                                       {r.left, r.bottom},
                                       {r.left, r.top}}};
    canvas_.line(border, {ink, 1.0});
    for (const Tick& tick : ticks(x_)) {
        const double x = sharp(at({tick.value, y_.lo}).x);
        canvas_.line({x, r.bottom}, {x, r.bottom + (tick.label.empty() ? 3 : 6)}, {ink, 1.0});
        canvas_.text({x, r.bottom + 10 + number_size_px}, tick.label,
                     {ink, number_size_px, Align::centre});
    }
    double widest = 0;
    for (const Tick& tick : ticks(y_)) {
        const double y = sharp(at({x_.lo, tick.value}).y);
        canvas_.line({r.left - (tick.label.empty() ? 3 : 6), y}, {r.left, y}, {ink, 1.0});
        canvas_.text({r.left - 10, y + 0.5 * number_size_px}, tick.label,
                     {ink, number_size_px, Align::right});
        widest = std::max(widest, Canvas::text_width(tick.label, number_size_px));
    }
    const double middle_x = 0.5 * (r.left + r.right);
    const double middle_y = 0.5 * (r.top + r.bottom);
    canvas_.text({middle_x, r.bottom + 20 + number_size_px + title_size_px}, x_.title,
                 {ink, title_size_px, Align::centre});
    canvas_.text({r.left - 20 - widest, middle_y}, y_.title,
                 {ink, title_size_px, Align::centre, false, true});
}

void Chart::name(const std::string& name, Mark mark, const Stroke& stroke) {
    if (!name.empty())
        entries_.push_back({name, mark, stroke});
}

void Chart::curve(std::span<const Point> values, const Stroke& stroke, const std::string& title) {
    std::vector<Point> pixels;
    for (const Point v : values)
        pixels.push_back(at(v));
    canvas_.set_clip(area_);
    canvas_.line(pixels, stroke);
    canvas_.set_clip(canvas_.frame());
    name(title, Mark::line, stroke);
}

void Chart::points(std::span<const Point> values, double radius_px, Color color,
                   const std::string& title) {
    for (const Point v : values) {
        const Point pixel = at(v);
        if (area_.contains(pixel))
            canvas_.disc(pixel, radius_px, color);
    }
    name(title, Mark::dot, {color, 2.0 * radius_px});
}

void Chart::bar(double x, double y, double width_px, Color color) {
    const Point top = at({x, y});
    canvas_.set_clip(area_);
    canvas_.fill({top.x - 0.5 * width_px, top.y, top.x + 0.5 * width_px, area_.bottom}, color);
    canvas_.set_clip(canvas_.frame());
}

void Chart::band(double x_lo, double x_hi, Color color, const std::string& title) {
    const double left = std::max(area_.left, at({x_lo, y_.lo}).x);
    const double right = std::min(area_.right, at({x_hi, y_.lo}).x);
    if (left < right)
        canvas_.fill({left, area_.top, right, area_.bottom}, color);
    name(title, Mark::patch, {color, 1.0});
}

void Chart::vertical(double x, const Stroke& stroke, const std::string& title) {
    const double pixel = sharp(at({x, y_.lo}).x);
    if (pixel >= area_.left && pixel <= area_.right)
        canvas_.line({pixel, area_.top}, {pixel, area_.bottom}, stroke);
    name(title, Mark::line, stroke);
}

void Chart::note(Point value, Point offset_px, const std::string& text, const TextStyle& style) {
    const Point pixel = at(value);
    canvas_.text({pixel.x + offset_px.x, pixel.y + offset_px.y}, text, style);
}

void Chart::draw_entry(const Entry& entry, Point left) {
    constexpr double mark_px = 24;
    const Point middle{left.x + 0.5 * mark_px, left.y};
    switch (entry.mark) {
    case Mark::line:
        canvas_.line(left, {left.x + mark_px, left.y}, entry.stroke);
        break;
    case Mark::dot:
        canvas_.disc(middle, 0.5 * entry.stroke.width_px, entry.stroke.color);
        break;
    case Mark::patch:
        canvas_.fill({left.x, left.y - 5, left.x + mark_px, left.y + 5}, entry.stroke.color);
        break;
    }
    canvas_.text({left.x + mark_px + 9, left.y + 0.5 * number_size_px}, entry.name,
                 {ink, number_size_px});
}

void Chart::draw_legend(Corner corner) {
    constexpr double row_px = 19;
    constexpr double margin_px = 12;
    double widest = 0;
    for (const Entry& entry : entries_)
        widest = std::max(widest, Canvas::text_width(entry.name, number_size_px));
    const double width = 33 + widest + 2 * margin_px;
    const double height = row_px * static_cast<double>(entries_.size()) + margin_px;
    const bool right = corner == Corner::top_right || corner == Corner::bottom_right;
    const bool bottom = corner == Corner::bottom_left || corner == Corner::bottom_right;
    const double left = right ? area_.right - width - 10 : area_.left + 10;
    const double top = bottom ? area_.bottom - height - 10 : area_.top + 10;
    canvas_.fill({left, top, left + width, top + height}, white.faded(0.85));
    double y = top + 0.5 * margin_px + 0.5 * row_px;
    for (const Entry& entry : entries_) {
        draw_entry(entry, {left + margin_px, std::round(y)});
        y += row_px;
    }
}

void draw_color_bar(Canvas& canvas, Rect area, const Axis& axis) {
    canvas.paint(area,
                 [&](double, double y) { return sea_color((area.bottom - y) / area.height()); });
    const Rect r{sharp(area.left), sharp(area.top), sharp(area.right), sharp(area.bottom)};
    const std::array<Point, 5> border{{{r.left, r.top},
                                       {r.right, r.top},
                                       {r.right, r.bottom},
                                       {r.left, r.bottom},
                                       {r.left, r.top}}};
    canvas.line(border, {ink, 1.0});
    for (const Tick& tick : ticks(axis, 4)) {
        const double y = sharp(area.bottom - axis.place(tick.value) * area.height());
        canvas.line({r.right, y}, {r.right + 4, y}, {ink, 1.0});
        canvas.text({r.right + 8, y + 0.5 * number_size_px}, tick.label, {ink, number_size_px});
    }
    canvas.text({0.5 * (r.left + r.right), r.top - 9}, axis.title,
                {ink, number_size_px, Align::centre});
}

} // namespace seaway::plot
