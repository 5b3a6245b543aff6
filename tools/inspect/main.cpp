// SPDX-License-Identifier: Apache-2.0
// seaway-inspect: what a scene amounts to, without server or GPU. Errors: one line on stderr,
// exit 2; want of memory is one.
#include <charconv>
#include <cstdio>
#include <iostream>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "base/command_line.h"
#include "base/messages.h"
#include "base/text_file.h"
#include "client/apps/query_output.h"
#include "client/apps/query_points.h"
#include "sea/waves/statistics/moments.h"
#include "tools/inspect/images.h"
#include "tools/inspect/picture.h"
#include "tools/inspect/points.h"
#include "tools/inspect/report.h"

namespace {

using namespace seaway;

struct Options {
    std::string scene;
    std::string format = "text";
    std::string spectrum;
    std::string points;
    std::string plot;
    inspect::ImagesOptions images;
    double time_s = 0.0;
};

constexpr int exit_usage = 2;

Result<std::vector<double>> frequencies(const std::string& list) {
    std::vector<double> result;
    const char* at = list.data();
    const char* const end = at + list.size();
    while (true) {
        double omega = 0.0;
        const auto [next, error] = std::from_chars(at, end, omega);
        if (error != std::errc{} || !(omega >= 0.0 && omega <= 1e6) ||
            (next != end && *next != ','))
            return Error{fmt::format("--spectrum '{}': frequencies in rad/s, 0 .. 1e6, with commas "
                                     "between them",
                                     list)};
        result.push_back(omega);
        if (next == end)
            return result;
        at = next + 1;
    }
}

std::string spectrum_csv(const sea::Scene& scene, const std::vector<double>& omegas) {
    std::string out = "omega_radps,s_m2s\n";
    for (const double omega : omegas)
        out +=
            fmt::format("{:.17g},{:.17g}\n", omega, requested_frequency_density(scene.sea, omega));
    return out;
}

Result<std::string> points_csv(const inspect::Report& report, const std::string& path) {
    SEAWAY_TRY_LET(const std::vector<client::Place> places,
                   client::read_places(path, client::RowTimes::needed));
    std::vector<sea::QueryPoint> points;
    for (const client::Place& place : places)
        points.push_back({place.x_m, place.y_m, sea::us_from_seconds(*place.time_s)});
    return client::output_head(client::Format::csv) +
           client::output_rows(
               client::Format::csv, points,
               inspect::answer_points(report.sea, fold_search(report.budget), points), false);
}

Result<std::string> images(const inspect::Report& report, inspect::ImagesOptions options,
                           double time_s) {
    options.time_us = sea::us_from_seconds(time_s);
    const Result<int> files = inspect::write_images(report.sea, options);
    if (!files)
        return files.error();
    return fmt::format("{} files in {}\n", *files, options.folder);
}

/// What is of a time is of one sea here.
Result<void> check_steady(const sea::Scene& scene, const Options& options) {
    if (scene.weather.empty() || (options.points.empty() && options.images.folder.empty()))
        return {};
    return Error{fmt::format("{}: it has a timetable ([[weather]]): which sea there is at a time "
                             "is a server's to say",
                             scene.source)};
}

/// What goes to stdout.
Result<std::string> run(const Options& options) {
    const Result<sea::Scene> scene = sea::read_scene(options.scene);
    if (!scene)
        return scene.error();
    SEAWAY_TRY(check_steady(*scene, options));
    if (!options.plot.empty() && !options.plot.ends_with(".png"))
        return Error{fmt::format("--plot {}: a path that ends in .png", options.plot)};
    std::vector<double> omegas;
    if (!options.spectrum.empty()) {
        SEAWAY_TRY_LET(omegas, frequencies(options.spectrum));
    }
    if (!omegas.empty() && options.plot.empty())
        return spectrum_csv(*scene, omegas);
    const Result<inspect::Report> report = inspect::make_report(*scene);
    if (!report)
        return report.error();
    if (!options.plot.empty())
        SEAWAY_TRY(inspect::draw_picture(*report, options.plot));
    if (!omegas.empty())
        return spectrum_csv(*scene, omegas);
    if (!options.points.empty())
        return points_csv(*report, options.points);
    if (!options.images.folder.empty())
        return images(*report, options.images, options.time_s);
    return options.format == "json" ? inspect::to_json(*report) : inspect::to_text(*report);
}

void declare(CommandLine& line, Options& options) {
    line.option("scene", options.scene, "Scene file (docs/scenes.md)")
        .required()
        .takes("SCENE.toml");
    const CommandOption format =
        line.option("--format", options.format, "Form of the report: text or json")
            .one_of({"text", "json"})
            .takes("FORMAT");
    const CommandOption spectrum = line.option("--spectrum", options.spectrum,
                                               "Print S(w) at these rad/s as CSV omega_radps,s_m2s")
                                       .excludes(format)
                                       .takes("W1,W2,...");
    const CommandOption points =
        line.option("--eval", options.points,
                    "Print the exact surface at rows x_m,y_m,t_s of a CSV file ('-': stdin)")
            .excludes(format)
            .excludes(spectrum)
            .takes("FILE.csv");
    line.option("--plot", options.plot, "Draw spectrum, directions and cascades").takes("FILE.png");
    const CommandOption images =
        line.option("--images", options.images.folder,
                    "Draw h0(k), h(k,t), every pass and every map of each cascade but foam, "
                    "which is a history")
            .excludes(format)
            .excludes(spectrum)
            .excludes(points)
            .takes("DIR");
    line.option("--device", options.images.device,
                "Of --images: native, auto (a GPU, else native), or index or part of a name of a "
                "Vulkan device")
        .needs(images)
        .shows_default()
        .takes("NAME");
    line.option("--time", options.time_s, "Of --images: sea time")
        .needs(images)
        .between(-1e9, 1e9)
        .takes("SECONDS");
}

int fail(const std::string& message) {
    return complain("seaway-inspect", exit_usage, message);
}

int run(int argc, char** argv) {
    Options options;
    CommandLine line("seaway-inspect", "What a scene amounts to, without server or GPU");
    declare(line, options);
    const Result<CommandLine::Next> next = line.read(argc, argv);
    if (!next)
        return fail(next.error().message);
    if (*next == CommandLine::Next::leave)
        return status_after_output("seaway-inspect", 0, exit_usage);
    const Result<std::string> out = run(options);
    if (!out)
        return fail(out.error().message);
    std::cout << *out;
    return status_after_output("seaway-inspect", 0, exit_usage);
}

} // namespace

int main(int argc, char** argv) {
    return run_main("seaway-inspect", exit_usage, [&] { return run(argc, argv); });
}
