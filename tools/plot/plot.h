// SPDX-License-Identifier: Apache-2.0
// Charts for our programs' pictures: axes with round ticks, linear or logarithmic, curves, points,
// bars, a legend.
//
//     Canvas canvas(1200, 700);
//     Chart chart(canvas, {90, 60, 760, 620}, {"frequency ω, rad/s", 0.1, 30, Scale::logarithmic},
//                 {"S(ω), m^{2} s/rad", 1e-4, 1e2, Scale::logarithmic});
//     chart.draw_grid();
//     chart.curve(points, {series_color(0), 2.0}, "requested");
//     chart.draw_frame();
//     chart.draw_legend(Corner::top_right);
//     return canvas.write_png(path);
//
// A chart draws on its canvas at once; what comes later lies on top. Values that an axis cannot
// show (not finite; not positive on a logarithmic one) are left out. One thread at a time.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "tools/plot/canvas.h"

namespace seaway::plot {

enum class Scale : std::uint8_t { linear, logarithmic };
enum class Corner : std::uint8_t { top_left, top_right, bottom_left, bottom_right };

struct Axis {
    std::string title;
    double lo; ///< < hi; > 0 if logarithmic
    double hi;
    Scale scale = Scale::linear;
    double step = 0; ///< between the ticks of a linear axis; 0: chosen

    /// Place along the axis, 0 at lo .. 1 at hi; not a number where the scale has none.
    double place(double value) const;
    /// The value at a place.
    double value(double place) const;
};

struct Tick {
    double value;
    std::string label; ///< empty: a small tick
};

/// Ticks at 1, 2 or 5 times powers of ten, or at decades, about `count` with a label.
std::vector<Tick> ticks(const Axis& axis, int count = 7);

/// Shortest text that shows a number to `digits` significant places: "0.05", "120", "1.2e-7".
std::string short_number(double value, int digits = 3);

class Chart {
  public:
    /// `area` is the inside of the axes; titles and numbers need about 60 px left, 40 px below.
    Chart(Canvas& canvas, Rect area, Axis x, Axis y);

    /// Light lines at the ticks. First of all.
    void draw_grid();
    /// Border, ticks, numbers and axis titles. After the data.
    void draw_frame();

    /// A name puts the series into the legend; an empty one does not.
    void curve(std::span<const Point> values, const Stroke& stroke, const std::string& name = {});
    void points(std::span<const Point> values, double radius_px, Color color,
                const std::string& name = {});
    /// A bar from the bottom of the chart to `y`, `width_px` wide.
    void bar(double x, double y, double width_px, Color color);
    /// Fills from one x to another over the full height.
    void band(double x_lo, double x_hi, Color color, const std::string& name = {});
    void vertical(double x, const Stroke& stroke, const std::string& name = {});
    /// Text at a value, moved by some pixels.
    void note(Point value, Point offset_px, const std::string& text, const TextStyle& style = {});

    void draw_legend(Corner corner);

    /// Where a value lies on the canvas, px.
    Point at(Point value) const;
    /// The value at a place of the canvas.
    Point value_at(Point pixel) const;
    const Rect& area() const { return area_; }
    Canvas& canvas() { return canvas_; }

  private:
    enum class Mark : std::uint8_t { line, dot, patch };
    struct Entry {
        std::string name;
        Mark mark;
        Stroke stroke;
    };
    void name(const std::string& name, Mark mark, const Stroke& stroke);
    void draw_entry(const Entry& entry, Point left_px);

    Canvas& canvas_;
    Rect area_;
    Axis x_;
    Axis y_;
    std::vector<Entry> entries_;
};

/// A legend to a colour scale: a vertical bar from sea_color(0) below to sea_color(1) above, with
/// the numbers of `axis` on its right side and its title above.
void draw_color_bar(Canvas& canvas, Rect area, const Axis& axis);

} // namespace seaway::plot
