// SPDX-License-Identifier: Apache-2.0
#include "client/apps/query_output.h"

#include <array>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

#include "base/check.h"

namespace seaway::client {
namespace {

using sea::Answer;
using sea::QueryPoint;

/// A row: numbers, each with its name, and flags last.
template <std::size_t count>
struct Columns {
    std::array<const char*, count> names; ///< but that of the flags
    const char* table_head;
};
constexpr Columns<11> of_surface{
    {"x_m", "y_m", "t_s", "height_m", "normal_x", "normal_y", "normal_z", "velocity_x_mps",
     "velocity_y_mps", "velocity_z_mps", "error_m"},
    "         x_m          y_m           t_s  height_m   normal_x normal_y normal_z   "
    "velocity_x_mps _y_mps _z_mps    error_m  flags\n"};
constexpr Columns<9> of_water{{"x_m", "y_m", "t_s", "z_m", "surface_m", "velocity_x_mps",
                               "velocity_y_mps", "velocity_z_mps", "pressure_m2ps2"},
                              "         x_m          y_m           t_s        z_m  surface_m   "
                              "velocity_x_mps _y_mps _z_mps  pressure_m2ps2  flags\n"};

std::array<double, 11> values(const QueryPoint& point, const Answer& a) {
    return {point.x_m,         point.y_m,         sea::seconds_from_us(point.time_us),
            a.height_m,        a.normal[0],       a.normal[1],
            a.normal[2],       a.velocity_mps[0], a.velocity_mps[1],
            a.velocity_mps[2], a.error_m};
}
std::array<double, 9> values(const QueryPoint& point, double z_m, double surface_m,
                             const sea::WaterBelow& water) {
    return {point.x_m,
            point.y_m,
            sea::seconds_from_us(point.time_us),
            z_m,
            surface_m,
            water.velocity_mps[0],
            water.velocity_mps[1],
            water.velocity_mps[2],
            water.pressure_m2ps2};
}

void table_row(std::string& out, const std::array<double, 11>& v, std::uint32_t flags) {
    fmt::format_to(std::back_inserter(out),
                   "{:12.3f} {:12.3f} {:13.3f} {:9.4f}   {:8.4f} {:8.4f} {:8.4f}   {:14.3f} "
                   "{:6.3f} {:6.3f} {:10.5f}  {}\n",
                   v[0], v[1], v[2], v[3], v[4], v[5], v[6], v[7], v[8], v[9], v[10],
                   flag_names(flags));
}
void table_row(std::string& out, const std::array<double, 9>& v, std::uint32_t flags) {
    fmt::format_to(std::back_inserter(out),
                   "{:12.3f} {:12.3f} {:13.3f} {:10.3f} {:10.4f}   {:14.3f} {:6.3f} {:6.3f}  "
                   "{:14.4f}  {}\n",
                   v[0], v[1], v[2], v[3], v[4], v[5], v[6], v[7], v[8], flag_names(flags));
}

template <std::size_t count>
void csv_row(std::string& out, const std::array<double, count>& row, std::uint32_t flags) {
    for (const double value : row)
        fmt::format_to(std::back_inserter(out), "{},", value);
    fmt::format_to(std::back_inserter(out), "{}\n", flags);
}

template <std::size_t count>
void json_row(std::string& out, const Columns<count>& columns, const std::array<double, count>& row,
              std::uint32_t flags) {
    out += '{';
    for (std::size_t i = 0; i < row.size(); ++i)
        if (std::isfinite(row[i]))
            fmt::format_to(std::back_inserter(out), "\"{}\":{},", columns.names[i], row[i]);
        else
            fmt::format_to(std::back_inserter(out), "\"{}\":null,", columns.names[i]);
    fmt::format_to(std::back_inserter(out), "\"flags\":{}}}", flags);
}

/// `values_of(i)`: of a row.
template <std::size_t count, class ValuesOf>
std::string rows_of(Format format, const Columns<count>& columns, std::span<const Answer> answers,
                    bool compact, const ValuesOf& values_of) {
    const char* const between = compact ? "," : ",\n ";
    std::string out = format == Format::json    ? "["
                      : format == Format::table ? columns.table_head
                                                : "";
    for (std::size_t i = 0; i < answers.size(); ++i) {
        const std::array<double, count> row = values_of(i);
        if (format == Format::csv)
            csv_row(out, row, answers[i].flags);
        else if (format == Format::table)
            table_row(out, row, answers[i].flags);
        else
            json_row(out += i > 0 ? between : "", columns, row, answers[i].flags);
    }
    return format == Format::json ? out + "]\n" : out;
}

} // namespace

std::string flag_names(std::uint32_t flags) {
    std::string out;
    for (std::size_t bit = 0; bit < sea::answer_flag_names.size(); ++bit)
        if ((flags >> bit) & 1u)
            out += (out.empty() ? "" : " ") + std::string(sea::answer_flag_names[bit]);
    return out.empty() ? "-" : out;
}

std::string output_head(Format format, bool below) {
    if (format != Format::csv)
        return {};
    return below ? fmt::format("{},flags\n", fmt::join(of_water.names, ","))
                 : fmt::format("{},flags\n", fmt::join(of_surface.names, ","));
}

std::string output_rows(Format format, std::span<const QueryPoint> points,
                        std::span<const Answer> answers, bool compact) {
    SEAWAY_CHECK(points.size() == answers.size(), "one answer a point");
    return rows_of(format, of_surface, answers, compact,
                   [&](std::size_t i) { return values(points[i], answers[i]); });
}

std::string output_rows(Format format, std::span<const QueryPoint> points, double z_m,
                        const Below& found, bool compact) {
    SEAWAY_CHECK(points.size() == found.answers.size() && points.size() == found.water.size(),
                 "one answer a point");
    return rows_of(format, of_water, found.answers, compact, [&](std::size_t i) {
        return values(points[i], z_m, found.answers[i].height_m, found.water[i]);
    });
}

std::string output_bench(Format format, std::span<const BenchRow> rows) {
    std::string out;
    if (format == Format::csv)
        out = "how,points_per_query,in_flight,queries,seconds,points_per_s,round_trip_p50_ms,"
              "round_trip_p99_ms\n";
    else if (format == Format::table)
        out = "how     points_per_query  in_flight  queries  seconds  points_per_s  "
              "round_trip_p50_ms  round_trip_p99_ms\n";
    else
        out = "[";
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const BenchRow& row = rows[i];
        constexpr const char* csv = "{},{},{},{},{},{},{},{}\n";
        constexpr const char* table =
            "{:<6}  {:16}  {:9}  {:7}  {:7.2f}  {:12.0f}  {:17.3f}  {:17.3f}\n";
        constexpr const char* json =
            "{{\"how\":\"{}\",\"points_per_query\":{},\"in_flight\":{},\"queries\":{},"
            "\"seconds\":{},\"points_per_s\":{},\"round_trip_p50_ms\":{},"
            "\"round_trip_p99_ms\":{}}}";
        if (format == Format::json && i > 0)
            out += ",\n ";
        out += fmt::format(fmt::runtime(format == Format::csv     ? csv
                                        : format == Format::table ? table
                                                                  : json),
                           row.how, row.points_per_query, row.in_flight, row.queries, row.seconds,
                           row.points_per_s(), row.round_trip_p50_ms, row.round_trip_p99_ms);
    }
    return format == Format::json ? out + "]\n" : out;
}

} // namespace seaway::client
