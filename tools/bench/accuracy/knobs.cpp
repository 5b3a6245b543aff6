// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/accuracy/knobs.h"

#include <array>
#include <initializer_list>
#include <iterator>
#include <utility>

#include <fmt/format.h>

namespace seaway::bench {

namespace {

using Trials = std::vector<Trial>;

std::string on_curve(std::string_view curve, double x) {
    return fmt::format("{}@{:g}", curve, x);
}

/// Sums of all waves are slow: each so many-th point.
constexpr int summed_every = 4;

Configuration clean_on(const sea::Scene& scene, const std::string& device) {
    Configuration configuration = clean(scene);
    configuration.device = device;
    return configuration;
}

Trials cutoff(const sea::Scene& scene, const std::string& device) {
    Trials trials;
    for (const double k : {0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0}) {
        Configuration configuration = clean_on(scene, device);
        configuration.cascades.back().size *=
            2; // so that the truth has shorter waves than any trial
        configuration.k_max_radpm = k;
        configuration.evaluator = Evaluator::direct_sum;
        trials.push_back(
            {on_curve("cut", k), configuration, Measurement::answers, {.every = 4 * summed_every}});
    }
    return trials;
}

Trials grid(const sea::Scene& scene, const std::string& device) {
    Trials trials;
    for (const auto& [name, rule] :
         {std::pair("bilinear", SpaceRule::bilinear), std::pair("spline", SpaceRule::spline)})
        for (const int factor : {1, 2, 4, 8}) {
            Configuration configuration = clean_on(scene, device);
            for (sea::CascadeSpec& cascade : configuration.cascades)
                cascade.size = 64; // the same waves on grids of 64 to 512
            configuration.space = rule;
            configuration.oversampling = factor;
            trials.push_back({on_curve(name, 64.0 * factor),
                              configuration,
                              Measurement::answers,
                              {.octaves = factor <= 2}});
        }
    return trials;
}

Trials cascades(const sea::Scene& scene, const std::string& device) {
    Trials trials;
    const std::initializer_list<sea::CascadeSpec> layouts[] = {
        {{2111, 256}},
        {{2111, 256}, {211, 256}},
        {{2111, 256}, {317, 256}, {53, 256}},
        {{2111, 256}, {317, 256}, {53, 256}, {11, 256}}};
    for (std::size_t i = 0; i < std::size(layouts); ++i) {
        Configuration configuration = clean_on(scene, device);
        configuration.cascades = layouts[i];
        trials.push_back(
            {on_curve("count", static_cast<double>(i + 1)), configuration, Measurement::layout});
    }
    // Where the first band ends: six lattice steps of the second tile out.
    for (const double length_m : {200.0, 317.0, 400.0, 500.0, 650.0}) {
        Configuration configuration = clean_on(scene, device);
        configuration.cascades = {{2111, 256}, {length_m, 256}, {53, 256}};
        trials.push_back({on_curve("split", length_m), configuration, Measurement::layout});
    }
    return trials;
}

Trials tile(const sea::Scene& scene, const std::string& device) {
    Trials trials;
    for (const double length_m : {400.0, 700.0, 1000.0, 1500.0, 2111.0, 3000.0, 4000.0}) {
        Configuration configuration = clean_on(scene, device);
        configuration.cascades.front().length_m = length_m;
        trials.push_back({on_curve("length", length_m), configuration, Measurement::layout});
    }
    return trials;
}

Trials format(const sea::Scene& scene, const std::string& device) {
    Trials trials;
    for (const auto& [name, value] :
         {std::pair("f32", MapFormat::f32), std::pair("f16", MapFormat::f16),
          std::pair("snorm16", MapFormat::snorm16)}) {
        Configuration configuration = clean_on(scene, device);
        configuration.format = value;
        trials.push_back({name, configuration, Measurement::answers, {.octaves = true}});
    }
    return trials;
}

Trials transform(const sea::Scene& scene, const std::string& device) {
    Trials trials;
    for (const int size : {64, 128, 256, 512}) {
        Configuration configuration = clean_on(scene, device);
        configuration.cascades = {{500.0, size}};
        trials.push_back({on_curve("size", size), configuration, Measurement::transform});
    }
    return trials;
}

Trials phase(const sea::Scene& scene, const std::string& device) {
    Trials trials;
    for (const auto& [name, rule] :
         {std::pair("float32", PhaseRule::float32), std::pair("float64", PhaseRule::float64),
          std::pair("fixed point", PhaseRule::fixed_point)})
        for (int base = 0; base < static_cast<int>(std::size(time_bases_s)); ++base) {
            Configuration configuration = clean_on(scene, device);
            configuration.evaluator = Evaluator::direct_sum;
            configuration.phase = rule;
            trials.push_back({on_curve(name, time_bases_s[base]),
                              configuration,
                              Measurement::answers,
                              {.every = summed_every, .time_base = base}});
        }
    return trials;
}

Trials interval(const sea::Scene& scene, const std::string& device) {
    Trials trials;
    for (const auto& [name, rule] :
         {std::pair("hermite", TimeRule::hermite), std::pair("linear", TimeRule::linear),
          std::pair("hold", TimeRule::hold)})
        for (const double interval_s : {2.0, 1.0, 0.5, 0.25, 0.1, 0.05, 0.02}) {
            Configuration configuration = clean_on(scene, device);
            configuration.time = rule;
            configuration.interval_us = sea::us_from_seconds(interval_s);
            trials.push_back({on_curve(name, interval_s),
                              configuration,
                              Measurement::answers,
                              {.flicker = interval_s >= 0.05}});
        }
    return trials;
}

Trials codec(const sea::Scene& scene, const std::string& device) {
    Trials trials;
    for (const auto& [name, tiles] :
         {std::pair("bound", Tiles::whole), std::pair("compact bound", Tiles::compact),
          std::pair("predicted bound", Tiles::predicted)})
        for (const double bound_m : {1.0, 0.3, 0.1, 0.03, 0.01, 0.003, 0.001, 0.0003}) {
            Configuration configuration = clean_on(scene, device);
            configuration.interval_us =
                250'000; // as streams have it: what rates may cost depends on it
            configuration.codec_error_m = bound_m;
            configuration.tiles = tiles;
            trials.push_back({on_curve(name, bound_m),
                              configuration,
                              Measurement::answers,
                              {.octaves = bound_m == 0.1}});
        }
    return trials;
}

Trials inverse(const sea::Scene& scene, const std::string& device) {
    Trials trials;
    for (const int steps : {0, 1, 2, 3, 4, 6, 8}) {
        Configuration configuration = clean_on(scene, device);
        configuration.fixed_point_steps = steps;
        trials.push_back({on_curve("fixed point", steps), configuration});
    }
    for (const double tolerance_m : {1.0, 0.1, 0.01, 1e-3, 1e-4}) {
        Configuration configuration = clean_on(scene, device);
        configuration.tolerance_m = tolerance_m;
        trials.push_back({on_curve("newton", tolerance_m), configuration});
    }
    return trials;
}

Trials modes(const sea::Scene& scene, const std::string& device) {
    Trials trials;
    for (const int count : {16, 64, 256, 1024, 4096, 8192}) {
        Configuration configuration = clean_on(scene, device);
        configuration.evaluator = Evaluator::direct_sum;
        configuration.modes_kept = count;
        trials.push_back({on_curve("kept", count),
                          configuration,
                          Measurement::answers,
                          {.every = summed_every}});
    }
    return trials;
}

Trials batches(const sea::Scene& scene, const std::string& device) {
    struct Curve {
        const char* name;
        Asked asked;
        Evaluator evaluator;
        int largest;
    };
    constexpr Curve curves[] = {
        {"sampled, one thread", Asked::one_thread, Evaluator::maps, 100'000},
        {"sampled, all threads", Asked::all_threads, Evaluator::maps, 100'000},
        {"exact, one thread", Asked::one_thread, Evaluator::direct_sum, 1000},
        {"exact, all threads", Asked::all_threads, Evaluator::direct_sum, 1000},
        {"over a socket", Asked::socket, Evaluator::maps, 1000}};
    Trials trials;
    for (const Curve& curve : curves)
        for (int points = 1; points <= curve.largest; points *= 10) {
            Configuration configuration = balanced(scene);
            configuration.device = device;
            configuration.evaluator = curve.evaluator;
            trials.push_back({.value = on_curve(curve.name, points),
                              .configuration = configuration,
                              .measurement = Measurement::batch,
                              .batch = {points, curve.asked}});
        }
    return trials;
}

Trials choppiness(const sea::Scene& scene, const std::string& device) {
    Trials trials;
    for (const double factor : {0.0, 0.5, 1.0, 1.5}) {
        Configuration configuration = balanced(scene);
        configuration.device = device;
        configuration.choppiness = factor;
        // Where the sea folds, each answer looks for sheets.
        const int every = factor > 1.0 ? summed_every : 1;
        trials.push_back(
            {on_curve("factor", factor), configuration, Measurement::answers, {.every = every}});
    }
    return trials;
}

Trials latency(const sea::Scene& scene, const std::string& device) {
    Trials trials;
    for (const double late_s : {0.01, 0.02, 0.05, 0.1, 0.2, 0.5}) {
        Configuration configuration = clean_on(scene, device);
        configuration.latency_s = late_s;
        trials.push_back({on_curve("late", late_s), configuration});
    }
    return trials;
}

/// Who samples which maps: what a server answers, and what a client samples from its tiles.
Trials rung(const sea::Scene& scene, const std::string& device) {
    Configuration tiles = balanced(scene);
    tiles.device = device;
    Configuration answers = tiles;
    answers.codec_error_m = 0.0;
    Configuration exact_sum = answers;
    exact_sum.evaluator = Evaluator::direct_sum;
    Configuration compact = tiles, whole = tiles;
    compact.tiles = Tiles::compact;
    whole.tiles = Tiles::whole;
    return {{"predicted tiles", tiles},
            {"compact tiles", compact},
            {"whole tiles", whole},
            {"answers", answers},
            {"exact answers", exact_sum, Measurement::answers, {.every = summed_every}}};
}

Trials devices(const sea::Scene& scene, const std::string&) {
    Trials trials;
    for (const auto& [name, device, any] :
         {std::tuple("native", "native", false), std::tuple("lavapipe T", "llvmpipe", false),
          std::tuple("lavapipe W", "llvmpipe", true)}) {
        Configuration configuration = balanced(scene);
        configuration.device = device;
        configuration.any_device_kernels = any;
        trials.push_back({name, configuration});
    }
    return trials;
}

Trials combination(const sea::Scene& scene, const std::string& device) {
    Trials trials;
    for (const int size : {64, 128, 256, 512})
        for (const double error_m : {0.001, 0.003, 0.01, 0.03, 0.1}) {
            Configuration configuration = balanced(scene);
            configuration.device = device;
            for (sea::CascadeSpec& cascade : configuration.cascades)
                cascade.size = size;
            configuration.height_error_m = error_m;
            trials.push_back({fmt::format("{}@{:g}", size, error_m), configuration});
        }
    // And by hand, each knob with each other, which no budget has weighed.
    for (const int size : {128, 256})
        for (const double interval_s : {0.25, 0.5, 1.0})
            for (const double codec_m : {0.003, 0.03}) {
                Configuration configuration = balanced(scene);
                configuration.device = device;
                for (sea::CascadeSpec& cascade : configuration.cascades)
                    cascade.size = size;
                configuration.interval_us = sea::us_from_seconds(interval_s);
                configuration.codec_error_m = codec_m;
                trials.push_back(
                    {fmt::format("{}, {:g} s@{:g}", size, interval_s, codec_m), configuration});
            }
    return trials;
}

Trials named(const sea::Scene& scene, const std::string& device) {
    Trials trials;
    for (Named& one : named_configurations(scene)) {
        one.configuration.device = device;
        const bool summed = one.configuration.evaluator == Evaluator::direct_sum;
        const Extent extent{.every = summed ? summed_every : 1,
                            .octaves = one.name == "balanced",
                            .flicker = one.preset};
        trials.push_back({one.name, std::move(one.configuration), Measurement::answers, extent});
    }
    return trials;
}

constexpr std::array all_knobs{
    Knob{"named", "", named, true},     Knob{"grid", "K2", grid},
    Knob{"cutoff", "K1", cutoff},       Knob{"cascades", "K3", cascades},
    Knob{"tile", "K4", tile},           Knob{"format", "K5", format},
    Knob{"transform", "K6", transform}, Knob{"phase", "K7", phase},
    Knob{"interval", "K8", interval},   Knob{"codec", "K9", codec},
    Knob{"inverse", "K10", inverse},    Knob{"modes", "K11", modes},
    Knob{"batch", "K12", batches},      Knob{"choppiness", "K13", choppiness},
    Knob{"latency", "K14", latency},    Knob{"rung", "", rung},
    Knob{"device", "", devices},        Knob{"combination", "", combination}};

} // namespace

std::span<const Knob> knobs() {
    return all_knobs;
}

} // namespace seaway::bench
