// SPDX-License-Identifier: Apache-2.0
#include "client/view/view_options.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>

#include "base/command_line.h"
#include "base/messages.h"
#include "base/text_file.h"
#include "client/view/film_file.h"
#include "client/view/look_options.h"
#include "client/view/option_words.h"

namespace seaway::client {

namespace {

constexpr int side_max = 16384;

constexpr const char* footer =
    "Yaw is a bearing (0 north, 90 east), pitch is positive upwards. The hour is solar time on "
    "the\n"
    "day of equinox at 45 degrees north: sunrise at 6 in the east, noon 45 degrees high. Frame n\n"
    "is the sea n/fps after --time. In --out, #### or %04d is the frame's number. PNG is sRGB, "
    "EXR\n"
    "holds linear numbers. Options win over the file of --look. Without --offscreen a window "
    "opens;\n"
    "it connects again by itself.\n"
    "Exit codes: 0 done or closed, 1 cannot write or no memory, 2 usage, 3 no usable device or no "
    "display,\n"
    "5 cannot connect or lost, 6 refused by the server.";

Result<void> read_size(const char* option, const std::string& text, Camera& camera) {
    const std::size_t x = text.find('x');
    double width = 0, height = 0;
    SEAWAY_TRY(require(x != std::string::npos && parse_number(text.substr(0, x), width) &&
                           parse_number(text.substr(x + 1), height) && width == std::floor(width) &&
                           height == std::floor(height) && width >= 16 && height >= 16 &&
                           width <= side_max && height <= side_max,
                       fmt::format("{} {}: WIDTHxHEIGHT, each 16 .. {}", option, text, side_max)));
    camera.width = static_cast<int>(width);
    camera.height = static_cast<int>(height);
    return {};
}

Result<void> read_camera(const std::string& text, Camera& camera) {
    std::array<double, 5> v{};
    std::size_t count = 0, from = 0;
    while (count < v.size() && from <= text.size()) {
        const std::size_t comma = std::min(text.find(',', from), text.size());
        if (!parse_number(std::string_view(text).substr(from, comma - from), v[count]))
            break;
        ++count;
        from = comma + 1;
    }
    SEAWAY_TRY(require(count == v.size() && from == text.size() + 1,
                       fmt::format("--camera {}: five numbers X,Y,Z,YAW_DEG,PITCH_DEG", text)));
    SEAWAY_TRY(
        require(std::abs(v[0]) <= camera_place_max_m && std::abs(v[1]) <= camera_place_max_m,
                fmt::format("--camera {}: X and Y are within {:g} m", text, camera_place_max_m)));
    SEAWAY_TRY(require(v[2] >= camera_height_min_m && v[2] <= camera_height_max_m,
                       fmt::format("--camera {}: Z is {:g} .. {:g} m", text, camera_height_min_m,
                                   camera_height_max_m)));
    SEAWAY_TRY(require(std::abs(v[3]) <= camera_yaw_max_deg,
                       fmt::format("--camera {}: YAW_DEG is {:g} .. {:g}", text,
                                   -camera_yaw_max_deg, camera_yaw_max_deg)));
    SEAWAY_TRY(require(std::abs(v[4]) <= camera_pitch_max_deg,
                       fmt::format("--camera {}: PITCH_DEG is -89 .. 89", text)));
    camera.x_m = v[0];
    camera.y_m = v[1];
    camera.z_m = v[2];
    camera.yaw_deg = v[3];
    camera.pitch_deg = v[4];
    return {};
}

Result<void> read_time(const std::string& text, ViewOptions& options) {
    double time_s = 0;
    if (text.empty() || text == "now")
        return {};
    SEAWAY_TRY(require(parse_number(text, time_s) && std::abs(time_s) <= sea::time_max_s,
                       fmt::format("--time {}: 'now', or sea time in seconds between {:g} and {:g}",
                                   text, -sea::time_max_s, sea::time_max_s)));
    options.time_s = time_s;
    return {};
}

/// Options that need reading once more.
struct Words {
    std::string size, window, camera, debug = "final", time, quality, rate;
    int first = -1;
    LookWords look;
    bool list = false;
};

Result<void> check_frames(const ViewOptions& options) {
    SEAWAY_TRY(require(options.frames >= 1 && options.frames <= frames_max,
                       fmt::format("--frames {}: 1 .. {}", options.frames, frames_max)));
    if (options.first) {
        SEAWAY_TRY(require(*options.first + options.frames <= frames_max,
                           fmt::format("--first {} --frames {}: frames are numbered 0 .. {}",
                                       *options.first, options.frames, frames_max - 1)));
        // Pieces are of one film: what each of them would begin with anew is not of it.
        SEAWAY_TRY(require(options.time_s || !options.scene.empty(),
                           "--first needs --time SECONDS, the sea time of frame 0: now is another "
                           "one for each piece"));
        SEAWAY_TRY(require(!options.turntable,
                           "--first and --turntable, which turns once in --frames: give --path"));
        SEAWAY_TRY(require(options.bench_frames == 0, "--first and --bench: one of them"));
    }
    const double last_s = options.rate.offset_s(
        std::max(options.frame(options.frames - 1), options.bench_frames - 1));
    return require(options.time_s.value_or(0) + last_s <= sea::time_max_s,
                   fmt::format("--frames {}: the last is {} s after --time {}; sea time ends at "
                               "{:g} s",
                               options.frames, last_s, options.time_s.value_or(0),
                               sea::time_max_s));
}

/// What is of files alone.
Result<void> check_files(const Words& words, const ViewOptions& options) {
    const std::string ending = std::filesystem::path(options.out).extension().string();
    SEAWAY_TRY(require(options.bench_frames >= 0 && options.bench_frames <= frames_max,
                       fmt::format("--bench {}: 1 .. {}", options.bench_frames, frames_max)));
    SEAWAY_TRY(require(
        options.bench_frames > 0 || ending == ".png" || ending == ".exr" || is_film(options.out),
        fmt::format("--out '{}': a path that ends in .png, .exr, .mp4 or .webm", options.out)));
    SEAWAY_TRY(
        require(!options.sheet || ending != ".exr",
                fmt::format("--debug all --out '{}': a sheet has no numbers: .png, or a film",
                            options.out)));
    SEAWAY_TRY(require(!options.sheet || options.bench_frames == 0,
                       "--debug all and --bench: one of them"));
    SEAWAY_TRY(
        require(options.bench_frames == 0 || info(options.debug.view).source != DebugSource::table,
                fmt::format("--debug {} and --bench: a table is computed, not drawn; one "
                            "of them",
                            debug_text(options.debug))));
    SEAWAY_TRY(require(options.bench_frames == 0 || options.out.empty(),
                       "--out and --bench: what is measured is not written; one of them"));
    const std::pair<bool, const char*> of_films[] = {{options.frames != 1, "--frames"},
                                                     {!options.path.empty(), "--path"},
                                                     {options.turntable, "--turntable"}};
    for (const auto& [given, name] : of_films)
        SEAWAY_TRY(require(options.bench_frames == 0 || !given,
                           fmt::format("{} and --bench: as many frames as that says are measured, "
                                       "from one place; one of them",
                                       name)));
    SEAWAY_TRY(require(
        options.bench_frames > 0 || ending != ".exr" || words.look.exposure.empty(),
        fmt::format("--exposure and --out {}: an .exr holds the radiance itself, without exposure",
                    options.out)));
    SEAWAY_TRY(
        require(options.path.empty() || !options.turntable, "--path and --turntable: one of them"));
    return check_frames(options);
}

/// A window shows the sea of now and writes nothing: what is of files alone is not passed over in silence.
Result<void> check_window(const Words& words, const ViewOptions& options) {
    const std::pair<bool, const char*> of_files[] = {
        {!options.out.empty(), "--out"},
        {options.frames != 1, "--frames"},
        {options.first.has_value(), "--first"},
        {!words.rate.empty(), "--fps"},
        {options.bench_frames != 0, "--bench"},
        {!options.path.empty(), "--path"},
        {options.turntable, "--turntable"},
        {!words.time.empty() && words.time != "now" && options.scene.empty(), "--time"},
        {options.sheet, "--debug all"}};
    for (const auto& [given, name] : of_files)
        SEAWAY_TRY(require(!given, fmt::format("{} is of pictures in files: give --offscreen "
                                               "WxH, too",
                                               name)));
    return {};
}

/// A server's sea, or one that is made here: what is of servers alone is not passed over in silence.
Result<void> check_source(const Words& words, const ViewOptions& options) {
    if (options.scene.empty()) {
        SEAWAY_TRY(require(!options.url.empty(), "URL is required, or --scene FILE"));
        return options.ServerOptions::check();
    }
    SEAWAY_TRY(require(options.url.empty(), "URL and --scene: one of them"));
    const std::pair<bool, const char*> of_servers[] = {
        {!options.token_file.empty(), "--token-file"},
        {!options.ca_file.empty(), "--ca-file"},
        {options.timeout_s != ViewOptions().timeout_s, "--timeout"},
        {words.time == "now", "--time now"},
        {options.limits.rate_hz_max != 0, "--rate-max"},
        {options.limits.size_max != 0, "--size-max"}};
    for (const auto& [given, name] : of_servers)
        SEAWAY_TRY(require(!given, fmt::format("{} is of a server: --scene has none", name)));
    return {};
}

Result<void> check(const Words& words, const ViewOptions& options) {
    SEAWAY_TRY(check_source(words, options));
    SEAWAY_TRY(options.limits.check());
    SEAWAY_TRY(require(options.camera.view_deg >= camera_view_min_deg &&
                           options.camera.view_deg <= camera_view_max_deg,
                       fmt::format("--fov {}: {} .. {} degrees", options.camera.view_deg,
                                   camera_view_min_deg, camera_view_max_deg)));
    return options.offscreen ? check_files(words, options) : check_window(words, options);
}

Result<void> take(const Words& words, ViewOptions& options) {
    options.offscreen = !words.size.empty();
    SEAWAY_TRY(require(!options.offscreen || words.window.empty(),
                       "--offscreen and --window: one of them"));
    if (options.offscreen)
        SEAWAY_TRY(read_size("--offscreen", words.size, options.camera));
    else
        SEAWAY_TRY(read_size("--window", words.window.empty() ? "1280x720" : words.window,
                             options.camera));
    if (!words.camera.empty())
        SEAWAY_TRY(read_camera(words.camera, options.camera));
    SEAWAY_TRY(read_time(words.time, options));
    if (words.first >= 0)
        options.first = words.first;
    if (!words.rate.empty()) {
        SEAWAY_TRY_LET(options.rate, parse_frame_rate("--fps", words.rate));
    }
    options.sheet = words.debug == "all";
    if (!options.sheet) {
        SEAWAY_TRY_LET(options.debug, parse_debug_view(words.debug));
    }
    options.quality = quality_table[options.offscreen ? quality_high : quality_default];
    if (!words.quality.empty()) {
        SEAWAY_TRY_LET(options.quality, parse_quality(words.quality));
    }
    options.look_path = words.look.path;
    SEAWAY_TRY(words.look.take(options.look, options.cell_pixels));
    options.quality = options.as_dense(options.quality);
    if (options.offscreen && options.out.ends_with(".exr"))
        options.quality.scale = 1; // numbers are not enlarged: there are as many as were asked for
    return check(words, options);
}

/// Where the number of a frame goes: #### or %04d in the name of a file.
struct NumberField {
    std::size_t first, end, digits;
};

std::optional<NumberField> number_field(const std::string& pattern) {
    const std::size_t from = pattern.rfind('/') + 1; // 0 where there is no folder
    if (const std::size_t hash = pattern.find('#', from); hash != std::string::npos) {
        const std::size_t end = std::min(pattern.find_first_not_of('#', hash), pattern.size());
        return NumberField{hash, end, end - hash};
    }
    for (std::size_t percent = pattern.find('%', from); percent != std::string::npos;
         percent = pattern.find('%', percent + 1)) {
        std::size_t end = percent + 1, digits = 0;
        while (end < pattern.size() && pattern[end] >= '0' && pattern[end] <= '9' && digits < 100)
            digits = 10 * digits + static_cast<std::size_t>(pattern[end++] - '0');
        if (end < pattern.size() && pattern[end] == 'd')
            return NumberField{percent, end + 1, std::max<std::size_t>(digits, 1)};
    }
    return std::nullopt;
}

void list_debug() {
    for (const DebugViewInfo& row : debug_view_table()) {
        fmt::print("{:<18}{}\n", row.name, row.meaning);
        if (const std::string keys = keys_text(row); !keys.empty())
            fmt::print("{:<18}  {}\n", "", keys);
    }
    fmt::print("{:<18}{}\n", "all", "a sheet of every view, in one picture");
}

void describe(CommandLine& line, Words& words, ViewOptions& options) {
    line.option("URL", options.url, "ws://HOST:PORT or wss://HOST:PORT");
    line.option(
            "--scene", options.scene,
            "scene file: the sea is made here, on the device that draws, and no server is asked")
        .takes("FILE");
    line.option("--window", words.window, "size of the window, WIDTHxHEIGHT (1280x720)");
    line.option("--offscreen", words.size, "draw to files: size of the picture, WIDTHxHEIGHT");
    line.option("--frames", options.frames, "number of frames");
    line.option("--first", words.first,
                "number of the first of them, of a film that is drawn in pieces (0)")
        .takes("N")
        .between(0, frames_max - 1);
    line.option("--fps", words.rate, "frames a second of sea time, also N/D as 24000/1001 (30)")
        .takes("F");
    line.option("--out", options.out,
                "where frames go: a pattern ending in .png or .exr, or a film, .mp4 or .webm")
        .takes("FILE");
    line.option("--path", options.path,
                "CSV file with the camera over time: t_s,x_m,y_m,z_m,yaw_deg,pitch_deg[,fov_deg]")
        .takes("FILE");
    line.option("--turntable", options.turntable, "go once around what the camera looks at");
    line.option("--camera", words.camera,
                "X,Y,Z,YAW_DEG,PITCH_DEG: m east, north, above the mean sea, or below it");
    line.option("--fov", options.camera.view_deg, "width of the picture, degrees (62)");
    words.look.describe(line);
    line.option("--time", words.time, "sea time of frame 0: 'now' or seconds; a scene begins at 0");
    line.option(
        "--quality", words.quality,
        "low, default, high or film: how much work a frame is (window: default, files: high)");
    line.option("--bench", options.bench_frames,
                "draw so many frames instead of files, print what each pass takes");
    line.option("--debug", words.debug, "what to show: VIEW[:key=value,...] or all (--list-debug)");
    line.option("--list-debug", words.list, "print the views of --debug and exit");
    line.option("--device", options.device, "Vulkan device: auto, an index, or part of a name");
    options.limits.describe(line);
    options.describe(line, "the token that the server asks for");
}

} // namespace

std::variant<ViewOptions, int> read_view_options(int argc, const char* const* argv) {
    ViewOptions options;
    options.camera.yaw_deg = 215;
    options.camera.z_m = 12;
    options.camera.pitch_deg = -6;
    Words words;
    CommandLine line(
        "seaway-view",
        "Shows the sea of a running server, or of a scene: in a window, or drawn to files.");
    line.footer(footer);
    describe(line, words, options);
    const Result<CommandLine::Next> next = line.read(argc, argv);
    const bool leave = next && *next == CommandLine::Next::leave;
    if (next && !leave && words.list)
        list_debug();
    if (next && !leave && words.look.list)
        list_look_keys();
    if (leave || (next && (words.list || words.look.list)))
        return status_after_output("seaway-view", exit_done, exit_output);
    const Result<void> fine = next ? take(words, options) : Result<void>(next.error());
    if (!fine)
        return complain("seaway-view", exit_usage, fine.error().message);
    return options;
}

std::string frame_path(const std::string& pattern, int frame, bool numbered) {
    if (const std::optional<NumberField> field = number_field(pattern))
        return pattern.substr(0, field->first) + fmt::format("{:0{}}", frame, field->digits) +
               pattern.substr(field->end);
    if (!numbered)
        return pattern;
    const std::size_t dot = pattern.rfind('.');
    return pattern.substr(0, dot) + fmt::format("-{:04}", frame) + pattern.substr(dot);
}

} // namespace seaway::client
