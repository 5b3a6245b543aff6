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

/// Within sea::position_max_m and sea::time_max_s.
struct Place {
    double x_m = 0;
    double y_m = 0;
    std::optional<double> time_s; ///< sea time of its own
};

/// "X,Y".
Result<Place> parse_place(std::string_view text);

/// Does each row of a file have a time of its own?
enum class RowTimes { optional, needed };

/// Rows `x_m,y_m` or `x_m,y_m,t_s`, mixed if need be, with or without a header of these names;
/// blank lines are skipped. Errors name the line; a line of more than csv_line_bytes_max bytes is one.
Result<std::vector<Place>> read_places(std::istream& in, const std::string& name,
                                       std::size_t points_max = csv_points_max,
                                       RowTimes times = RowTimes::optional);

/// The same from a file; "-" is standard input.
Result<std::vector<Place>> read_places(const std::string& path,
                                       RowTimes times = RowTimes::optional);

} // namespace seaway::client
