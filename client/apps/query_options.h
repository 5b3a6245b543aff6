// SPDX-License-Identifier: Apache-2.0
// The command line of seaway-query.
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "client/apps/query_points.h"
#include "client/exit_code.h"
#include "client/server_options.h"
#include "client/tile_limits.h"

namespace seaway::client {

/// What this client answers from where it answers itself.
enum class Source { tiles, spectrum, scene };

enum class Format { table, json, csv };

struct QueryOptions : ServerOptions {
    QueryOptions() { timeout_s = 10; }

    std::vector<Place> at;
    std::string points_file;      ///< CSV; "-" is standard input
    std::optional<double> time_s; ///< nothing: now
    bool exact = false;
    bool local = false;
    Source source = Source::tiles;
    double min_wavelength_m = 0; ///< 0: all waves count
    std::optional<double> z_m;   ///< the water there is asked for, not the surface
    Format format = Format::table;
    double watch_hz = 0;  ///< 0: once
    int bench_points = 0; ///< 0: no benchmark
    TileLimits limits;    ///< of what is streamed
};

/// The options, or the exit code after --help, --version (0) or a usage error (2), which has been
/// printed.
std::variant<QueryOptions, int> read_query_options(int argc, const char* const* argv);

} // namespace seaway::client
