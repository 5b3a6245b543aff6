// SPDX-License-Identifier: Apache-2.0
#include "client/view/bench.h"

#include <chrono>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "base/elapsed.h"
#include "base/quantile.h"
#include "base/text_file.h"
#include "client/link/failure.h"
#include "client/view/debug/debug_pictures.h"
#include "client/view/look_file.h"
#include "client/view/view_sky.h"

namespace seaway::client {

namespace {

using Clock = std::chrono::steady_clock;

} // namespace

Result<void> bench(SeaSource& source, Renderer& renderer, const ViewOptions& options) {
    const sea::TimeUs start_us =
        options.time_s ? sea::us_from_seconds(*options.time_s) : source.now_us();
    SkyMaker skies;
    const Result<Sky> made = sky_of_frame(skies, options.look, options.camera, start_us);
    if (!made)
        return failed(Failure::bad_argument, made.error().message);
    const Sky& sky = *made;
    std::vector<std::vector<double>> passes(Renderer::passes);
    double all_s = 0, all_cpu_s = 0;
    Display display;
    for (int i = 0; i < options.bench_frames; ++i) {
        SEAWAY_TRY_LET(SeaFrame frame, source.at(start_us + options.rate.offset_us(i)));
        set_water(frame, options.look);
        if (i == 0) { // pipelines are made
            if (const auto fits = check_debug(options.debug, frame, renderer.options()); !fits)
                return failed(Failure::bad_argument, fits.error().message);
            source.leave_now();
            display =
                display_by_light(options.look, sky, options.debug.view, frame.significant_height_m);
            SEAWAY_TRY(renderer.show(frame, options.camera, sky, options.debug, display));
        }
        const Clock::time_point start = Clock::now();
        const double cpu_start_s = process_cpu_seconds();
        SEAWAY_TRY(
            renderer.draw(frame, options.camera, sky, options.debug, display, Wanted::nothing));
        SEAWAY_TRY(renderer.finish());
        all_s += seconds_since(start);
        all_cpu_s += process_cpu_seconds() - cpu_start_s;
        const std::vector<double>& times = renderer.pass_times();
        for (std::size_t pass = 0; pass < times.size(); ++pass)
            passes[pass].push_back(times[pass]);
    }
    const double wall_s = all_s / options.bench_frames;
    const double frame_cpu_s = all_cpu_s / options.bench_frames;
    std::string text;
    for (std::size_t pass = 0; pass < passes.size(); ++pass)
        text += fmt::format("{:<10}{:9.2f} ms\n", Renderer::pass_names[pass],
                            1e3 * median(passes[pass]));
    text += fmt::format("{:<10}{:9.2f} ms, {:.2f} frames/s, {:.1f} ms of CPU\n", "frame",
                        1e3 * wall_s, 1 / wall_s, 1e3 * frame_cpu_s);
    return write_out(stdout, text);
}

} // namespace seaway::client
