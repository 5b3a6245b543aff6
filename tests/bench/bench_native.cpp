// SPDX-License-Identifier: Apache-2.0
// Native synthesis against two FFTW programs, interleaved in one process; prints CSV.
//
//     bench_native [--sizes 128,256,512] [--repeats 40] [--reach SHARE] [--instructions NAME]
//
// Work: three cascades of one size, eight fields (height, two displacements, two slopes, three
// strains) on two threads. `--reach` is the radius of the disc of modes in use as a share of
// Nyquist; the default 2 uses all of them, so that nothing can be skipped.
//
//   strongest: two threads, each with its own single-threaded FFTW_MEASURE plan over half of the
//              batch of four packed complex fields; evolve vectorised. Leaves interleaved maps.
//   planar:    the same, then split into eight maps, as native leaves them.
//   plain:     FFTW's own two threads over the batch, scalar sine; split into maps.
//
// All evolve from the same modes by the same fixed-point phases; the maps are compared before
// anything is timed. Repeats are interleaved; on a shared machine only ratios mean much, and those
// of the fastest run and of CPU time (all threads) more than those of the median.
#include <cstdio>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "base/command_line.h"
#include "base/quantile.h"
#include "sea/native/native_runner.h"
#include "tests/bench/contenders.h"
#include "tests/bench/fftw_yardstick.h"

namespace seaway::bench {
namespace {

using sea::Field;

void time_size(int size, double reach, Instructions instructions, int repeats) {
    const auto points = static_cast<std::size_t>(size) * static_cast<std::size_t>(size);
    const std::vector<sea::CascadeModes> modes = three_cascades(size, reach);
    std::vector<sea::NativeTransform> cascades;
    for (const sea::CascadeModes& cascade : modes)
        cascades.push_back(std::move(*sea::NativeTransform::create(cascade, {}, instructions)));
    FftwYardstick strongest(FftwProgram::split_batch, modes), plain(FftwProgram::plain, modes);
    sea::NativeRunner runner(2);
    std::vector<std::vector<float>> planes(modes.size(), std::vector<float>(8 * points));
    const auto native = [&](sea::FieldSet fields, sea::TimeUs t_us) {
        std::vector<sea::NativeTask> tasks;
        for (std::size_t i = 0; i < modes.size(); ++i)
            tasks.push_back(
                {&cascades[i], t_us, fields,
                 std::span(planes[i]).first(static_cast<std::size_t>(fields.size()) * points)});
        runner.run(tasks);
    };
    Contender contenders[] = {
        {"native", [&](auto t) { native(eight_fields, t); }},
        {"strongest", [&](auto t) { strongest.run(t, false); }},
        {"planar", [&](auto t) { strongest.run(t, true); }},
        {"plain", [&](auto t) { plain.run(t, true); }},
        {"native height", [&](auto t) { native({Field::height}, t); }},
    };
    for (Contender& contender : contenders)
        contender.run(12'345'678);
    contenders[0].run(12'345'678);
    for (std::size_t i = 0; i < modes.size(); ++i)
        for (const FftwYardstick* other : {&strongest, &plain})
            for (std::size_t f = 0; f < 8; ++f)
                check_same(other->planes().subspan((i * 8 + f) * points, points),
                           std::span(planes[i]).subspan(f * points, points));
    for (int repeat = 0; repeat < repeats; ++repeat)
        for (Contender& contender : contenders)
            run_timed(contender, repeat * 33'333);
    const Contender& reference = contenders[1];
    for (const Contender& contender : contenders)
        fmt::print("{},{},{:.4f},{:.3f},{:.4f},{:.3f},{:.4f},{:.3f}\n", size, contender.name,
                   median(contender.wall_ms), median(contender.wall_ms) / median(reference.wall_ms),
                   fastest(contender.wall_ms),
                   fastest(contender.wall_ms) / fastest(reference.wall_ms),
                   median(contender.cpu_ms), median(contender.cpu_ms) / median(reference.cpu_ms));
    std::fflush(stdout);
}

} // namespace
} // namespace seaway::bench

int main(int argc, char** argv) {
    using namespace seaway;
    CommandLine line("bench_native", "Native synthesis against FFTW");
    std::vector<int> sizes{128, 256, 512};
    int repeats = 40;
    double reach = 2;
    std::string instructions;
    std::vector<std::string> known;
    for (Instructions candidate : supported_instructions())
        known.emplace_back(name(candidate));
    line.option("--sizes", sizes).separated_by(',');
    line.option("--repeats", repeats).between(1, 1'000'000);
    line.option("--reach", reach);
    line.option("--instructions", instructions).one_of(known);
    const Result<CommandLine::Next> next = line.read(argc, argv);
    if (!next) {
        fmt::print(stderr, "bench_native: {}\n", next.error().message);
        return 2;
    }
    if (*next == CommandLine::Next::leave)
        return 0;
    Instructions chosen = best_instructions();
    for (Instructions candidate : supported_instructions())
        if (name(candidate) == instructions)
            chosen = candidate;
    fmt::print("# {}, 2 threads, reach {} of Nyquist, {} repeats\n", name(chosen), reach, repeats);
    fmt::print(
        "size,program,median_ms,ratio_to_strongest,fastest_ms,fastest_ratio,cpu_ms,cpu_ratio\n");
    for (int size : sizes)
        bench::time_size(size, reach, chosen, repeats);
}
