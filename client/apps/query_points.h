// SPDX-License-Identifier: Apache-2.0
// Points that a user names: on the command line and in CSV files. Pure; thread-safe.
#pragma once

#include <iosfwd>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/csv_table.h"
#include "base/result.h"
#include "sea/basics/time.h"

namespace seaway::client {

/// Places are at most this far from the origin; beyond, a coordinate resolves no wave.
inline constexpr double coordinate_max_m = 1e9;

/// Times are within sea::in_time_range.
inline constexpr double time_max_s = sea::seconds_from_us(sea::time_us_max);

struct Place {
    double x_m = 0;
    double y_m = 0;
    std::optional<double> time_s; ///< sea time of its own
};

/// "X,Y".
Result<Place> parse_place(std::string_view text);

/// Rows `x_m,y_m` or `x_m,y_m,t_s`, mixed if need be, with or without a header of these names;
/// blank lines are skipped. Errors name the line; a line of more than csv_line_bytes_max bytes is one.
Result<std::vector<Place>> read_places(std::istream& in, const std::string& name,
                                       std::size_t points_max = csv_points_max);

/// The same from a file; "-" is standard input.
Result<std::vector<Place>> read_places(const std::string& path);

} // namespace seaway::client
