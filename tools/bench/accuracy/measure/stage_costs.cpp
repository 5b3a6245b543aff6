// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/accuracy/measure/stage_costs.h"

#include <algorithm>

#include "base/elapsed.h"
#include "base/quantile.h"
#include "tools/bench/accuracy/seas/sea_states.h"

namespace seaway::bench {

namespace {

constexpr int keyframes_a_round = 4;

/// A gale on one tile of this size: what keyframes are timed with. As full of waves as any.
Result<sea::RealizationPtr> timed_sea(int size) {
    SEAWAY_TRY_LET(sea::Scene scene, sea_state("gale_deep", 1));
    scene.cascades = {{2.0 * size, size}};
    SEAWAY_TRY_LET(sea::Realization sea, sea::realize(scene));
    return std::make_shared<const sea::Realization>(std::move(sea));
}

sea::FieldSet fields_of(SpaceRule space) {
    return space == SpaceRule::spline ? sea::surface_fields : sea::linear_fields;
}

} // namespace

Result<Stage> StageCosts::keyframe(const Configuration& configuration, int size, Devices& devices) {
    const Key key{configuration.device, configuration.any_device_kernels, size,
                  configuration.space == SpaceRule::bilinear};
    const auto known = keyframes_.find(key);
    if (known != keyframes_.end())
        return known->second;
    SEAWAY_TRY_LET(server::Synthesizer * device, devices.get(configuration));
    SEAWAY_TRY_LET(sea::RealizationPtr sea, timed_sea(size));
    SEAWAY_TRY(device->set_sea(std::move(sea), 1));
    std::vector<double> cpu, own;
    sea::TimeUs time_us = 0;
    for (int round = -1; round < rounds_; ++round) {
        const double cpu_before = process_cpu_seconds();
        const double own_before = device->counters().device_seconds;
        for (int i = 0; i < keyframes_a_round; ++i) {
            const server::KeyframeRequest request{0, time_us += 1'000'003,
                                                  fields_of(configuration.space)};
            SEAWAY_TRY(device->synthesize({&request, 1}));
        }
        if (round < 0)
            continue;
        cpu.push_back((process_cpu_seconds() - cpu_before) * 1e3 / keyframes_a_round);
        own.push_back((device->counters().device_seconds - own_before) * 1e3 / keyframes_a_round);
    }
    return keyframes_[key] = {median(cpu), median(own)};
}

double StageCosts::spline_ms(int size) {
    double& known = splines_[size];
    if (known > 0)
        return known;
    sea::Keyframe keyframe;
    keyframe.size = size;
    keyframe.length_m = 1.0;
    keyframe.fields = sea::surface_fields;
    keyframe.values.assign(sea::surface_fields.size() * keyframe.plane_size(), 0.5f);
    std::vector<double> cpu;
    for (int round = 0; round < std::max(rounds_ / 2, 3); ++round) {
        const double before = process_cpu_seconds();
        const sea::SplineMap map(keyframe);
        cpu.push_back((process_cpu_seconds() - before) * 1e3);
    }
    return known = median(cpu);
}

Result<std::vector<Figure>> StageCosts::figures(const ConfiguredSea& sea, Devices& devices) {
    const Configuration& configuration = sea.configuration();
    if (configuration.evaluator == Evaluator::direct_sum)
        return std::vector{exact("keyframe_cpu_ms_per_s", 0), exact("device_ms_per_s", 0),
                           exact("bytes_per_s", 0), exact("memory_mb", 0)};
    double keyframe_ms = 0, device_ms = 0, splines_ms = 0, encode_ms = 0, decode_ms = 0, bytes = 0,
           memory = 0;
    // Of a map that is made anew for each time there is one.
    const double held = configuration.time == TimeRule::every_frame ? 1.0 : 2.0;
    for (std::size_t c = 0; c < sea.waves().used->cascades.size(); ++c) {
        const int size = sea.waves().used->cascades[c].spec.size;
        const double a_second =
            1.0 / sea::seconds_from_us(sea.waves().budget.cascades[c].interval_us);
        SEAWAY_TRY_LET(const Stage stage, keyframe(configuration, size, devices));
        keyframe_ms += a_second * stage.cpu_ms;
        device_ms += a_second * stage.device_ms;
        const auto points = static_cast<double>(size) * size;
        if (configuration.space == SpaceRule::spline) {
            splines_ms += a_second * spline_ms(size);
            memory += held * static_cast<double>(sea::SplineMap::bytes_of(size));
        } else {
            const double values = configuration.format == MapFormat::f32 ? 4.0 : 2.0;
            memory += held * points * sea::linear_field_count * values;
        }
        const CodingCost coding = sea.coding(c);
        if (coding.keyframes == 0)
            continue;
        const double each = a_second / static_cast<double>(coding.keyframes);
        encode_ms += 1e3 * each * coding.encode_s;
        decode_ms += 1e3 * each * coding.decode_s;
        bytes += each * static_cast<double>(coding.bytes);
    }
    return std::vector{exact("keyframe_cpu_ms_per_s", keyframe_ms),
                       exact("device_ms_per_s", device_ms),
                       exact("spline_ms_per_s", splines_ms),
                       exact("encode_ms_per_s", encode_ms),
                       exact("decode_ms_per_s", decode_ms),
                       exact("bytes_per_s", bytes),
                       exact("memory_mb", memory / 1e6)};
}

Timed query_ns(const ConfiguredSea& sea, std::span<const sea::QueryPoint> points) {
    const auto timed = [&](std::size_t count) {
        const double before = process_cpu_seconds();
        double sum = 0;
        for (std::size_t i = 0; i < count; ++i)
            sum += sea.answer(points[i]).height_m;
        const double spent = process_cpu_seconds() - before;
        // Used, so that no compiler leaves the answers out.
        return sum == 1e300 ? 0.0 : spent * 1e9 / static_cast<double>(count);
    };
    // Sums of all waves and searches for sheets take a thousand times a plain answer: a fiftieth of
    // a second is enough of any of them, and more rounds tell what a round may be off by.
    constexpr int rounds = 9;
    constexpr double round_ns = 0.02e9;
    const bool all_alike = sea.configuration().evaluator == Evaluator::direct_sum;
    const std::size_t few = std::min<std::size_t>(points.size(), all_alike ? 16 : 64);
    const double affordable = round_ns / std::max(timed(few), 1.0);
    const auto count = static_cast<std::size_t>(
        std::clamp(all_alike ? 0 : affordable, static_cast<double>(few),
                   static_cast<double>(std::min<std::size_t>(points.size(), 2048))));
    std::vector<double> each;
    for (int round = 0; round < rounds; ++round)
        each.push_back(timed(count));
    const auto [least, most] = std::minmax_element(each.begin(), each.end());
    return {median(each), *least, *most};
}

} // namespace seaway::bench
