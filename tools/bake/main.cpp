// SPDX-License-Identifier: Apache-2.0
// seaway-bake: a scene as OpenEXR maps, without a server. Errors: one line on stderr; exit 2 for
// usage and scenes, 3 where there is no such device, 4 for files and a device that fails.
#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <thread>

#include <fmt/format.h>

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wold-style-cast"
#include <OpenEXR/ImfThreading.h>
#pragma GCC diagnostic pop

#include "base/command_line.h"
#include "base/messages.h"
#include "base/processors.h"
#include "base/stop_wanted.h"
#include "base/text_file.h"
#include "sea/certificate/certificate.h"
#include "sea/foam/foam_law.h"
#include "server/device/device_choice.h"
#include "tools/bake/bake.h"
#include "tools/bake/tile_files.h"

namespace {

using namespace seaway;

constexpr int exit_usage = 2;
constexpr int exit_no_device = 3;
constexpr int exit_failed = 4;

constexpr const char* default_fields =
    "height,displacement_x,displacement_y,slope_x,slope_y,jacobian";

struct Options {
    std::string scene;
    std::string device = "native";
    std::string fields = default_fields;
    std::string fps;
    std::string compression = "none";
    std::string channels = "names";
    std::string mesh = "none";
    std::string up = "z";
    std::string top = "south";
    double start_s = 0;
    int size = 0;
    bake::BakeOptions bake;
};

void declare(CommandLine& line, Options& o) {
    line.option("scene", o.scene, "Scene file (docs/scenes.md)").required().takes("SCENE.toml");
    line.option("--out", o.bake.folder, "Folder for the files").required().takes("DIR");
    line.option("--frames", o.bake.frames, "How many").required().takes("N");
    line.option("--first", o.bake.first, "Number of the first of them, of a film in pieces")
        .shows_default()
        .takes("N");
    line.option("--fps", o.fps, "Frames a second of sea time, also N/D as 24000/1001")
        .required()
        .takes("F");
    line.option("--start", o.start_s, "Sea time of frame 0")
        .takes("SECONDS")
        .between(-bake::time_max_s, bake::time_max_s);
    line.option("--size", o.size, "Grid points a side of every cascade, instead of the scene's")
        .one_of({64, 128, 256, 512, 1024, 2048})
        .takes("N");
    line.option("--fields", o.fields, "Names with commas between them, or all")
        .shows_default()
        .takes("LIST");
    line.option("--half", o.bake.half, "16 bits a value instead of 32");
    line.option("--compression", o.compression, "none, rle, zip or piz")
        .shows_default()
        .takes("NAME");
    line.option(
        "--summed", o.bake.summed,
        "The sea on the square of the longest tile, all cascades together: sea.<frame>.exr");
    line.option("--channels", o.channels,
                "names: a channel a field. rgb: R, G, B say where a point goes, choppiness "
                "applied, A is foam if it is among the fields")
        .one_of({"names", "rgb"})
        .shows_default()
        .takes("NAMING");
    line.option("--mesh", o.mesh, "none, obj or ply: every tile as geometry beside its maps")
        .shows_default()
        .takes("FORMAT");
    line.option("--up", o.up,
                "Axis that is up in meshes and rgb: z (east, north, up) or y "
                "(east, up, south)")
        .one_of({"z", "y"})
        .shows_default()
        .takes("AXIS");
    line.option("--top", o.top, "First line of the images: the south or the north of the tile")
        .one_of({"south", "north"})
        .shows_default()
        .takes("SIDE");
    line.option("--device", o.device,
                "native, auto (a GPU, else native), or index or part of a name of a Vulkan device")
        .shows_default()
        .takes("NAME");
}

int fail(int code, const std::string& message) {
    return complain("seaway-bake", code, message);
}

/// What would change nothing is not passed over in silence.
Result<void> check_effect(const Options& o) {
    if (o.up == "y" && o.channels == "names" && o.mesh == "none")
        return Error{"--up y is of --channels rgb and of --mesh: neither is given"};
    if (o.channels != "rgb" || o.fields == default_fields || o.fields == "all")
        return {};
    SEAWAY_TRY_LET(const sea::FieldSet fields, bake::parse_fields(o.fields));
    for (const sea::Field field : fields)
        if (field != sea::Field::foam && !bake::vector_fields.contains(field))
            return Error{fmt::format("--channels rgb has no {} of --fields: it is displacement, "
                                     "height and foam",
                                     sea::info(field).name)};
    return {};
}

int run(Options& options) {
    if (const Result<void> acts = check_effect(options); !acts)
        return fail(exit_usage, acts.error().message);
    Result<sea::Scene> scene = sea::read_scene(options.scene);
    if (!scene)
        return fail(exit_usage, scene.error().message);
    if (const auto certificate = sea::load_certificate(*scene); !certificate)
        return fail(exit_usage, certificate.error().message);
    for (sea::CascadeSpec& cascade : scene->cascades)
        cascade.size = options.size > 0 ? options.size : cascade.size;
    Result<sea::FieldSet> fields = bake::parse_fields(options.fields);
    if (!fields)
        return fail(exit_usage, fields.error().message);
    if (options.fields == "all" && !sea::has_foam(scene->effects))
        fields = fields->without({sea::Field::foam});
    const Result<bake::FrameRate> rate = client::parse_frame_rate("--fps", options.fps);
    if (!rate)
        return fail(exit_usage, rate.error().message);
    const Result<exr::ExrCompression> compression = exr::exr_compression(options.compression);
    if (!compression)
        return fail(exit_usage, compression.error().message);
    const Result<bake::MeshFormat> mesh = bake::mesh_format(options.mesh);
    if (!mesh)
        return fail(exit_usage, mesh.error().message);
    options.bake.mesh = *mesh;
    options.bake.vectors = options.channels == "rgb";
    options.bake.up = options.up == "y" ? bake::UpAxis::y : bake::UpAxis::z;
    options.bake.north_up = options.top == "north";
    options.bake.fields = *fields;
    options.bake.rate = *rate;
    options.bake.compression = *compression;
    options.bake.start_us = sea::us_from_seconds(options.start_s);
    options.bake.stops = [] { return stop_wanted().load(); };

    const Result<std::unique_ptr<server::Synthesizer>> synthesizer =
        server::make_synthesizer(options.device);
    if (!synthesizer)
        return fail(exit_no_device, synthesizer.error().message);
    const int processors = usable_processors();
    Imf::setGlobalThreadCount(processors > 1 ? processors : 0); // 0: none beside this one
    note_stop_signals();                                        // it ends between two files
    const Result<bake::BakeReport> report = bake::bake(*scene, options.bake, **synthesizer);
    if (!report && report.error().is(bake::BakeError::stopped)) {
        fail(exit_failed, report.error().message);
        end_by_stop_signal();
    }
    if (!report)
        return fail(report.error().is(bake::BakeError::bad_options) ? exit_usage : exit_failed,
                    report.error().message);
    fmt::print("baked {} frames into {} files, {:.1f} MB, in {:.2f} s: {:.2f} frames/s "
               "(synthesis {:.2f} s, files {:.2f} s; {})\n",
               report->frames, report->files, static_cast<double>(report->bytes) * 1e-6,
               report->total_s, report->frames / report->total_s, report->synthesis_s,
               report->files_s, (*synthesizer)->description());
    return 0;
}

int run(int argc, char** argv) {
    Options options;
    CommandLine line("seaway-bake", "A scene as OpenEXR maps, one file a frame and cascade");
    declare(line, options);
    const Result<CommandLine::Next> next = line.read(argc, argv);
    if (!next)
        return fail(exit_usage, next.error().message);
    if (*next == CommandLine::Next::leave)
        return status_after_output("seaway-bake", 0, exit_failed);
    return status_after_output("seaway-bake", run(options), exit_failed);
}

} // namespace

int main(int argc, char** argv) {
    return run_main("seaway-bake", exit_failed, [&] { return run(argc, argv); });
}
