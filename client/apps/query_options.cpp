// SPDX-License-Identifier: Apache-2.0
#include "client/apps/query_options.h"

#include <algorithm>
#include <cstdio>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "base/text_file.h"
#include "client/url.h"

namespace seaway::client {
namespace {

constexpr double watch_hz_max = 1000;

constexpr const char* footer =
    "One row a point: x_m,y_m,t_s,height_m,normal_x,normal_y,normal_z,velocity_x_mps,\n"
    "velocity_y_mps,velocity_z_mps,error_m,flags. error_m bounds the error of the height.\n"
    "flags is a sum: 1 folded (the highest sheet found; error_m is no bound), 2 not converged\n"
    "(error_m covers it), 4 extrapolated (error_m is no bound), 8 invalid point, 16 exact.\n"
    "JSON is one array, with --watch one a line.\n"
    "Exit codes: 0 done, 2 usage or bad points, 5 cannot connect, lost or no answer in time,\n"
    "6 refused by the server.";

void require(bool fine, const std::string& what) {
    if (!fine)
        throw CLI::ValidationError(what);
}

std::optional<double> parse_time(const std::string& text) {
    if (text == "now")
        return std::nullopt;
    const std::optional<double> time_s = parse_number(text, time_max_s);
    require(time_s.has_value(),
            fmt::format("--time '{}': 'now', or sea time in seconds between {:g} and {:g}", text,
                        -time_max_s, time_max_s));
    return time_s;
}

Format parse_format(const std::string& text) {
    if (text == "json")
        return Format::json;
    if (text == "csv")
        return Format::csv;
    require(text == "table", fmt::format("--format '{}': table, json or csv", text));
    return Format::table;
}

/// --at takes any number of points, and so may swallow an address that follows it.
void read_places(std::vector<std::string> words, QueryOptions& options) {
    for (const std::string& word : words) {
        if (options.url.empty() && word.find("://") != std::string::npos) {
            options.url = word;
            continue;
        }
        const Result<Place> place = parse_place(word);
        require(place.has_value(), place ? "" : "--at: " + place.error().message);
        options.at.push_back(*place);
    }
}

/// "-.5,3" after another point looks like an option to the parser; "--at=-.5,3" does not.
std::vector<std::string> with_negative_points_marked(int argc, const char* const* argv) {
    std::vector<std::string> words(argv + 1, argv + argc);
    for (std::size_t i = 1; i < words.size(); ++i) {
        const std::string& word = words[i];
        const bool point = word.size() > 1 && word[0] == '-' &&
                           word.find_first_of("0123456789.") == 1 &&
                           word.find(',') != std::string::npos;
        if (point && words[i - 1] != "--at")
            words[i] = "--at=" + word;
    }
    return words;
}

void check(const QueryOptions& options) {
    if (options.url.empty())
        throw CLI::RequiredError("URL");
    const Result<Url> url = parse_url(options.url);
    require(url.has_value(), url ? "" : url.error().message);
    const bool places = !options.at.empty() || !options.points_file.empty();
    require(options.at.empty() || options.points_file.empty(),
            "--at and --points exclude each other");
    require(places || options.bench_points > 0,
            "nothing to ask: give --at X,Y or --points FILE.csv");
    require(!(places && options.bench_points > 0), "--bench takes no --at and no --points");
    require(!(options.exact && options.local),
            "--exact and --local exclude each other: only the server has the exact sum");
    require(options.watch_hz >= 0 && options.watch_hz <= watch_hz_max,
            fmt::format("--watch {}: between 0 and {} Hz", options.watch_hz, watch_hz_max));
    require(options.timeout_s > 0 && options.timeout_s <= 86400,
            fmt::format("--timeout {}: above 0, up to 86400 s", options.timeout_s));
}

} // namespace

std::variant<QueryOptions, int> read_query_options(int argc, const char* const* argv) {
    QueryOptions options;
    std::vector<std::string> at;
    std::string time = "now";
    std::string format = "table";
    CLI::App app{"Asks a running sea for its surface above points: height, normal, velocity."};
    app.name("seaway-query");
    app.set_version_flag("--version", std::string("seaway-query ") + SEAWAY_VERSION);
    app.add_option("url", options.url, "Server: ws://HOST:PORT or wss://HOST:PORT")
        ->type_name("URL");
    app.add_option("--at", at, "Points, metres east and north; may be given again")
        ->type_name("X,Y ...");
    app.add_option("--points", options.points_file,
                   "Rows x_m,y_m or x_m,y_m,t_s, with or without that header ('-': stdin)")
        ->type_name("FILE.csv");
    app.add_option("--time", time, "Sea time of points without their own")
        ->type_name("now|SECONDS")
        ->capture_default_str();
    app.add_flag("--exact", options.exact, "The server sums all waves directly, in double");
    app.add_flag("--local", options.local, "This client answers, from streamed tiles");
    app.add_option("--format", format, "How rows are written")
        ->type_name("table|json|csv")
        ->capture_default_str();
    app.add_option("--watch", options.watch_hz,
                   "Repeat at this rate until stopped; times move on with the clock")
        ->type_name("HZ");
    app.add_option("--bench", options.bench_points,
                   "Measure rates with queries of this many random points instead")
        ->type_name("POINTS")
        ->check(CLI::Range(1, 1000000));
    app.add_option("--timeout", options.timeout_s, "Patience with each request")
        ->type_name("SECONDS")
        ->capture_default_str();
    app.add_option("--token-file", options.token_file, "File with the token the server asks for")
        ->type_name("FILE");
    app.add_option("--ca-file", options.ca_file, "Certificates (PEM) to trust, for wss")
        ->type_name("FILE");
    app.footer(footer);
    try {
        std::vector<std::string> words = with_negative_points_marked(argc, argv);
        std::reverse(words.begin(), words.end()); // as the parser wants them
        app.parse(std::move(words));
        read_places(std::move(at), options);
        options.time_s = parse_time(time);
        options.format = parse_format(format);
        check(options);
    } catch (const CLI::Success& asked) {
        return status_after_output("seaway-query", app.exit(asked), exit_usage);
    } catch (const CLI::ParseError& error) {
        fmt::print(stderr, "seaway-query: {} (--help shows how)\n", error.what());
        return exit_usage;
    }
    return options;
}

} // namespace seaway::client
