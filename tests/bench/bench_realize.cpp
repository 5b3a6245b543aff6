// SPDX-License-Identifier: Apache-2.0
// Cost of making a sea: realisation of the gale's three 256 x 256 cascades (bound: 100 ms on one
// core), its summary, and the exact sum.
#include <benchmark/benchmark.h>

#include <cstdlib>
#include <memory>
#include <string>

#include "sea/scene/scene.h"
#include "sea/surface/budget/error_budget.h"
#include "sea/surface/inverse.h"
#include "sea/waves/reference.h"
#include "sea/waves/statistics/moments.h"

namespace {

using namespace seaway;

sea::Scene gale() {
    Result<sea::Scene> scene = sea::read_scene(SEAWAY_SOURCE_DIR "/scenes/north_sea_gale.toml");
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

/// The sum over the gale's waves, and its moment at 12.34 s.
struct ExactGale {
    sea::RealizationPtr sea = std::make_shared<const sea::Realization>(*sea::realize(gale()));
    sea::DirectSum sum{sea};
    sea::DirectSum::Moment moment = sum.at_time(12'340'000);

    /// Pairs k, -k: what is summed.
    double waves() const {
        double count = 0;
        for (const sea::CascadeModes& modes : sea->cascades) {
            const auto size = static_cast<std::size_t>(modes.spec.size);
            for (std::size_t i = 0; i < modes.h0.size(); ++i) {
                const std::size_t opposite =
                    (size - i / size) % size * size + (size - i % size) % size;
                count += modes.h0[i] != 0.0 || modes.h0[opposite] != 0.0 ? 0.5 : 0.0;
            }
        }
        return count;
    }
};

void exact_sum_new_time(benchmark::State& state) {
    const ExactGale gale;
    sea::TimeUs time = 0;
    for (auto _ : state)
        benchmark::DoNotOptimize(gale.sum.at_time(time += 1000));
}
BENCHMARK(exact_sum_new_time)->Unit(benchmark::kMicrosecond);

void exact_sum_point(benchmark::State& state) {
    const ExactGale gale;
    double x = 0.0;
    for (auto _ : state)
        benchmark::DoNotOptimize(gale.moment.at(x += 1.3, 7.0));
    state.counters["waves_per_s"] =
        benchmark::Counter(gale.waves(), benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(exact_sum_point)->Unit(benchmark::kMicrosecond);

/// An answer as the server gives it, at a moment that is there; few places need a search.
void exact_answer(benchmark::State& state) {
    const ExactGale gale;
    const sea::InverseOptions options{gale.sea->choppiness, 1e-9,
                                      sea::fold_search(sea::plan_budget(*gale.sea, 0.01))};
    double x = 0.0;
    for (auto _ : state)
        benchmark::DoNotOptimize(
            sea::surface_at({x += 1.3, 7.0, 12'340'000}, options, gale.moment));
}
BENCHMARK(exact_answer)->Unit(benchmark::kMicrosecond);

/// What a search for folds asks of each cascade: a box of 20 m here, 2.5 m in the finest.
void exact_sum_patches(benchmark::State& state) {
    const ExactGale gale;
    double x = 0.0;
    for (auto _ : state) {
        x += 1.3;
        for (const int cascade : {0, 1, 2}) {
            const double reach_m = cascade == 2 ? 1.25 : 10.0;
            benchmark::DoNotOptimize(gale.moment.patch_scale(cascade));
            benchmark::DoNotOptimize(
                gale.moment.patch(cascade, x - reach_m, x + reach_m, 7.0 - reach_m, 7.0 + reach_m));
        }
    }
}
BENCHMARK(exact_sum_patches)->Unit(benchmark::kMicrosecond);

} // namespace

BENCHMARK_MAIN();
