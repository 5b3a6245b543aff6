// SPDX-License-Identifier: Apache-2.0
#include "client/apps/query_options.h"

#include <cstdio>

#include <fmt/format.h>

#include "base/command_line.h"
#include "base/messages.h"
#include "base/text_file.h"
#include "client/exit_code.h"
#include "protocol/limits.h"

namespace seaway::client {
namespace {

/// One a day is slower than anybody watches; and no more than a duration holds.
constexpr double watch_hz_min = 1e-5;
constexpr double watch_hz_max = 1000;

constexpr const char* query_footer =
    "One row a point: x_m,y_m,t_s,height_m,normal_x,normal_y,normal_z,velocity_x_mps,\n"
    "velocity_y_mps,velocity_z_mps,error_m,flags. error_m bounds the error of the height.\n"
    "flags is a sum: 1 folded (the highest sheet), 2 not converged (error_m covers it),\n"
    "4 extrapolated (error_m is no bound), 8 invalid point, 16 exact, 32 vertical velocity\n"
    "alone, 64 open (which of two sheets is the highest; error_m is no bound), 128 stale\n"
    "(the server may lack changes; error_m grows with them).\n"
    "With --z: x_m,y_m,t_s,z_m,surface_m,velocity_x_mps,velocity_y_mps,velocity_z_mps,\n"
    "pressure_m2ps2,flags: velocity of the water there and its dynamic pressure over density, by\n"
    "linear theory; no bound is stated. Flag 256: there is no water, all are 0.\n"
    "JSON is one array, with --watch one a line.\n"
    "Exit codes: 0 done, 1 cannot write or no memory, 2 usage or bad points, 5 cannot connect, "
    "lost or no "
    "answer in time,\n"
    "6 refused by the server.";

Result<void> require(bool fine, const std::string& what) {
    if (!fine)
        return Error{what};
    return {};
}

Result<std::optional<double>> parse_time(const std::string& text) {
    if (text == "now")
        return std::optional<double>();
    const std::optional<double> time_s = number_in(text, sea::time_max_s);
    SEAWAY_TRY(
        require(time_s.has_value(),
                fmt::format("--time '{}': 'now', or sea time in seconds between {:g} and {:g}",
                            text, -sea::time_max_s, sea::time_max_s)));
    return time_s;
}

Result<std::optional<double>> parse_z(const std::string& text) {
    if (text.empty())
        return std::optional<double>();
    constexpr double most_m = protocol::limits::position_m_max;
    const std::optional<double> z_m = number_in(text, most_m);
    SEAWAY_TRY(require(z_m.has_value(),
                       fmt::format("--z '{}': metres up from still water, between {:g} and {:g}",
                                   text, -most_m, most_m)));
    return z_m;
}

Result<Format> parse_format(const std::string& text) {
    if (text == "json")
        return Format::json;
    if (text == "csv")
        return Format::csv;
    SEAWAY_TRY(require(text == "table", fmt::format("--format '{}': table, json or csv", text)));
    return Format::table;
}

Result<Source> parse_source(const std::string& text) {
    if (text == "scene")
        return Source::scene;
    if (text == "spectrum")
        return Source::spectrum;
    SEAWAY_TRY(
        require(text == "tiles", fmt::format("--from '{}': tiles, spectrum or scene", text)));
    return Source::tiles;
}

/// --at takes any number of points, and so may swallow an address that follows it.
Result<void> read_places(const std::vector<std::string>& words, QueryOptions& options) {
    for (const std::string& word : words) {
        if (options.url.empty() && word.find("://") != std::string::npos) {
            options.url = word;
            continue;
        }
        const Result<Place> place = parse_place(word);
        if (!place)
            return Error{"--at: " + place.error().message};
        options.at.push_back(*place);
    }
    return {};
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

Result<void> check(const QueryOptions& options) {
    if (options.url.empty())
        return Error{"URL is required"};
    SEAWAY_TRY(options.ServerOptions::check());
    const bool places = !options.at.empty() || !options.points_file.empty();
    SEAWAY_TRY(require(options.at.empty() || options.points_file.empty(),
                       "--at and --points exclude each other"));
    SEAWAY_TRY(require(places || options.bench_points > 0,
                       "nothing to ask: give --at X,Y or --points FILE.csv"));
    SEAWAY_TRY(
        require(!(places && options.bench_points > 0), "--bench takes no --at and no --points"));
    SEAWAY_TRY(
        require(!(options.exact && options.local),
                "--exact and --local exclude each other: only the server has the exact sum"));
    SEAWAY_TRY(require(options.local || options.source == Source::tiles,
                       "--from says what --local answers from"));
    SEAWAY_TRY(require(options.bench_points == 0 || (options.min_wavelength_m == 0 && !options.z_m),
                       "--bench measures answers of the surface, of all waves: it takes no "
                       "--min-wavelength and no --z"));
    SEAWAY_TRY(
        require(options.bench_points == 0 || (options.watch_hz == 0 && !options.time_s),
                "--bench asks about the present, as often as it can: it takes no --watch and "
                "no --time"));
    SEAWAY_TRY(require(!options.z_m || !options.local || options.source != Source::tiles,
                       "--z: the water below the surface follows from waves: with --local it "
                       "needs --from spectrum or scene"));
    SEAWAY_TRY(options.limits.check());
    const bool limited = options.limits.rate_hz_max != 0 || options.limits.size_max != 0;
    const bool streamed = options.local && options.watch_hz > 0 && options.source == Source::tiles;
    SEAWAY_TRY(require(!limited || streamed,
                       "--rate-max and --size-max limit a stream: they need --local --watch"));
    return {};
}

/// Options that need reading once more.
struct QueryWords {
    std::vector<std::string> at;
    std::string time = "now";
    std::string format = "table";
    std::string source = "tiles";
    std::string z;
};

Result<void> take(const QueryWords& words, QueryOptions& options) {
    SEAWAY_TRY(read_places(words.at, options));
    SEAWAY_TRY_LET(options.time_s, parse_time(words.time));
    SEAWAY_TRY_LET(options.format, parse_format(words.format));
    SEAWAY_TRY_LET(options.source, parse_source(words.source));
    SEAWAY_TRY_LET(options.z_m, parse_z(words.z));
    return check(options);
}

} // namespace

std::variant<QueryOptions, int> read_query_options(int argc, const char* const* argv) {
    QueryOptions options;
    QueryWords words;
    CommandLine line("seaway-query",
                     "Asks a running sea for its surface above points: height, normal, velocity.");
    line.option("url", options.url, "Server: ws://HOST:PORT or wss://HOST:PORT").takes("URL");
    line.option("--at", words.at, "Points, metres east and north; may be given again")
        .takes("X,Y ...");
    line.option("--points", options.points_file,
                "Rows x_m,y_m or x_m,y_m,t_s, with or without that header ('-': stdin)")
        .takes("FILE.csv");
    line.option("--time", words.time, "Sea time of points without their own")
        .takes("now|SECONDS")
        .shows_default();
    line.option("--exact", options.exact, "The server sums all waves directly, in double");
    line.option("--local", options.local, "This client answers, the server only sends");
    line.option("--from", words.source,
                "With --local: from streamed tiles, from the waves as the server sends them, or "
                "from the "
                "waves of its scene, made here; waves are held against the server's probes")
        .takes("tiles|spectrum|scene")
        .shows_default();
    line.option("--min-wavelength", options.min_wavelength_m,
                "Leave out cascades all of whose waves are shorter: what a hull does not feel")
        .takes("METRES")
        .between(0.0, protocol::limits::position_m_max);
    line.option("--z", words.z,
                "The water there instead of the surface: metres up from still water, so below 0")
        .takes("METRES");
    line.option("--format", words.format, "How rows are written")
        .takes("table|json|csv")
        .shows_default();
    line.option("--watch", options.watch_hz,
                "Repeat at this rate until stopped, also after the server was; times move on with "
                "the clock")
        .takes("HZ")
        .between(watch_hz_min, watch_hz_max);
    options.limits.describe(line);
    line.option(
            "--bench", options.bench_points,
            "Measure rates with queries of this many random points instead; a server takes 4096 at "
            "once")
        .takes("POINTS")
        .between(1, 1000000);
    options.describe(line, "the token that the server asks for");
    line.footer(query_footer);
    const Result<CommandLine::Next> next = line.read(with_negative_points_marked(argc, argv));
    if (next && *next == CommandLine::Next::leave)
        return status_after_output("seaway-query", exit_done, exit_output);
    const Result<void> fine = next ? take(words, options) : Result<void>(next.error());
    if (!fine)
        return complain("seaway-query", exit_usage, fine.error().message + " (--help shows how)");
    return options;
}

} // namespace seaway::client
