// SPDX-License-Identifier: Apache-2.0
// What the parts of a question cost on this machine, beside what they are priced at
// (server/simulation/price.h; docs/performance/load.md has the figures). One CSV row a part.
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

/// What the scene's sea costs, part by part.
class Costs {
  public:
    explicit Costs(RunningSeaPtr sea) : sea_(std::move(sea)) {
        (void)device_.set_sea(sea_->realization, 1).has_value();
        for (const sea::CascadeModes& modes : sea_->realization->cascades)
            samples_ += static_cast<double>(modes.spec.size) * modes.spec.size;
    }

    void keyframes() {
        const sea::FieldSet fields = sea_->sampler_fields();
        row("a million samples of a field",
            a_million(least_us(40, [&](int i) { (void)made(i * 700'000, fields); })) /
                fields.size(),
            1e6 * price_sample_us);
        const std::vector<NewKeyframePtr> keyframes = made(0, fields);
        const double splines_us = least_us(20, [&](int) {
            for (const NewKeyframePtr& keyframe : keyframes)
                (void)sea::SplineMap(*keyframe);
        });
        row("splines of a million samples", a_million(splines_us) / fields.size(),
            1e6 * price_spline_sample_us);
    }

    void foam() {
        if (!sea_->foam_law)
            return;
        const SeaCoursePtr course = server::steady_course(sea_);
        const int ticks = FoamMaps(course).ticks_to(0, 0);
        const double size = sea_->realization->cascades[0].spec.size;
        const double walk_us =
            least_us(3, [&](int) { // what is made once for a law is made by the first
                (void)FoamMaps(course).walk_towards(device_, 0, 0, ticks).has_value();
            });
        row("a tick of foam, of a million samples", walk_us / ticks * 1e6 / size / size,
            1e6 * price_foam_sample_us);
        fmt::print("ticks of a start,{},\n", ticks);
    }

    void points() {
        const SeaCoursePtr course = server::steady_course(sea_);
        const Memory memory;
        KeyframeSource source(
            course, RebuiltSynthesizer::start(native, sea_->realization, 1, nullptr).value(),
            memory);
        server::Surfaces surfaces(course, source, memory);
        std::vector<sea::QueryPoint> points;
        for (int i = 0; i < 4096; ++i)
            points.push_back({i * 71.3, i * 17.7, 300'000});
        const auto never = [] { return false; };
        const auto sampled = [&] {
            PointQuestion question(points);
            while (!question.complete())
                if (question.hand() == server::Hand::simulation)
                    (void)question.make_keyframes(surfaces).has_value();
                else
                    question.sample(surfaces, never);
        };
        row("a point", least_us(6, [&](int) { sampled(); }) / 4096.0, price_point_us);
        points.resize(64);
        server::SumsRoom sums(Memory().room(server::MemoryUse::sums));
        const auto summed = [&](int) {
            PointQuestion question(points);
            while (!question.complete())
                question.sum_exactly(*server::steady_course(sea_), never, sums);
        };
        row("an exact point, of a million samples", a_million(least_us(5, summed)) / 64,
            1e6 * price_exact_wave_us);
        const auto dived = [&](int) {
            server::PointsAsked asked(points);
            asked.z_m.assign(points.size(), -5.0);
            PointQuestion question(asked);
            while (!question.complete())
                question.sum_exactly(*server::steady_course(sea_), never, sums);
        };
        row("an exact point and the water below, likewise", a_million(least_us(5, dived)) / 64,
            1e6 * (price_exact_wave_us + price_below_wave_us));
        for (std::size_t i = 0; i < points.size(); ++i)
            points[i].time_us += static_cast<sea::TimeUs>(i) * 7'000'000;
        row("an exact point at a time of its own, likewise", a_million(least_us(5, summed)) / 64,
            1e6 * (price_exact_wave_us + price_moment_wave_us));
    }

  private:
    static Result<std::unique_ptr<Synthesizer>> native(const sea::RealizationPtr& realization,
                                                       std::uint32_t epoch, server::Making) {
        auto made = std::make_unique<NativeSynthesizer>();
        SEAWAY_TRY(made->set_sea(realization, epoch));
        return std::unique_ptr<Synthesizer>(std::move(made));
    }
    std::vector<NewKeyframePtr> made(sea::TimeUs time_us, sea::FieldSet fields) {
        std::vector<KeyframeRequest> requests;
        for (int c = 0; c < static_cast<int>(sea_->budget.cascades.size()); ++c)
            requests.push_back({c, time_us, fields});
        return device_.synthesize(requests).value();
    }
    double a_million(double us) const { return us * 1e6 / samples_; }

    const RunningSeaPtr sea_;
    NativeSynthesizer device_;
    double samples_ = 0;
};

} // namespace

int main(int argc, char** argv) {
    const Result<sea::Scene> scene =
        argc == 2 ? sea::read_scene(argv[1]) : Error{"load_costs SCENE.toml"};
    if (!scene)
        return std::fputs((scene.error().message + "\n").c_str(), stderr), 2;
    Costs costs(make_running_sea(*scene, 1).value());
    std::printf("part,measured_us,priced_us\n");
    costs.keyframes();
    costs.foam();
    costs.points();
    return 0;
}
