// SPDX-License-Identifier: Apache-2.0
// seaway-bench: measures, as tables, CSV and plots.
#include <cstdio>
#include <string>

#include <fmt/format.h>

#include "base/command_line.h"
#include "base/messages.h"
#include "base/text_file.h"
#include "tools/bench/accuracy/accuracy.h"
#include "tools/bench/accuracy/guard.h"
#include "tools/bench/compare.h"
#include "tools/bench/device.h"
#include "tools/bench/effects.h"
#include "tools/bench/line.h"
#include "tools/bench/sample.h"
#include "tools/bench/spectrum.h"
#include "tools/bench/tune/tune.h"

namespace {

seaway::CommandLine& add_accuracy(seaway::CommandLine& line,
                                  seaway::bench::AccuracyOptions& options) {
    seaway::CommandLine& command =
        line.command("accuracy", "What every knob costs in accuracy, time, bytes and memory, "
                                 "against a sum of all waves in double precision. A run that was "
                                 "stopped goes on where it was; tools/accuracy_page.py draws "
                                 "docs/accuracy.md from it");
    const auto quick = command.option(
        "--quick", options.quick, "384 points at each of 8 times, knobs on the gale: 3 minutes");
    command
        .option("--full", options.full,
                "4096 points at each of 32 times, every knob on all six sea states: hours")
        .excludes(quick);
    command.option("--knobs", options.knobs, "Only these, as codec,interval").separated_by(',');
    command.option("--states", options.states, "Only these, as gale_deep,calm_shallow")
        .separated_by(',');
    command
        .option("--device", options.device,
                "native, auto (a GPU, else native), an index or part of a name")
        .shows_default();
    command.option("--out", options.out, "Folder for accuracy.csv and the truth").shows_default();
    command.option("--seed", options.seed, "Of the seas and of the points").shows_default();
    command
        .option("--seeds", options.seeds,
                "Presets and baselines are measured on so many, from --seed on; with --quick they "
                "share the times")
        .between(1, 1000)
        .shows_default();
    command
        .option("--server", options.server,
                "ws://HOST:PORT of a running server, for batches over a socket (knob batch)")
        .takes("URL");
    command.option("--points", options.points, "A time, in place of what the extent says")
        .between(4, 65'536);
    command.option("--times", options.times, "Likewise").between(1, 1024);
    return command;
}

seaway::CommandLine& add_tune(seaway::CommandLine& line, seaway::bench::TuneCommand& options) {
    seaway::CommandLine& command = line.command(
        "tune", "The cheapest tiles and budget that keep heights of a scene within an error, as a "
                "scene with a certificate of what was measured. Exit status 1: there is none; says "
                "what there is instead, and what it would take");
    command.option("scene", options.scene, "Scene file (docs/scenes.md)")
        .required()
        .takes("SCENE.toml");
    command.option("--height-error", options.height_error_m, "m, against all waves of the spectrum")
        .between(1e-6, 100.0)
        .shows_default();
    command.option("--percentile", options.percentile, "Of places and times that stay within it")
        .between(50.0, 99.9)
        .shows_default();
    command
        .option("--slope-error", options.slope_error, "And slopes, rms, of waves that tiles hold")
        .between(1e-6, 10.0);
    command.option("--budget-ms", options.budget_ms, "At most so much CPU a second of sea")
        .between(1e-3, 1e6);
    command.option("--bytes-per-second", options.bytes_per_s, "At most so much for a stream")
        .between(1.0, 1e12);
    command
        .option("--envelope", options.envelope_pct,
                "Percent by which the sea may be rougher and calmer than the scene's")
        .between(0.0, 50.0)
        .shows_default();
    command
        .option("--device", options.device,
                "native, auto (a GPU, else native), an index or part of a name")
        .shows_default();
    command.option("--out", options.out, "Scene to write; NAME.tuned.toml if not given")
        .takes("OUT.toml");
    command.option("--work", options.work, "Folder for prices of this machine and for truths")
        .shows_default();
    command.option("--seed", options.seed, "Of the fresh seas").shows_default();
    command
        .option("--check-seeds", options.check_seeds,
                "Afterwards measures so many seeds that the search did not see")
        .between(0, 1000);
    return command;
}

seaway::CommandLine& add_effects(seaway::CommandLine& line, seaway::bench::EffectsOptions& options,
                                 bool& quick) {
    seaway::CommandLine& command =
        line.command("effects", "Marginal cost of every effect and every cascade");
    command.option("--scene", options.scene).shows_default();
    command
        .option("--device", options.device,
                "native, auto (a GPU, else native), an index or part of a name")
        .shows_default();
    command.option("--out", options.out, "Folder for effects.csv").shows_default();
    command
        .option("--ask", options.ask, "What runs, as height,choppy; else all that the scene allows")
        .separated_by(',');
    command.option("--quick", quick, "Fewer rounds");
    return command;
}

seaway::CommandLine& add_device(seaway::CommandLine& line, seaway::bench::DeviceOptions& options) {
    seaway::CommandLine& command =
        line.command("device", "What a device takes for maps, foam and a start, beside what its "
                               "memory gives at best");
    command
        .option("--device", options.device,
                "native, auto (a GPU, else native), an index or part of a name")
        .shows_default();
    command.option("--scene", options.scene).shows_default();
    command.option("--sizes", options.sizes, "Points a side of its tiles, as 128,256")
        .separated_by(',');
    command.option("--rounds", options.rounds, "That count, each of all rows in turn")
        .between(1, 1000)
        .shows_default();
    command.option("--out", options.out, "Folder for device.csv").shows_default();
    command.option("--retune", options.retune,
                   "First measure anew which kernels of these sizes are fastest, and remember it");
    return command;
}

seaway::CommandLine& add_line(seaway::CommandLine& line, seaway::bench::LineOptions& options) {
    seaway::CommandLine& command =
        line.command("line", "Where the bytes of one client go, by cascade and field");
    command.option("--scene", options.scene).shows_default();
    command
        .option("--device", options.device,
                "native, auto (a GPU, else native), an index or part of a name")
        .shows_default();
    command.option("--height-error", options.error_m, "Bound that the client asks for, m")
        .between(1e-6, 100.0)
        .shows_default();
    command
        .option("--ask", options.ask,
                "What it takes, as height,choppy; else what heights are sampled from")
        .separated_by(',');
    command.option("--whole", options.whole, "For a client that takes no compact maps");
    command.option("--keyframes", options.keyframes, "Of each cascade").between(1, 10000);
    command.option("--alone", options.alone, "For one that takes no differences to earlier ones");
    options.limits.describe(command);
    return command;
}

seaway::CommandLine& add_spectrum(seaway::CommandLine& line,
                                  seaway::bench::SpectrumOptions& options) {
    seaway::CommandLine& command =
        line.command("spectrum", "The waves themselves: bytes, what is missed, errors over a day");
    command.option("--scene", options.scene).shows_default();
    command.option("--height-error", options.error_m, "Bound that the client asks for, m")
        .between(1e-6, 100.0)
        .shows_default();
    command.option("--slope-error", options.slope_error, "And of slopes; from 1 on none")
        .between(1e-6, 10.0)
        .shows_default();
    command.option("--times", options.times, "Times of 24 h at which errors are looked for")
        .between(1, 100000)
        .shows_default();
    command.option("--places", options.places, "Places at each").between(1, 10000).shows_default();
    return command;
}

seaway::CommandLine& add_sample(seaway::CommandLine& line, seaway::bench::SampleOptions& options) {
    seaway::CommandLine& command =
        line.command("sample", "Answers from maps that are held, on one thread");
    command.option("--scene", options.scene).shows_default();
    command.option("--seconds", options.seconds, "For each row")
        .between(0.01, 60.0)
        .shows_default();
    command
        .option("--points", options.points, "Rows of so many points at once alone: 1, 64 or 1024")
        .one_of({1, 64, 1024});
    command.option("--kernel", options.kernel, "best, or portable")
        .one_of({"best", "portable"})
        .shows_default();
    return command;
}

/// An exit status, or one line on stderr and 2.
int finished(const seaway::Result<int>& status) {
    if (!status)
        seaway::complain("seaway-bench", 2, status.error().message);
    return seaway::status_after_output("seaway-bench", status ? *status : 2, 2);
}

int run(int argc, char** argv) {
    using namespace seaway;
    CommandLine line("seaway-bench",
                     "Measures what Seaway costs on this machine. Variants are interleaved in one "
                     "run; figures are medians, and ratios are what to trust.");
    bench::EffectsOptions options;
    bool quick = false;
    add_effects(line, options, quick);
    bench::CompareOptions pair;
    CommandLine& compare =
        line.command("compare", "Two devices on one scene: the same sea, and at what cost");
    compare.option("--scene", pair.scene).shows_default();
    compare.option("--first", pair.first).shows_default();
    compare.option("--second", pair.second).shows_default();
    bench::AccuracyOptions accuracy;
    const CommandLine& measured = add_accuracy(line, accuracy);
    bench::DeviceOptions device;
    const CommandLine& device_measured = add_device(line, device);
    bench::LineOptions bytes;
    const CommandLine& counted = add_line(line, bytes);
    bench::SpectrumOptions waves;
    const CommandLine& summed = add_spectrum(line, waves);
    bench::SampleOptions points;
    const CommandLine& sampled = add_sample(line, points);
    bench::GuardOptions guard;
    CommandLine& guarded =
        line.command("guard", "Are errors what they were? Exit code 1: one has grown by a fifth");
    guarded.option("--baseline", guard.baseline).shows_default();
    guarded.option("--renew", guard.renew, "Write that file anew");
    bench::TuneCommand wanted;
    const CommandLine& tuned = add_tune(line, wanted);
    for (int i = 0; i < argc; ++i)
        wanted.words += (i == 0 ? "seaway-bench" : std::string(" ") + argv[i]);
    const Result<CommandLine::Next> next = line.read(argc, argv);
    if (!next)
        return finished(next.error());
    if (*next == CommandLine::Next::leave)
        return finished(0);
    if (tuned.given())
        return finished(bench::run_tune(wanted));
    if (quick)
        options.rounds = 3;
    if (guarded.given()) {
        const Result<bool> kept = bench::run_guard(guard);
        return finished(kept ? Result<int>(*kept ? 0 : 1) : Result<int>(kept.error()));
    }
    if (device_measured.given()) {
        const Result<void> shown = bench::run_device(device);
        return finished(shown ? Result<int>(0) : Result<int>(shown.error()));
    }
    const Result<void> done = measured.given()  ? bench::run_accuracy(accuracy)
                              : compare.given() ? bench::run_compare(pair)
                              : counted.given() ? bench::run_line(bytes)
                              : summed.given()  ? bench::run_spectrum(waves)
                              : sampled.given() ? bench::run_sample(points)
                                                : bench::run_effects(options);
    return finished(done ? Result<int>(0) : Result<int>(done.error()));
}

} // namespace

int main(int argc, char** argv) {
    return seaway::run_main("seaway-bench", 2, [&] { return run(argc, argv); });
}
