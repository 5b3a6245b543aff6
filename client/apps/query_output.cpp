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

constexpr std::array<const char*, 12> columns{"x_m",
                                              "y_m",
                                              "t_s",
                                              "height_m",
                                              "normal_x",
                                              "normal_y",
                                              "normal_z",
                                              "velocity_x_mps",
                                              "velocity_y_mps",
                                              "velocity_z_mps",
                                              "error_m",
                                              "flags"};

/// The columns but the last.
std::array<double, 11> values(const QueryPoint& point, const Answer& a) {
    return {point.x_m,         point.y_m,         sea::seconds_from_us(point.time_us),
            a.height_m,        a.normal[0],       a.normal[1],
            a.normal[2],       a.velocity_mps[0], a.velocity_mps[1],
            a.velocity_mps[2], a.error_m};
}

void csv_row(std::string& out, const QueryPoint& point, const Answer& answer) {
    for (const double value : values(point, answer))
        fmt::format_to(std::back_inserter(out), "{},", value);
    fmt::format_to(std::back_inserter(out), "{}\n", answer.flags);
}

void json_row(std::string& out, const QueryPoint& point, const Answer& answer) {
    const std::array<double, 11> row = values(point, answer);
    out += '{';
    for (std::size_t i = 0; i < row.size(); ++i)
        if (std::isfinite(row[i]))
            fmt::format_to(std::back_inserter(out), "\"{}\":{},", columns[i], row[i]);
        else
            fmt::format_to(std::back_inserter(out), "\"{}\":null,", columns[i]);
    fmt::format_to(std::back_inserter(out), "\"flags\":{}}}", answer.flags);
}

constexpr const char* table_head =
    "         x_m          y_m           t_s  height_m   normal_x normal_y normal_z   "
    "velocity_x_mps _y_mps _z_mps    error_m  flags\n";

void table_row(std::string& out, const QueryPoint& point, const Answer& a) {
    fmt::format_to(std::back_inserter(out),
                   "{:12.3f} {:12.3f} {:13.3f} {:9.4f}   {:8.4f} {:8.4f} {:8.4f}   {:14.3f} "
                   "{:6.3f} {:6.3f} {:10.5f}  {}\n",
                   point.x_m, point.y_m, sea::seconds_from_us(point.time_us), a.height_m,
                   a.normal[0], a.normal[1], a.normal[2], a.velocity_mps[0], a.velocity_mps[1],
                   a.velocity_mps[2], a.error_m, flag_names(a.flags));
}

std::string json_array(std::span<const QueryPoint> points, std::span<const Answer> answers,
                       bool compact) {
    const char* const between = compact ? "," : ",\n ";
    std::string out = "[";
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (i > 0)
            out += between;
        json_row(out, points[i], answers[i]);
    }
    return out + "]\n";
}

} // namespace

std::string flag_names(std::uint32_t flags) {
    constexpr std::array<const char*, 8> names{"folded",  "not_converged", "extrapolated",
                                               "invalid", "exact",         "vertical_velocity",
                                               "open",    "stale"};
    std::string out;
    for (std::size_t bit = 0; bit < names.size(); ++bit)
        if ((flags >> bit) & 1u)
            out += (out.empty() ? "" : " ") + std::string(names[bit]);
    return out.empty() ? "-" : out;
}

std::string output_head(Format format) {
    return format == Format::csv ? fmt::format("{}\n", fmt::join(columns, ",")) : std::string();
}

std::string output_rows(Format format, std::span<const QueryPoint> points,
                        std::span<const Answer> answers, bool compact) {
    SEAWAY_CHECK(points.size() == answers.size(), "one answer a point");
    if (format == Format::json)
        return json_array(points, answers, compact);
    std::string out = format == Format::table ? table_head : "";
    for (std::size_t i = 0; i < points.size(); ++i)
        if (format == Format::csv)
            csv_row(out, points[i], answers[i]);
        else
            table_row(out, points[i], answers[i]);
    return out;
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
