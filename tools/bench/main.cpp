// SPDX-License-Identifier: Apache-2.0
// seaway-bench: measures, as tables, CSV and plots.
#include <cstdio>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "base/text_file.h"
#include "tools/bench/compare.h"
#include "tools/bench/effects.h"

int main(int argc, char** argv) {
    using namespace seaway;
    CLI::App app{"Measures what Seaway costs on this machine. Variants are interleaved in one run; "
                 "figures are medians, and ratios are what to trust."};
    app.name("seaway-bench");
    app.set_version_flag("--version", std::string("seaway-bench ") + SEAWAY_VERSION);
    app.require_subcommand(1);
    bench::EffectsOptions options;
    bool quick = false;
    CLI::App* effects =
        app.add_subcommand("effects", "Marginal cost of every effect and every cascade");
    effects->add_option("--scene", options.scene)->capture_default_str();
    effects
        ->add_option("--device", options.device,
                     "native, auto (a GPU, else native), an index or part of a name")
        ->capture_default_str();
    effects->add_option("--out", options.out, "Folder for effects.csv and effects.png")
        ->capture_default_str();
    effects->add_flag("--quick", quick, "Fewer rounds");
    bench::CompareOptions pair;
    CLI::App* compare =
        app.add_subcommand("compare", "Two devices on one scene: the same sea, and at what cost");
    compare->add_option("--scene", pair.scene)->capture_default_str();
    compare->add_option("--first", pair.first)->capture_default_str();
    compare->add_option("--second", pair.second)->capture_default_str();
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return status_after_output("seaway-bench", app.exit(error), 2);
    }

    if (quick)
        options.rounds = 8;
    const Result<void> done =
        compare->parsed() ? bench::run_compare(pair) : bench::run_effects(options);
    if (!done) {
        fmt::print(stderr, "seaway-bench: {}\n", done.error().message);
        return 2;
    }
    return status_after_output("seaway-bench", 0, 2);
}
