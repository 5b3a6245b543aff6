// SPDX-License-Identifier: Apache-2.0
#include "tools/inspect/array_picture.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "tools/exr/exr_map.h"
#include "tools/plot/canvas.h"

namespace seaway::inspect {

namespace {

constexpr int caption_px = 44;
constexpr int least_width_px = 420; // room for a caption
constexpr double decades = 6.0;

/// One number a point: the value, or the magnitude.
std::vector<double> shown(const Array2d& array) {
    const auto count =
        static_cast<std::size_t>(array.rows) * static_cast<std::size_t>(array.columns);
    std::vector<double> numbers(count);
    for (std::size_t i = 0; i < count; ++i)
        numbers[i] = array.complex ? std::hypot(static_cast<double>(array.values[2 * i]),
                                                static_cast<double>(array.values[2 * i + 1]))
                                   : static_cast<double>(array.values[i]) - array.middle;
    return numbers;
}

double largest_magnitude(const std::vector<double>& numbers) {
    double largest = 0;
    for (const double number : numbers)
        if (std::isfinite(number))
            largest = std::max(largest, std::abs(number));
    return largest;
}

plot::Color diverging(double share) { // -1 .. 1
    const double strength = std::min(std::abs(share), 1.0);
    const auto mix = [&](int full) {
        return static_cast<std::uint8_t>(std::lround(255 + (full - 255) * strength));
    };
    return share < 0 ? plot::Color{mix(20), mix(80), mix(170)}
                     : plot::Color{mix(180), mix(40), mix(30)};
}

plot::Color color_of(double number, double largest, bool complex) {
    if (!std::isfinite(number))
        return {255, 0, 255}; // no accepted scene has any; if one had, it would be seen
    if (largest <= 0)
        return complex ? plot::sea_color(0) : diverging(0);
    if (!complex)
        return diverging(number / largest);
    const double level = number > 0 ? 1.0 + std::log10(number / largest) / decades : 0.0;
    return plot::sea_color(std::clamp(level, 0.0, 1.0));
}

std::string scale_text(double largest, double middle, bool complex) {
    return complex ? fmt::format("white {:.3g} .. dark {:.3g}, logarithmic", largest / 1e6, largest)
                   : fmt::format("blue {:.4g} .. white {:g} .. red {:.4g}", middle - largest,
                                 middle, middle + largest);
}

} // namespace

Result<void> draw_array(const Array2d& array, const std::string& path) {
    const std::vector<double> numbers = shown(array);
    const double largest = largest_magnitude(numbers);
    const int zoom = std::max(1, (least_width_px + array.columns - 1) / array.columns);
    plot::Canvas canvas(zoom * array.columns, zoom * array.rows + caption_px);
    const plot::Rect area{0, 0, static_cast<double>(zoom * array.columns),
                          static_cast<double>(zoom * array.rows)};
    canvas.paint(area, [&](double x, double y) {
        const int line = static_cast<int>(y) / zoom;
        const int row = array.north_up ? array.rows - 1 - line : line;
        const auto at = static_cast<std::size_t>(row) * static_cast<std::size_t>(array.columns) +
                        static_cast<std::size_t>(static_cast<int>(x) / zoom);
        return color_of(numbers[at], largest, array.complex);
    });
    canvas.text({8, area.bottom + 17}, array.title, {});
    canvas.text({8, area.bottom + 35}, scale_text(largest, array.middle, array.complex),
                {plot::grey});
    return canvas.write_png(path);
}

Result<void> save_array(const Array2d& array, const std::string& path) {
    exr::ExrMap map;
    map.width = array.columns;
    map.height = array.rows;
    map.attributes = {{"seaway.title", array.title}, {"seaway.length_m", array.length_m}};
    if (array.north_up)
        map.attributes.emplace_back("seaway.rows", "south to north");
    if (array.time_us)
        map.attributes.emplace_back("seaway.time_us", std::to_string(*array.time_us));
    std::vector<float> parts[2];
    if (array.complex) {
        for (std::size_t i = 0; i < array.values.size(); ++i)
            parts[i % 2].push_back(array.values[i]);
        map.channels = {{"re", parts[0]}, {"im", parts[1]}};
    } else {
        map.channels = {{"Y", array.values}};
    }
    return exr::write_exr(path, map);
}

} // namespace seaway::inspect
