// SPDX-License-Identifier: Apache-2.0
// seaway-view: the sea of a running server, or of a scene, in a window or as pictures in files.
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <optional>

#include <fmt/format.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include "base/messages.h"
#include "base/stop_wanted.h"
#include "base/text_file.h"
#include "client/exit_code.h"
#include "client/view/bench.h"
#include "client/view/camera_path.h"
#include "client/view/debug/contact_sheet.h"
#include "client/view/film_file.h"
#include "client/view/frame_writer.h"
#include "client/view/look_file.h"
#include "client/view/renderer.h"
#include "client/view/sea/sea_source.h"
#include "client/view/sky/environment.h"
#include "client/view/view_options.h"
#include "client/view/view_sky.h"
#include "client/window/viewer.h"
#include "local/local_sea.h"
#include "protocol/limits.h"

namespace {

using namespace seaway;
using namespace seaway::client;

constexpr std::size_t path_bytes_max = 16u << 20;

int fail(ExitCode code, const Error& error) {
    return complain("seaway-view", code, error.message);
}

/// The client's errors have kinds, those of the device have none.
int fail(const Error& error) {
    return give_up("seaway-view", error, exit_no_device);
}

Result<CameraPath> camera_path(const ViewOptions& options) {
    const double duration_s = options.rate.offset_s(options.frames);
    if (options.turntable)
        return CameraPath::turntable(options.camera, duration_s);
    if (options.path.empty())
        return CameraPath(options.camera);
    const Result<std::string> text = read_text_file(options.path, path_bytes_max);
    return text ? CameraPath::parse(*text, options.path, options.camera)
                : Error{"--path " + options.path + ": " + text.error().message};
}

/// Frame by frame what is written: numbers, their bytes, or a sheet of all views.
class Drawing {
  public:
    Drawing(gpu::Device& device, Renderer& renderer, const ViewOptions& options)
        : device_(device), renderer_(renderer), options_(options), writer_(options) {}

    FrameWriter& writer() { return writer_; }

    /// The i-th of those that are asked for. 0, or the code to exit with.
    int draw(const DebugMoment& moment, const Camera& camera, int i) {
        const int number = options_.frame(i);
        if (options_.sheet)
            return draw_sheet(moment, camera, number);
        if (const Result<void> fits =
                check_debug(options_.debug, moment.frame, renderer_.options());
            !fits)
            return fail(exit_usage, fits.error());
        const Result<Picture> picture =
            pictures_.numbers(renderer_, moment, camera, options_.debug);
        if (!picture) // tables need no device, but a server that tells its scene
            return fail(is_table(options_.debug) ? exit_refused : exit_no_device, picture.error());
        if (i == 0) // metered once: frames of a film do not flicker
            exposure_ =
                exposure_of(options_.look, metered_exposure(*picture, moment.sky.white_radiance()));
        if (!writer_.shows())
            return written(writer_.write(*picture, number, notes(moment)), moment);
        const Result<ShownPicture> shown =
            pictures_.develop(renderer_, *picture, moment, options_.debug, exposure_);
        return shown ? written(writer_.write(*shown, number), moment, metered())
                     : fail(exit_no_device, shown.error());
    }

  private:
    /// Of numbers, whatever colours they would have.
    PictureNotes notes(const DebugMoment& moment) const {
        DebugChoice shown = options_.debug;
        shown.colouring = {};
        shown.legend = true;
        const bool lit = shown.view == DebugView::final;
        return {.debug = lit ? "" : debug_text(shown), .time_us = moment.frame.time_us};
    }

    /// What a piece of the same film is drawn with, to be exposed alike; empty: that is given.
    std::string metered() const {
        return options_.debug.view == DebugView::final &&
                       options_.look.exposure.by == Exposure::By::meter
                   ? fmt::format(" --exposure {}", exposure_)
                   : "";
    }

    int draw_sheet(const DebugMoment& moment, const Camera& camera, int number) {
        if (!sheet_) {
            Result<ContactSheet> made = ContactSheet::create(
                device_, options_.camera.width, options_.camera.height,
                static_cast<int>(moment.frame.cascades.size()), renderer_.options());
            if (!made)
                return fail(exit_usage, made.error());
            sheet_.emplace(std::move(*made));
        }
        const Result<ShownPicture> shown = sheet_->draw(moment, camera, options_.look);
        return shown ? written(writer_.write(*shown, number), moment)
                     : fail(exit_no_device, shown.error());
    }

    static int written(const Result<std::string>& path, const DebugMoment& moment,
                       const std::string& exposure = "") {
        if (!path)
            return fail(exit_output, path.error());
        const std::string line = fmt::format("{} t={:.3f}{}\n", *path,
                                             sea::seconds_from_us(moment.frame.time_us), exposure);
        const Result<void> told = write_out(stdout, line);
        return told ? 0 : fail(exit_output, told.error());
    }

    gpu::Device& device_;
    Renderer& renderer_;
    const ViewOptions& options_;
    FrameWriter writer_;
    DebugPictures pictures_;
    std::optional<ContactSheet> sheet_;
    double exposure_ = 1;
};

int draw(SeaSource& source, gpu::Device& device, Renderer& renderer, const ViewOptions& options,
         const CameraPath& path) {
    SkyMaker skies;
    const sea::TimeUs start_us =
        options.time_s ? sea::us_from_seconds(*options.time_s) : source.now_us();
    Drawing drawing(device, renderer, options);
    if (is_film(options.out)) { // its part is removed, also where nobody reads on what we say
        note_stop_signals();
        std::signal(SIGPIPE, SIG_IGN);
    }
    for (int i = 0; i < options.frames; ++i) {
        if (stop_wanted())
            return fail(exit_output,
                        {fmt::format("stopped by a signal: after {} of {} frames {} is given up", i,
                                     options.frames, options.out)});
        const sea::TimeUs offset_us = options.rate.offset_us(options.frame(i));
        const sea::TimeUs time_us = start_us + offset_us;
        Result<SeaFrame> frame = source.at(time_us);
        if (!frame)
            return fail(frame.error());
        set_water(*frame, options.look);
        const std::string scene = source.scene_at(time_us);
        if (i == 0) // frames are drawn slower than the sea moves
            source.leave_now();
        const Camera camera = path.at(sea::seconds_from_us(offset_us));
        const Result<Sky> sky = sky_of_frame(skies, options.look, camera, time_us);
        if (!sky)
            return fail(exit_usage, sky.error());
        if (const int code = drawing.draw({*frame, *sky, scene, options.look.bloom}, camera, i);
            code != 0)
            return code;
        drawing.writer().tell(i + 1);
    }
    const Result<void> closed = drawing.writer().close();
    return closed ? exit_done : fail(exit_output, closed.error());
}

int show(const ViewOptions& options, const OpenSea& open_sea) {
    const Result<std::unique_ptr<Viewer>> viewer = Viewer::open(options, open_sea);
    if (!viewer)
        return fail(exit_no_device, viewer.error());
    for (;;) {
        const Result<bool> open = (*viewer)->step();
        if (!open)
            return fail(exit_no_device, open.error());
        if (!*open)
            return exit_done;
    }
}

/// Makes or finds the sea of files, and has it drawn.
using WithSource =
    std::function<int(std::shared_ptr<gpu::Device>, const std::function<int(SeaSource&)>& draw)>;

int draw_files(const ViewOptions& options, const WithSource& with_source) {
    const Result<CameraPath> path = camera_path(options);
    if (!path)
        return fail(exit_usage, path.error());
    Result<std::unique_ptr<gpu::Device>> made =
        gpu::Device::create({.pick = options.device, .draws = true});
    if (!made)
        return fail(exit_no_device, made.error());
    const std::shared_ptr<gpu::Device> device = std::move(*made);
    Result<Renderer> renderer = Renderer::create(
        *device, options.camera.width, options.camera.height, {.quality = options.quality});
    if (!renderer)
        return fail(exit_no_device, renderer.error());
    return with_source(device, [&](SeaSource& source) {
        if (options.bench_frames == 0)
            return draw(source, *device, *renderer, options, *path);
        const Result<void> done = bench(source, *renderer, options);
        return done ? exit_done : fail(done.error());
    });
}

int draw_streamed(const ViewOptions& options, const ConnectOptions& connect) {
    return draw_files(options, [&](const std::shared_ptr<gpu::Device>&, const auto& draw_source) {
        const Result<std::unique_ptr<Client>> client = connect_to(connect);
        if (!client)
            return fail(client.error());
        protocol::TileWish wish{.fields = drawn_fields};
        options.limits.put_into(wish);
        const Result<Grant> grant =
            (*client)->subscribe(wish, protocol::limits::credit_default, options.timeout_s);
        if (!grant)
            return fail(grant.error());
        StreamedSource source(**client, options.timeout_s);
        return draw_source(source);
    });
}

int run_streamed(const ViewOptions& options) {
    const Result<ConnectOptions> server = options.connect_options("seaway-view");
    if (!server)
        return fail(server.error());
    return options.offscreen ? draw_streamed(options, *server)
                             : show(options, Viewer::streamed(*server, options.limits));
}

int run_local(const ViewOptions& options) {
    const Result<server::RunningSeaPtr> scene = local::read_local_scene(options.scene);
    if (!scene)
        return fail(exit_usage, scene.error());
    if (!options.offscreen)
        return show(options, local::open_in_a_window(*scene, options));
    return draw_files(options, [&](std::shared_ptr<gpu::Device> device, const auto& draw_source) {
        const auto sea = local::LocalSea::create(*scene, std::move(device));
        return sea ? draw_source(**sea) : fail(exit_no_device, sea.error());
    });
}

int run(const ViewOptions& options) {
    if (!options.look.environment.empty()) // before a window opens
        if (const auto picture = read_environment(options.look.environment); !picture)
            return fail(exit_usage, picture.error());
    const int code = options.scene.empty() ? run_streamed(options) : run_local(options);
    if (code != exit_done && stop_wanted())
        end_by_stop_signal();
    return code;
}

/// Keyframes, blocks of megabytes, come and go: left to itself glibc takes them from heaps that keep what has gone.
void give_large_blocks_back() {
#ifdef __GLIBC__
    mallopt(M_MMAP_THRESHOLD, 256 * 1024);
#endif
}

int run(int argc, char** argv) {
    give_large_blocks_back();
    const std::variant<ViewOptions, int> options = read_view_options(argc, argv);
    if (const int* code = std::get_if<int>(&options))
        return *code;
    return run(std::get<ViewOptions>(options));
}

} // namespace

int main(int argc, char** argv) {
    return run_main("seaway-view", exit_output, [&] { return run(argc, argv); });
}
