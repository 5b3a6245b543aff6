// SPDX-License-Identifier: Apache-2.0
// Answers as text. JSON and CSV carry every double in full: the shortest digits that read back as
// the same value; the table is rounded for reading. Pure; thread-safe.
#pragma once

#include <span>
#include <string>

#include "client/apps/query_options.h"
#include "client/looks.h"
#include "sea/surface/answer.h"

namespace seaway::client {

/// What comes once, before the first rows: the header of CSV. `below`: of rows of water below the surface.
std::string output_head(Format format, bool below = false);

/// One answer a point. JSON: one array, its objects on lines of their own, or all on one line with
/// `compact`; what is not a number is null.
std::string output_rows(Format format, std::span<const sea::QueryPoint> points,
                        std::span<const sea::Answer> answers, bool compact);

/// The same of the water at `z_m`.
std::string output_rows(Format format, std::span<const sea::QueryPoint> points, double z_m,
                        const Below& found, bool compact);

/// "folded extrapolated", "-" for none.
std::string flag_names(std::uint32_t flags);

/// The result of one way to ask in a benchmark.
struct BenchRow {
    std::string how; ///< "server", "exact" or "local"
    int points_per_query = 0;
    int in_flight = 0; ///< queries at once
    int queries = 0;
    double seconds = 0;
    double round_trip_p50_ms = 0;
    double round_trip_p99_ms = 0;

    double points_per_s() const {
        return queries * static_cast<double>(points_per_query) / seconds;
    }
};
std::string output_bench(Format format, std::span<const BenchRow> rows);

} // namespace seaway::client
