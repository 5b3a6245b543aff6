// SPDX-License-Identifier: Apache-2.0
#include "tools/inspect/points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iostream>
#include <limits>
#include <numeric>
#include <optional>
#include <string_view>

#include <fmt/format.h>

#include "base/csv_table.h"
#include "base/text_file.h"
#include "sea/surface/inverse.h"
#include "sea/waves/reference.h"

namespace seaway::inspect {

namespace {

constexpr std::array<std::string_view, 3> columns{"x_m", "y_m", "t_s"};
constexpr double time_max_s = sea::seconds_from_us(sea::time_us_max);
constexpr double tolerance_m = 1e-9;
/// Rounding of the direct sum, as a share of the sum of all amplitudes (sea/waves/reference.h).
constexpr double sum_rounding = 1e-13;

/// Three fields of a line, or nothing.
std::optional<std::array<std::string_view, 3>> split(std::string_view line) {
    std::array<std::string_view, 3> fields;
    for (std::size_t i = 0; i < fields.size(); ++i) {
        const auto comma = line.find(',');
        if ((comma == std::string_view::npos) != (i + 1 == fields.size()))
            return std::nullopt;
        fields[i] = trimmed(line.substr(0, comma));
        line.remove_prefix(comma == std::string_view::npos ? line.size() : comma + 1);
    }
    return fields;
}

double sum_of_amplitudes(const sea::Realization& sea) {
    double sum = 0.0;
    for (const sea::CascadeModes& cascade : sea.cascades) {
        for (const std::complex<double> h0 : cascade.h0)
            sum += 2.0 * std::abs(h0);
        for (const sea::SineField& field : cascade.sines)
            sum += sine_height_max_m(field);
    }
    return sum;
}

} // namespace

Result<std::vector<sea::QueryPoint>> read_points(std::istream& in, const std::string& name) {
    std::vector<sea::QueryPoint> points;
    std::string line;
    for (int number = 1;; ++number) {
        const Result<bool> more = next_line(in, line);
        if (!more)
            return Error{fmt::format("{}:{}: {}", name, number, more.error().message)};
        if (!*more)
            break;
        if (trimmed(line).empty())
            continue;
        const auto fields = split(number == 1 ? without_mark(line) : line);
        if (!fields)
            return Error{fmt::format("{}:{}: not three fields x_m,y_m,t_s", name, number)};
        if (points.empty() && *fields == columns)
            continue;
        std::array<double, 3> values{};
        for (std::size_t i = 0; i < values.size(); ++i) {
            const double limit = i < 2 ? coordinate_max_m : time_max_s;
            const std::optional<double> value = number_in((*fields)[i], limit);
            if (!value)
                return Error{fmt::format("{}:{}: {} = '{}': not a number between {:g} and {:g}",
                                         name, number, columns[i], (*fields)[i], -limit, limit)};
            values[i] = *value;
        }
        if (points.size() == csv_points_max)
            return Error{fmt::format("{}:{}: more than {} points", name, number, csv_points_max)};
        points.push_back({values[0], values[1], sea::us_from_seconds(values[2])});
    }
    return points;
}

Result<std::vector<sea::QueryPoint>> read_points(const std::string& path) {
    if (path == "-")
        return read_points(std::cin, "standard input");
    if (const Result<void> regular = check_regular_file(path); !regular)
        return Error{fmt::format("cannot read points '{}': {}", path, regular.error().message)};
    std::ifstream file(path);
    return read_points(file, path);
}

std::vector<sea::Answer> answer_points(const sea::RealizationPtr& sea, const sea::FoldSearch& folds,
                                       const std::vector<sea::QueryPoint>& points) {
    // By time, so that each moment is built once, whatever the order of the rows.
    std::vector<std::size_t> order(points.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return points[a].time_us < points[b].time_us;
    });
    const sea::DirectSum sum(sea);
    const double rounding_m = sum_rounding * sum_of_amplitudes(*sea);
    std::vector<sea::Answer> answers(points.size());
    std::optional<sea::DirectSum::Moment> moment;
    for (std::size_t i = 0; i < order.size(); ++i) {
        const sea::QueryPoint& point = points[order[i]];
        if (i == 0 || point.time_us != points[order[i - 1]].time_us)
            moment = sum.at_time(point.time_us);
        // Far out, coordinates themselves are rounded to more than the tolerance.
        const double rounded_to_m = std::numeric_limits<double>::epsilon() *
                                    std::max(std::abs(point.x_m), std::abs(point.y_m));
        const sea::InverseOptions options{sea->choppiness,
                                          std::max(tolerance_m, 4.0 * rounded_to_m), folds};
        sea::Answer& answer = answers[order[i]];
        answer = surface_at(point, options, *moment);
        answer.flags |= sea::answer_exact;
        answer.error_m += rounding_m + 2.0 * rounded_to_m * surface_slope(answer);
    }
    return answers;
}

std::string to_csv(const std::vector<sea::QueryPoint>& points,
                   const std::vector<sea::Answer>& answers) {
    std::string out = "x_m,y_m,t_s,height_m,normal_x,normal_y,normal_z,velocity_x_mps,"
                      "velocity_y_mps,velocity_z_mps,error_m,flags\n";
    for (std::size_t i = 0; i < points.size(); ++i) {
        const sea::Answer& a = answers[i];
        for (const double value :
             {points[i].x_m, points[i].y_m, sea::seconds_from_us(points[i].time_us), a.height_m,
              a.normal[0], a.normal[1], a.normal[2], a.velocity_mps[0], a.velocity_mps[1],
              a.velocity_mps[2], a.error_m})
            out += fmt::format("{:.17g},", value);
        out += fmt::format("{}\n", a.flags);
    }
    return out;
}

} // namespace seaway::inspect
