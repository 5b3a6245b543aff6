// SPDX-License-Identifier: Apache-2.0
// Cost of making a sea: realisation of the gale's three 256 x 256 cascades (bound: 100 ms on one
// core), its summary, and the exact sum.
#include <benchmark/benchmark.h>

#include <cstdlib>
#include <memory>
#include <string>

#include "sea/scene/scene.h"
#include "sea/waves/reference.h"
#include "sea/waves/statistics/moments.h"

namespace {

using namespace seaway;

sea::Scene gale() {
    Result<sea::Scene> scene =
        sea::read_scene(std::string(SEAWAY_SOURCE_DIR) + "/scenes/north_sea_gale.toml");
    if (!scene)
        std::abort();
    return *std::move(scene);
}

/// Total variance: proof that the work was done.
double variance(const sea::Realization& sea) {
    double sum = 0.0;
    for (const sea::CascadeModes& modes : sea.cascades)
        for (const auto& h0 : modes.h0)
            sum += 2.0 * std::norm(h0);
    return sum;
}

void realize_three_cascades_of_256(benchmark::State& state) {
    const sea::Scene scene = gale();
    double sum = 0.0;
    for (auto _ : state)
        sum = variance(*sea::realize(scene));
    state.counters["variance_m2"] = sum;
}
BENCHMARK(realize_three_cascades_of_256)->Unit(benchmark::kMillisecond);

void summarize_gale(benchmark::State& state) {
    const sea::Scene scene = gale();
    const auto sea = sea::realize(scene);
    for (auto _ : state)
        benchmark::DoNotOptimize(sea::summarize(scene.sea, *sea).realised.significant_height_m);
}
BENCHMARK(summarize_gale)->Unit(benchmark::kMillisecond);

void exact_sum_new_time(benchmark::State& state) {
    const sea::DirectSum sum(std::make_shared<const sea::Realization>(*sea::realize(gale())));
    sea::TimeUs time = 0;
    for (auto _ : state)
        benchmark::DoNotOptimize(sum.at_time(time += 1000));
}
BENCHMARK(exact_sum_new_time)->Unit(benchmark::kMicrosecond);

void exact_sum_point(benchmark::State& state) {
    const sea::DirectSum sum(std::make_shared<const sea::Realization>(*sea::realize(gale())));
    const sea::DirectSum::Moment moment = sum.at_time(12'340'000);
    double x = 0.0;
    for (auto _ : state)
        benchmark::DoNotOptimize(moment.at(x += 1.3, 7.0));
}
BENCHMARK(exact_sum_point)->Unit(benchmark::kMicrosecond);

} // namespace

BENCHMARK_MAIN();
