// SPDX-License-Identifier: Apache-2.0
// seaway-bench: measures, as tables, CSV and plots.
#include <cstdio>
#include <string>

#include <fmt/format.h>

#include "base/command_line.h"
#include "base/text_file.h"
#include "tools/bench/compare.h"
#include "tools/bench/effects.h"

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
    effects.option("--out", options.out, "Folder for effects.csv and effects.png").shows_default();
    effects.option("--quick", quick, "Fewer rounds");
    bench::CompareOptions pair;
    CommandLine& compare =
        line.command("compare", "Two devices on one scene: the same sea, and at what cost");
    compare.option("--scene", pair.scene).shows_default();
    compare.option("--first", pair.first).shows_default();
    compare.option("--second", pair.second).shows_default();
    const Result<CommandLine::Next> next = line.read(argc, argv);
    if (!next) {
        fmt::print(stderr, "seaway-bench: {}\n", next.error().message);
        return 2;
    }
    if (*next == CommandLine::Next::leave)
        return status_after_output("seaway-bench", 0, 2);

    if (quick)
        options.rounds = 8;
    const Result<void> done =
        compare.given() ? bench::run_compare(pair) : bench::run_effects(options);
    if (!done) {
        fmt::print(stderr, "seaway-bench: {}\n", done.error().message);
        return 2;
    }
    return status_after_output("seaway-bench", 0, 2);
}
