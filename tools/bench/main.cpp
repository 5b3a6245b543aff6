// SPDX-License-Identifier: Apache-2.0
// seaway-bench: measures, as tables, CSV and plots.
#include <cstdio>
#include <string>

#include <fmt/format.h>

#include "base/command_line.h"
#include "base/text_file.h"
#include "tools/bench/accuracy/accuracy.h"
#include "tools/bench/accuracy/guard.h"
#include "tools/bench/compare.h"
#include "tools/bench/effects.h"

namespace {

seaway::CommandLine& add_accuracy(seaway::CommandLine& line,
                                  seaway::bench::AccuracyOptions& options) {
    seaway::CommandLine& command =
        line.command("accuracy", "What every knob costs in accuracy, time, bytes and memory, "
                                 "against a sum of all waves in double precision. A run that was "
                                 "stopped goes on where it was; tools/accuracy_page.py draws "
                                 "docs/accuracy.md from it");
    const auto quick = command.option(
        "--quick", options.quick, "512 points at each of 8 times, knobs on the gale: 3 minutes");
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
    command.option("--points", options.points, "A time, in place of what the extent says")
        .between(4, 65'536);
    command.option("--times", options.times, "Likewise").between(1, 1024);
    return command;
}

} // namespace

int main(int argc, char** argv) {
    using namespace seaway;
    CommandLine line("seaway-bench",
                     "Measures what Seaway costs on this machine. Variants are interleaved in one "
                     "run; figures are medians, and ratios are what to trust.");
    bench::EffectsOptions options;
    bool quick = false;
    CommandLine& effects =
        line.command("effects", "Marginal cost of every effect and every cascade");
    effects.option("--scene", options.scene).shows_default();
    effects
        .option("--device", options.device,
                "native, auto (a GPU, else native), an index or part of a name")
        .shows_default();
    effects.option("--out", options.out, "Folder for effects.csv").shows_default();
    effects
        .option("--ask", options.ask, "What runs, as height,choppy; else all that the scene allows")
        .separated_by(',');
    effects.option("--quick", quick, "Fewer rounds");
    bench::CompareOptions pair;
    CommandLine& compare =
        line.command("compare", "Two devices on one scene: the same sea, and at what cost");
    compare.option("--scene", pair.scene).shows_default();
    compare.option("--first", pair.first).shows_default();
    compare.option("--second", pair.second).shows_default();
    bench::AccuracyOptions accuracy;
    const CommandLine& measured = add_accuracy(line, accuracy);
    bench::GuardOptions guard;
    CommandLine& guarded =
        line.command("guard", "Are errors what they were? Exit code 1: one has grown by a fifth");
    guarded.option("--baseline", guard.baseline).shows_default();
    guarded.option("--renew", guard.renew, "Write that file anew");
    const Result<CommandLine::Next> next = line.read(argc, argv);
    if (!next) {
        fmt::print(stderr, "seaway-bench: {}\n", next.error().message);
        return 2;
    }
    if (*next == CommandLine::Next::leave)
        return status_after_output("seaway-bench", 0, 2);

    if (quick)
        options.rounds = 3;
    if (guarded.given()) {
        const Result<bool> kept = bench::run_guard(guard);
        if (!kept)
            fmt::print(stderr, "seaway-bench: {}\n", kept.error().message);
        return status_after_output("seaway-bench", kept ? (*kept ? 0 : 1) : 2, 2);
    }
    const Result<void> done = measured.given()  ? bench::run_accuracy(accuracy)
                              : compare.given() ? bench::run_compare(pair)
                                                : bench::run_effects(options);
    if (!done) {
        fmt::print(stderr, "seaway-bench: {}\n", done.error().message);
        return 2;
    }
    return status_after_output("seaway-bench", 0, 2);
}
