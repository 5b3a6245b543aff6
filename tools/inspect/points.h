// SPDX-License-Identifier: Apache-2.0
// The sea at points that a CSV file names, by direct sum in double precision.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "base/result.h"
#include "sea/surface/answer.h"
#include "sea/surface/inverse.h"
#include "sea/waves/realization.h"

namespace seaway::inspect {

/// Rows are at most this far from the origin; beyond, a coordinate resolves no wave.
inline constexpr double coordinate_max_m = 1e9;

/// Rows `x_m,y_m,t_s`, times within sea::time_us_max, with or without that header; blank lines are skipped. Errors name the line; one
/// of more than csv_line_bytes_max bytes is an error, and so are more than csv_points_max points.
Result<std::vector<sea::QueryPoint>> read_points(std::istream& in, const std::string& name);

/// The same from a file; "-" is standard input.
Result<std::vector<sea::QueryPoint>> read_points(const std::string& path);

/// One answer a point, in order, flagged answer_exact; error_m bounds the inverse displacement and
/// rounding. About 1 ms a point, ten where the sea folds often, and 5 ms for each distinct time.
std::vector<sea::Answer> answer_points(const sea::RealizationPtr& sea, const sea::FoldSearch& folds,
                                       const std::vector<sea::QueryPoint>& points);

/// Header and rows as `seaway-query --format csv` prints them, every double in full.
std::string to_csv(const std::vector<sea::QueryPoint>& points,
                   const std::vector<sea::Answer>& answers);

} // namespace seaway::inspect
