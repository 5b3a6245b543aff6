// SPDX-License-Identifier: Apache-2.0
// Strict reading of small tables of numbers: '#' lines are notes, then a header, then rows.
#pragma once

#include <cstddef>
#include <iosfwd>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace seaway {

struct CsvTable {
    std::string name; ///< quoted in errors
    std::vector<std::string> columns;
    std::vector<std::vector<double>> rows; ///< finite numbers, one a column
    std::vector<int> lines;                ///< line of each row in the text

    std::optional<std::size_t> column(std::string_view title) const;
    /// "name:line: what"
    Error error(std::size_t row, const std::string& what) const;
};

/// Of files of points, which are read row by row.
inline constexpr std::size_t csv_points_max = 10'000'000;
inline constexpr std::size_t csv_line_bytes_max = 4096;

/// Some programs begin a file of UTF-8 with three bytes that say so.
std::string_view without_mark(std::string_view text);

/// The next line of a stream, without its end; false where there is none. An error says that it has more than
/// csv_line_bytes_max bytes, of which no more are held, or that the stream broke off.
Result<bool> next_line(std::istream& in, std::string& line);

/// Without spaces, tabs and carriage returns around it.
std::string_view trimmed(std::string_view text);
/// A number of at most this magnitude, or none. A plus before it, as people write it, is one; numbers too small for full
/// precision are 0.
std::optional<double> number_in(std::string_view field, double limit);
/// The fields between the commas of a line, trimmed. Views of it.
std::vector<std::string_view> split_csv(std::string_view line);

/// Errors name the line: no header (a first line of numbers alone), no rows, more than `rows_max`, a field that is not a finite
/// number, a row of the wrong length.
Result<CsvTable> parse_csv(std::string_view text, const std::string& name, std::size_t rows_max);

} // namespace seaway
