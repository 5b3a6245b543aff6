// SPDX-License-Identifier: Apache-2.0
// What the parts of a question cost on this machine, beside what they are priced at
// (server/simulation/price.h; docs/performance.md has the figures). One CSV row a part.
//
//     load_costs SCENE.toml
#include <chrono>
#include <cstdio>

#include <fmt/format.h>

#include "server/device/native_synthesizer.h"
#include "server/simulation/foam_maps.h"
#include "server/simulation/keyframe_source.h"
#include "server/simulation/point_question.h"
#include "server/simulation/price.h"

using namespace seaway;
using namespace seaway::server;
using Clock = std::chrono::steady_clock;

namespace {

template <class Work>
double least_us(int repeats, const Work& work) {
    double least = 1e18;
    for (int i = 0; i < repeats; ++i) {
        const Clock::time_point start = Clock::now();
        work(i);
        least = std::min(least,
                         std::chrono::duration<double, std::micro>(Clock::now() - start).count());
    }
    return least;
}

void row(const char* what, double measured_us, double priced_us) {
    fmt::print("{},{:.3f},{:.3f}\n", what, measured_us, priced_us);
}

} // namespace

int main(int argc, char** argv) {
    if (argc != 2)
        return std::fputs("load_costs SCENE.toml\n", stderr), 2;
    const Result<sea::Scene> scene = sea::read_scene(argv[1]);
    if (!scene)
        return std::fputs((scene.error().message + "\n").c_str(), stderr), 2;
    const RunningSeaPtr sea = make_running_sea(*scene, 1).value();
    NativeSynthesizer device;
    (void)device.set_sea(sea->realization, 1).has_value();
    const int cascades = static_cast<int>(sea->budget.cascades.size());
    double samples = 0;
    for (const sea::CascadeModes& modes : sea->realization->cascades)
        samples += static_cast<double>(modes.spec.size) * modes.spec.size;
    std::printf("part,measured_us,priced_us\n");

    const auto made = [&](sea::TimeUs time_us, sea::FieldSet fields) {
        std::vector<KeyframeRequest> requests;
        for (int c = 0; c < cascades; ++c)
            requests.push_back({c, time_us, fields});
        return device.synthesize(requests).value();
    };
    const sea::FieldSet sampled = sea->sampler_fields();
    row("a million samples of a field",
        1e6 / samples / sampled.size() *
            least_us(40, [&](int i) { (void)made(i * 700'000, sampled); }),
        1e6 * price_sample_us);
    const std::vector<NewKeyframePtr> keyframes = made(0, sampled);
    row("splines of a million samples",
        1e6 / samples / sampled.size() *
            least_us(20,
                     [&](int) {
                         for (const NewKeyframePtr& keyframe : keyframes)
                             (void)sea::SplineMap(*keyframe);
                     }),
        1e6 * price_spline_sample_us);
    if (sea->foam_law) {
        const std::vector<NewKeyframePtr> strains = made(0, sea::foam_inputs);
        FoamMaps foam(*sea);
        const int ticks = foam.ticks_to(0, 0);
        const double size = sea->realization->cascades[0].spec.size;
        const auto walk_us = least_us(1, [&](int) {
            (void)foam
                .walk_towards(
                    0, 0, ticks,
                    [&](sea::TimeUs t_us) -> Result<sea::KeyframePtr> {
                        const KeyframeRequest one{0, t_us, sea::foam_inputs};
                        return sea::KeyframePtr(device.synthesize({&one, 1}).value().front());
                    })
                .has_value();
        });
        row("a tick of foam, of a million samples", walk_us / ticks * 1e6 / size / size,
            1e6 * price_foam_sample_us);
        fmt::print("ticks of a start,{},\n", ticks);
    }
    std::vector<sea::QueryPoint> points;
    for (int i = 0; i < 4096; ++i)
        points.push_back({i * 71.3, i * 17.7, 300'000});
    Result<std::unique_ptr<RebuiltSynthesizer>> own = RebuiltSynthesizer::start(
        [](const sea::RealizationPtr& realization,
           std::uint32_t epoch) -> Result<std::unique_ptr<Synthesizer>> {
            auto native = std::make_unique<NativeSynthesizer>();
            SEAWAY_TRY(native->set_sea(realization, epoch));
            return std::unique_ptr<Synthesizer>(std::move(native));
        },
        sea->realization, 1, nullptr);
    KeyframeSource source(sea, *std::move(own));
    const auto never = [] { return false; };
    const auto answer = [&](std::vector<sea::QueryPoint> some, bool exact) {
        PointQuestion question(std::move(some));
        while (!question.complete())
            exact ? question.sum_exactly(*sea, never)
                  : (void)question.sample(source, never).has_value();
    };
    answer({points.front()}, false);
    row("a point", least_us(5, [&](int) { answer(points, false); }) / 4096.0, price_point_us);
    points.resize(64);
    row("an exact point, of a million samples",
        least_us(5, [&](int) { answer(points, true); }) / 64.0 * 1e6 / samples,
        1e6 * price_exact_wave_us);
    for (std::size_t i = 0; i < points.size(); ++i)
        points[i].time_us += static_cast<sea::TimeUs>(i) * 7'000'000;
    row("an exact point at a time of its own, likewise",
        least_us(5, [&](int) { answer(points, true); }) / 64.0 * 1e6 / samples,
        1e6 * (price_exact_wave_us + price_moment_wave_us));
    return 0;
}
