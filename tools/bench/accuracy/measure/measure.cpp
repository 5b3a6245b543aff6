// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/accuracy/measure/measure.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "sea/waves/statistics/moments.h"
#include "tools/bench/accuracy/measure/laws.h"
#include "tools/bench/accuracy/measure/octaves.h"
#include "tools/bench/accuracy/truth/in_threads.h"

namespace seaway::bench {

namespace {

/// Some 2 us each from maps, 30 ms and more where all waves are summed.
constexpr std::size_t points_a_part = 16;

bool within(const SamplePoint& point, const Extent& extent) {
    return !extent.time_base ||
           point.time % static_cast<int>(std::size(time_bases_s)) == *extent.time_base;
}

Result<double> flicker(ConfiguredSea& sea, const Movie& movie) {
    std::vector<double> heights(movie.heights_m.size());
    for (int frame = 0; frame < Movie::frames; ++frame) {
        SEAWAY_TRY(sea.go_to(movie.time_us(frame)));
        in_parts(movie.at.size(), points_a_part, [&](std::size_t begin, std::size_t end) {
            for (std::size_t p = begin; p < end; ++p)
                heights[p * Movie::frames + static_cast<std::size_t>(frame)] =
                    sea.answer(movie.at[p]).height_m;
        });
    }
    return flicker_m(movie.heights_m, heights, Movie::frames);
}

void add_prediction(const Prediction& p, std::vector<Figure>& all) {
    all.push_back(exact("predicted_rms_m", p.rms_m()));
    const std::pair<const char*, double> parts[] = {
        {"space", p.space_m},   {"time", p.time_m},       {"codec", p.codec_m},
        {"format", p.format_m}, {"inverse", p.inverse_m}, {"modes", p.modes_m},
        {"phase", p.phase_m},   {"latency", p.latency_m}};
    for (const auto& [name, value] : parts)
        if (value > 0)
            all.push_back(exact(fmt::format("predicted_{}_m", name), value));
    if (p.slope_rms > 0)
        all.push_back(exact("predicted_slope_rms", p.slope_rms));
}

void add_missing(const Missing& missing, std::vector<Figure>& all) {
    all.push_back(exact("missing_longer_m", missing.longer_m));
    all.push_back(exact("missing_shorter_m", missing.shorter_m));
    all.push_back(exact("missing_between_m", missing.between_m));
    all.push_back(exact("missing_slope_rms", missing.slope_rms));
    all.push_back(exact("missing_rms_m", missing.rms_m()));
}

void add_octaves(std::span<const Octave> octaves, std::vector<Figure>& all) {
    for (const Octave& octave : octaves)
        for (const auto& [metric, value] :
             {std::pair("energy_pct", octave.energy_error_pct),
              std::pair("energy_worst_pct", octave.energy_error_worst_pct),
              std::pair("phase_rad", octave.phase_error_rad)})
            all.push_back(exact(fmt::format("{}@{:g}", metric, octave.k_radpm), value));
}

double hs_of(const ConfiguredSea& sea) {
    return 4.0 * std::sqrt(variance_of(*sea.waves().all));
}

double codec_over_bound(const ConfiguredSea& sea) {
    double over_bound = 0;
    for (std::size_t c = 0; c < sea.waves().used->cascades.size(); ++c)
        over_bound = std::max(over_bound, sea.coding(c).worst_over_bound);
    return over_bound;
}

/// What the further seas add to the first.
struct FurtherSeas {
    std::vector<Sample> samples;
    std::vector<Figure> by_seed;
    double p99_worst_m = 0;
    double codec_over_bound = 0;

    void add_seed(std::uint64_t seed, const std::vector<Sample>& of_seed, double hs_m) {
        const std::vector<Figure> all = figures(of_seed, hs_m);
        for (const char* metric : {"rms_m", "p99_m"})
            for (const Figure& figure : all)
                if (figure.metric == metric)
                    by_seed.push_back({fmt::format("{}@seed={}", metric, seed), figure.value,
                                       figure.low, figure.high});
        by_seed.push_back(exact(fmt::format("hs_m@seed={}", seed), hs_m));
        p99_worst_m = std::max(p99_worst_m, value_of(all, "p99_m"));
    }
};

Result<FurtherSeas> further_seas(std::span<const DrawnSea> seas, const Configuration& configuration,
                                 const Extent& extent, Devices& devices) {
    // Times of different seas are different draws, whatever they are numbered.
    constexpr int times_apart = 1 << 16;
    FurtherSeas further;
    int number = 0;
    for (const DrawnSea& drawn : seas) {
        SEAWAY_TRY_LET(const auto sea, ConfiguredSea::create(drawn.waves, configuration, devices));
        SEAWAY_TRY_LET(std::vector<Sample> samples, sample_answers(*sea, drawn.truth, extent));
        further.add_seed(drawn.waves.state.seed, samples, hs_of(*sea));
        further.codec_over_bound = std::max(further.codec_over_bound, codec_over_bound(*sea));
        ++number;
        for (Sample& sample : samples)
            sample.time += number * times_apart;
        further.samples.insert(further.samples.end(), samples.begin(), samples.end());
    }
    return further;
}

Result<std::vector<Figure>> errors_of(ConfiguredSea& sea, const Truth& truth, const Extent& extent,
                                      std::uint64_t seed = 0, FurtherSeas further = {}) {
    SEAWAY_TRY_LET(std::vector<Sample> samples, sample_answers(sea, truth, extent));
    const double hs_m = hs_of(sea);
    const bool several = !further.samples.empty();
    if (several)
        further.add_seed(seed, samples, hs_m);
    samples.insert(samples.end(), further.samples.begin(), further.samples.end());
    std::vector<Figure> all = figures(samples, hs_m);
    if (several)
        all.push_back(exact("p99_worst_m", further.p99_worst_m));
    all.insert(all.end(), further.by_seed.begin(), further.by_seed.end());
    all.push_back(exact("samples", static_cast<double>(samples.size())));
    all.push_back(exact("hs_m", hs_m));
    add_missing(missing_waves(sea.waves()), all);
    all.push_back(
        exact("total_rms_m", std::hypot(value_of(all, "rms_m"), value_of(all, "missing_rms_m"))));
    if (extent.flicker) {
        SEAWAY_TRY_LET(const double metres, flicker(sea, truth.movie));
        all.push_back(exact("flicker_m", metres));
    }
    const double over_bound = std::max(further.codec_over_bound, codec_over_bound(sea));
    if (over_bound > 0)
        all.push_back(exact("codec_over_bound", over_bound));
    return all;
}

/// Points that answers are timed at: those anywhere.
std::vector<sea::QueryPoint> timed_points(const Truth& truth) {
    std::vector<sea::QueryPoint> points;
    for (const SamplePoint& point : truth.points)
        if (point.kind == PointKind::anywhere)
            points.push_back(point.at);
    return points;
}

} // namespace

Result<std::vector<Sample>> sample_answers(ConfiguredSea& sea, const Truth& truth,
                                           const Extent& extent) {
    std::vector<std::size_t> wanted;
    for (std::size_t i = 0; i < truth.points.size(); i += static_cast<std::size_t>(extent.every))
        if (within(truth.points[i], extent))
            wanted.push_back(i);
    std::vector<Sample> samples(wanted.size());
    for (std::size_t first = 0, last = 0; first < wanted.size(); first = last) {
        const SamplePoint& now = truth.points[wanted[first]];
        while (last < wanted.size() && truth.points[wanted[last]].time == now.time)
            ++last;
        SEAWAY_TRY(sea.go_to(now.at.time_us));
        in_parts(last - first, points_a_part, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = first + begin; i < first + end; ++i) {
                const SamplePoint& point = truth.points[wanted[i]];
                samples[i] = {point.kind, point.time, truth.answers[wanted[i]],
                              sea.answer(point.at)};
            }
        });
    }
    return samples;
}

Result<std::vector<Figure>> measure_errors(const sea::Scene& scene,
                                           const Configuration& configuration, const Truth& truth,
                                           const Extent& extent, Devices& devices) {
    SEAWAY_TRY_LET(const auto sea, ConfiguredSea::create(scene, configuration, devices));
    return errors_of(*sea, truth, extent);
}

Result<std::vector<Figure>> measure(std::span<const DrawnSea> seas,
                                    const Configuration& configuration, const Extent& extent,
                                    Devices& devices, StageCosts& costs) {
    // First the further ones: a device makes the maps of one sea at a time.
    SEAWAY_TRY_LET(FurtherSeas further,
                   further_seas(seas.subspan(1), configuration, extent, devices));
    const Truth& truth = seas[0].truth;
    SEAWAY_TRY_LET(const auto sea, ConfiguredSea::create(seas[0].waves, configuration, devices));
    SEAWAY_TRY_LET(std::vector<Figure> all,
                   errors_of(*sea, truth, extent, seas[0].waves.state.seed, std::move(further)));
    const int base = extent.time_base.value_or(0);
    add_prediction(predict(sea->waves(), configuration, sample_time_us(base)), all);
    if (extent.octaves) {
        SEAWAY_TRY_LET(const std::vector<Octave> by_octave, octaves(*sea, sample_time_us(1)));
        add_octaves(by_octave, all);
    }
    const Timed answer_ns = query_ns(*sea, timed_points(truth));
    // Last: timing takes the device to a sea of its own.
    SEAWAY_TRY_LET(const std::vector<Figure> cost, costs.figures(*sea, devices));
    all.insert(all.end(), cost.begin(), cost.end());
    all.push_back({"query_ns", answer_ns.median, answer_ns.least, answer_ns.most});
    const auto work_ms = [&](double each_ns) {
        return value_of(cost, "keyframe_cpu_ms_per_s") + value_of(cost, "spline_ms_per_s") +
               value_of(cost, "encode_ms_per_s") + queries_per_s * each_ns * 1e-6;
    };
    all.push_back({"work_ms_per_s", work_ms(answer_ns.median), work_ms(answer_ns.least),
                   work_ms(answer_ns.most)});
    return all;
}

Result<std::vector<Figure>> measure_layout(const sea::Scene& scene,
                                           const Configuration& configuration) {
    SEAWAY_TRY_LET(const Waves waves, configured_waves(scene, configuration));
    std::vector<Figure> all;
    add_missing(missing_waves(waves), all);
    const sea::SeaSummary summary = sea::summarize(waves.state, *waves.used);
    const double hs_m = summary.requested.significant_height_m;
    all.push_back(exact("hs_m", hs_m));
    all.push_back(exact("hs_scatter_pct", 100.0 * sea::hs_scatter(summary)));
    all.push_back(exact("peak_wavelengths", waves.used->cascades.front().spec.length_m /
                                                summary.longest_peak_wavelength_m));
    std::map<int, double> held;
    for (const sea::CascadeModes& cascade : waves.used->cascades)
        for_each_wave(cascade, [&](std::size_t, double kx, double ky, double v, double) {
            held[static_cast<int>(std::floor(std::log2(std::hypot(kx, ky))))] += v;
        });
    const sea::Dispersion dispersion = waves.state.dispersion();
    for (const auto& [exponent, variance] : held) {
        const double k = std::ldexp(1.0, exponent);
        all.push_back(exact(fmt::format("held_m@{:g}", k), std::sqrt(variance)));
        all.push_back(exact(fmt::format("asked_m@{:g}", k),
                            std::sqrt(sea::requested_variance(waves.state, dispersion.omega(k),
                                                              dispersion.omega(2 * k)))));
    }
    return all;
}

Result<std::vector<Figure>>
measure_transform(const sea::Scene& scene, const Configuration& configuration, Devices& devices) {
    SEAWAY_TRY_LET(const Waves waves, configured_waves(scene, configuration));
    SEAWAY_TRY_LET(server::Synthesizer * device, devices.get(configuration));
    SEAWAY_TRY(device->set_sea(waves.used, 1));
    constexpr int probes = 256;
    const sea::TimeUs time_us = sample_time_us(1);
    const server::KeyframeRequest request{0, time_us, {sea::Field::height}};
    SEAWAY_TRY_LET(const auto made, device->synthesize({&request, 1}));
    const sea::Keyframe& map = *made[0];
    const sea::DirectSum sum(waves.used);
    const sea::DirectSum::Moment now = sum.at_time(time_us);
    double squares = 0, errors = 0;
    for (int i = 0; i < probes; ++i) {
        const int x = i * 2654435 % map.size, y = i * 40503 % map.size;
        const double spacing = map.length_m / map.size;
        const double height = now.at(x * spacing, y * spacing).height;
        const auto index = static_cast<std::size_t>(y) * static_cast<std::size_t>(map.size) +
                           static_cast<std::size_t>(x);
        errors += std::pow(static_cast<double>(map.values[index]) - height, 2);
        squares += height * height;
    }
    // benchFFT: float transforms of this length have 1.3e-7 to 1.7e-7 of their rms.
    return std::vector{exact("transform_error", std::sqrt(errors / squares)),
                       exact("predicted_transform_error", 1.5e-7)};
}

} // namespace seaway::bench
