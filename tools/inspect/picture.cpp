// SPDX-License-Identifier: Apache-2.0
#include "tools/inspect/picture.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include <fmt/format.h>

#include "sea/scene/scene_names.h"
#include "tools/inspect/curves.h"

namespace seaway::inspect {

namespace {

using plot::Align;
using plot::Axis;
using plot::Canvas;
using plot::Chart;
using plot::ink;
using plot::Point;
using plot::Rect;
using plot::Scale;

constexpr plot::Color peak_color{200, 30, 60};
constexpr double decades_most = 6.5;
constexpr double decades_least = 3.5;

/// Where waves that come from a bearing go, rad.
double towards(double from_deg) {
    return (270.0 - from_deg) / sea::degrees_per_radian;
}

void draw_title(Canvas& canvas, const Report& report) {
    const sea::SeaStatistics& q = report.summary.requested;
    const sea::SeaStatistics& r = report.summary.realised;
    const std::string name = std::filesystem::path(report.scene.source).stem().string();
    canvas.text({36, 38}, name, {ink, 15, Align::left, true});
    const std::string facts =
        r.significant_height_m > 0.0
            ? fmt::format("requested Hs {:.2f} m, Tp {:.1f} s    realised Hs {:.2f} m, Tp {:.1f} s "
                          "   from {:.0f}°, spread {:.0f}°",
                          q.significant_height_m, q.peak_period_s, r.significant_height_m,
                          r.peak_period_s, sea::bearing_from_towards(r.mean_towards_rad),
                          r.spread_rad * sea::degrees_per_radian)
            : std::string("a flat sea");
    canvas.text({1176, 38}, facts, {ink, 9.5, Align::right});
}

std::vector<Point> sampled(FrequencyRange range, const auto& density) {
    constexpr int steps = 600;
    std::vector<Point> points;
    for (int i = 0; i <= steps; ++i) {
        const double omega =
            range.lo_radps * std::pow(range.hi_radps / range.lo_radps, i / double(steps));
        points.push_back({omega, density(omega)});
    }
    return points;
}

/// Periods along the upper edge.
void draw_periods(Chart& chart, FrequencyRange range) {
    const Axis periods{"", sea::two_pi / range.hi_radps, sea::two_pi / range.lo_radps,
                       Scale::logarithmic};
    const Rect& area = chart.area();
    for (const plot::Tick& tick : plot::ticks(periods)) {
        const double x = std::floor(chart.at({sea::two_pi / tick.value, 1.0}).x) + 0.5;
        const double length = tick.label.empty() ? 3 : 6;
        chart.canvas().line({x, area.top - length}, {x, area.top}, {ink, 1.0});
        chart.canvas().text({x, area.top - 10}, tick.label, {ink, 8.0, Align::centre});
    }
    chart.canvas().text({0.5 * (area.left + area.right), area.top - 28}, "period, s",
                        {ink, 9.0, Align::centre});
}

void draw_bands(Chart& chart, const Report& report) {
    const sea::Dispersion dispersion = report.scene.sea.dispersion();
    for (std::size_t c = 0; c < report.sea->cascades.size(); ++c) {
        const sea::CascadeModes& modes = report.sea->cascades[c];
        if (!modes.carries_spectra)
            continue;
        const double lo = dispersion.omega(modes.band.k_lo_radpm);
        const double hi = dispersion.omega(modes.band.k_hi_radpm);
        chart.band(lo, hi, plot::series_color(c).faded(0.13));
        const double middle = 0.5 * (std::max(chart.at({lo, 1.0}).x, chart.area().left) +
                                     std::min(chart.at({hi, 1.0}).x, chart.area().right));
        chart.canvas().text({middle, chart.area().bottom - 26},
                            fmt::format("{:g} m", modes.spec.length_m),
                            {plot::series_color(c), 9.0, Align::centre, true});
        chart.canvas().text({middle, chart.area().bottom - 10},
                            fmt::format("{0} × {0}", modes.spec.size),
                            {plot::series_color(c), 8.0, Align::centre});
    }
}

void draw_spectrum(Canvas& canvas, const Report& report, const SeaSpectrum& spectrum,
                   FrequencyRange range) {
    const std::vector<Point> requested =
        sampled(range, [&](double omega) { return spectrum.density(omega); });
    std::vector<std::vector<Point>> realised;
    double highest = 0.0;
    double lowest = std::numeric_limits<double>::infinity();
    for (const sea::CascadeModes& modes : report.sea->cascades)
        for (const Point p :
             realised.emplace_back(realised_density(modes, report.scene.sea.dispersion()))) {
            highest = std::max(highest, p.y);
            lowest = std::min(lowest, p.y);
        }
    for (const Point p : requested)
        highest = std::max(highest, p.y);
    const double top = highest > 0.0 ? 3.0 * highest : 1.0; // of a flat sea any
    const double bottom = std::clamp(0.3 * lowest, top * std::pow(10.0, -decades_most),
                                     top * std::pow(10.0, -decades_least));
    Chart chart(canvas, {92, 112, 720, 636},
                {"angular frequency ω, rad/s", range.lo_radps, range.hi_radps, Scale::logarithmic},
                {"energy density S(ω), m^{2} s/rad", bottom, top, Scale::logarithmic});
    chart.draw_grid();
    draw_bands(chart, report);
    if (report.summary.requested.peak_period_s > 0.0) {
        const double peak = sea::two_pi / report.summary.requested.peak_period_s;
        chart.vertical(peak, {peak_color, 1.5, 6.0},
                       fmt::format("peak, Tp {:.1f} s", report.summary.requested.peak_period_s));
    }
    chart.curve(requested, {ink, 2.0}, "requested");
    if (report.summary.lost_fade_m2 > 1e-9 * highest)
        chart.curve(sampled(range, [&](double omega) { return spectrum.kept_density(omega); }),
                    {ink, 1.5, 5.0}, "after fade and cut-offs");
    for (std::size_t c = 0; c < realised.size(); ++c)
        chart.points(realised[c], 3.0, plot::series_color(c),
                     fmt::format("realised, tile {:g} m", report.sea->cascades[c].spec.length_m));
    chart.draw_frame();
    draw_periods(chart, range);
    chart.draw_legend(plot::Corner::top_right);
}

constexpr Point compass_centre{936, 262};
constexpr double compass_radius = 150;

/// Where a frequency and a direction lie on the compass: from where waves come.
Point on_compass(double share_of_radius, double from_rad) {
    return {compass_centre.x + share_of_radius * compass_radius * std::sin(from_rad),
            compass_centre.y - share_of_radius * compass_radius * std::cos(from_rad)};
}

void draw_compass_frame(Canvas& canvas, double omega_end, const std::string& title) {
    for (const plot::Tick& tick : plot::ticks({"", 0.0, omega_end}, 3)) {
        const double share = tick.value / omega_end;
        if (share < 0.01 || share > 0.99)
            continue;
        canvas.circle(compass_centre, share * compass_radius, {plot::grey.faded(0.6), 0.8});
        const Point label = on_compass(share, 0.75 * sea::pi);
        canvas.text({label.x + 3, label.y + 11}, tick.label, {plot::grey, 7.5});
    }
    for (int bearing = 0; bearing < 360; bearing += 30) {
        const double angle = bearing / sea::degrees_per_radian;
        canvas.line(compass_centre, on_compass(1.0, angle), {plot::grey.faded(0.35), 0.8});
        const bool main = bearing % 90 == 0;
        const std::string label =
            main ? std::string(1, "NESW"[bearing / 90]) : fmt::format("{}°", bearing);
        const Point at = on_compass(1.11, angle);
        canvas.text({at.x, at.y + 4}, label, {ink, main ? 10.0 : 7.5, Align::centre, main});
    }
    canvas.circle(compass_centre, compass_radius, {ink, 1.0});
    canvas.text({compass_centre.x, 78}, title, {ink, 9.0, Align::centre});
    canvas.text({compass_centre.x + 112, compass_centre.y + compass_radius + 12},
                "radius: ω, rad/s", {plot::grey, 7.5});
}

/// Energy over frequency and direction.
void draw_compass(Canvas& canvas, const SeaSpectrum& spectrum) {
    constexpr Rect box{compass_centre.x - compass_radius, compass_centre.y - compass_radius,
                       compass_centre.x + compass_radius, compass_centre.y + compass_radius};
    const double omega_end = 3.0 * spectrum.highest_peak_radps();
    const auto energy = [&](double dx, double dy) {
        const double omega = omega_end * std::hypot(dx, dy) / compass_radius;
        const double from_deg = sea::degrees_per_radian * std::atan2(dx, -dy);
        return omega > 0.0 && omega < omega_end
                   ? spectrum.density(omega) * spectrum.spreading(omega, towards(from_deg))
                   : 0.0;
    };
    constexpr int side = 2 * static_cast<int>(compass_radius);
    std::vector<double> values;
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x)
            values.push_back(energy(x + 0.5 - compass_radius, y + 0.5 - compass_radius));
    const double highest = *std::max_element(values.begin(), values.end());
    // The root of the energy, as amplitudes have it, shows swell beside a wind sea.
    canvas.paint(box, [&](double px, double py) {
        const auto i =
            static_cast<std::size_t>((py - box.top - 0.5) * side + (px - box.left - 0.5));
        plot::Color color = plot::sea_color(highest > 0.0 ? std::sqrt(values[i] / highest) : 0.0);
        const double r = std::hypot(px - compass_centre.x, py - compass_centre.y);
        color.opacity = std::clamp(compass_radius - r, 0.0, 1.0);
        return color;
    });
    draw_compass_frame(canvas, omega_end, "root of S(ω) D(θ, ω), by where waves come from");
    plot::draw_color_bar(canvas, {1126, 132, 1140, 392},
                         {"of the largest", 0.0, 1.0, Scale::linear});
}

/// A sea without spectra: each wave by itself.
void draw_waves(Canvas& canvas, const Report& report, FrequencyRange range) {
    const std::vector<ExplicitWave> waves = explicit_waves(*report.sea);
    double highest = 0.0;
    double omega_last = 0.0;
    for (const ExplicitWave& wave : waves) {
        highest = std::max(highest, wave.amplitude_m);
        omega_last = std::max(omega_last, wave.omega_radps);
    }
    Chart chart(canvas, {92, 112, 720, 636},
                {"angular frequency ω, rad/s", range.lo_radps, range.hi_radps, Scale::logarithmic},
                {"amplitude, m", 0.0, highest > 0.0 ? 1.15 * highest : 1.0});
    chart.draw_grid();
    draw_bands(chart, report);
    std::vector<Point> tops;
    for (const ExplicitWave& wave : waves) {
        chart.bar(wave.omega_radps, wave.amplitude_m, 2.0, plot::series_color(0));
        tops.push_back({wave.omega_radps, wave.amplitude_m});
    }
    chart.points(tops, 3.5, plot::series_color(0), "waves");
    chart.draw_frame();
    draw_periods(chart, range);
    if (waves.empty())
        return;
    chart.draw_legend(plot::Corner::top_right);
    const double omega_end = 1.1 * omega_last;
    draw_compass_frame(canvas, omega_end, "waves, by where they come from");
    for (const ExplicitWave& wave : waves)
        canvas.disc(on_compass(wave.omega_radps / omega_end, 1.5 * sea::pi - wave.towards_rad),
                    2.0 + 6.0 * (highest > 0.0 ? std::sqrt(wave.amplitude_m / highest) : 0.0),
                    plot::series_color(0).faded(0.7));
}

/// The share of each frequency's energy by direction.
void draw_spreading(Canvas& canvas, const Report& report, const SeaSpectrum& spectrum,
                    FrequencyRange range) {
    const double mean_deg =
        std::round(sea::bearing_from_towards(report.summary.requested.mean_towards_rad));
    Chart chart(canvas, {800, 500, 1090, 636},
                {"angular frequency ω, rad/s", range.lo_radps, range.hi_radps, Scale::logarithmic},
                {"from mean direction, °", -180.0, 180.0, Scale::linear, 90.0});
    const Rect& area = chart.area();
    const auto share = [&](Point pixel) {
        const Point value = chart.value_at(pixel);
        return spectrum.spreading(value.x, towards(mean_deg + value.y));
    };
    double highest = 0.0;
    for (double y = area.top + 0.5; y < area.bottom; ++y)
        for (double x = area.left + 0.5; x < area.right; x += 4)
            highest = std::max(highest, share({x, y}));
    canvas.paint(area, [&](double x, double y) {
        return plot::sea_color(highest > 0.0 ? share({x, y}) / highest : 0.0);
    });
    if (report.summary.requested.peak_period_s > 0.0)
        chart.vertical(sea::two_pi / report.summary.requested.peak_period_s,
                       {peak_color, 1.5, 6.0});
    chart.draw_frame();
    canvas.text({0.5 * (area.left + area.right), area.top - 14},
                fmt::format("spreading D(θ, ω) around {:.0f}°", mean_deg),
                {ink, 9.0, Align::centre});
    plot::draw_color_bar(canvas, {1126, area.top, 1140, area.bottom},
                         {"D, 1/rad", 0.0, std::max(highest, 1e-9), Scale::linear});
}

} // namespace

Result<void> draw_picture(const Report& report, const std::string& path) {
    Canvas canvas(1200, 700);
    const SeaSpectrum spectrum(report.scene.sea);
    const FrequencyRange range = frequency_range(report, spectrum);
    draw_title(canvas, report);
    if (spectrum.empty()) {
        draw_waves(canvas, report, range);
    } else {
        draw_spectrum(canvas, report, spectrum, range);
        draw_compass(canvas, spectrum);
        draw_spreading(canvas, report, spectrum, range);
    }
    return canvas.write_png(path);
}

} // namespace seaway::inspect
