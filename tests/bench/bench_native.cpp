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
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <functional>
#include <string>

#include <fmt/format.h>

#include "base/check.h"
#include "base/command_line.h"
#include "sea/native/native_runner.h"
#include "tests/bench/fftw_yardstick.h"
#include "tests/sea/native/random_modes.h"

namespace seaway::bench {
namespace {

using sea::Field;

constexpr sea::FieldSet eight_fields{Field::height,    Field::displacement_x, Field::displacement_y,
                                     Field::slope_x,   Field::slope_y,        Field::strain_xx,
                                     Field::strain_yy, Field::strain_xy};
constexpr std::size_t cascade_count = 3;

struct Contender {
    std::string name;
    std::function<void(sea::TimeUs)> run;
    std::vector<double> wall_ms{};
    std::vector<double> cpu_ms{}; ///< of all threads
};

double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}

double fastest(const std::vector<double>& values) {
    return *std::min_element(values.begin(), values.end());
}

double seconds_of(clockid_t clock) {
    timespec now{};
    clock_gettime(clock, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Largest difference between the maps of two programs, over their rms.
double difference(std::span<const float> a, std::span<const float> b) {
    double worst = 0, sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        worst = std::max(worst, std::abs(double{a[i]} - double{b[i]}));
        sum += double{a[i]} * double{a[i]};
    }
    return worst / std::sqrt(sum / static_cast<double>(a.size()));
}

void time_size(int size, double reach, Instructions instructions, int repeats) {
    const auto points = static_cast<std::size_t>(size) * static_cast<std::size_t>(size);
    std::vector<sea::CascadeModes> modes;
    std::vector<sea::NativeTransform> cascades;
    for (std::uint64_t seed = 0; seed < cascade_count; ++seed) {
        modes.push_back(sea::random_modes(size, reach * size / 2, seed, 50.0 * std::pow(5, seed)));
        cascades.push_back(std::move(*sea::NativeTransform::create(modes[seed], {}, instructions)));
    }
    FftwYardstick strongest(FftwProgram::split_batch, modes), plain(FftwProgram::plain, modes);
    sea::NativeRunner runner(2);
    std::vector<std::vector<float>> planes(cascade_count, std::vector<float>(8 * points));
    const auto native = [&](sea::FieldSet fields, sea::TimeUs t_us) {
        std::vector<sea::NativeTask> tasks;
        for (std::size_t i = 0; i < cascade_count; ++i)
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
    // A slope shares its transform with a displacement that may be a hundred times larger, and its
    // rounding errors: hence not 2e-6.
    for (std::size_t i = 0; i < cascade_count; ++i)
        for (const FftwYardstick* other : {&strongest, &plain})
            for (std::size_t f = 0; f < 8; ++f)
                SEAWAY_CHECK(difference(other->planes().subspan((i * 8 + f) * points, points),
                                        std::span(planes[i]).subspan(f * points, points)) < 1e-4,
                             "two programs make different seas");
    for (int repeat = 0; repeat < repeats; ++repeat) {
        for (Contender& contender : contenders) {
            const double wall = seconds_of(CLOCK_MONOTONIC);
            const double cpu = seconds_of(CLOCK_PROCESS_CPUTIME_ID);
            contender.run(repeat * 33'333);
            contender.cpu_ms.push_back(1e3 * (seconds_of(CLOCK_PROCESS_CPUTIME_ID) - cpu));
            contender.wall_ms.push_back(1e3 * (seconds_of(CLOCK_MONOTONIC) - wall));
        }
    }
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
