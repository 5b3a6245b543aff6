// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/accuracy/truth/points.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <random>

#include "base/check.h"
#include "sea/surface/inverse.h"
#include "sea/surface/surface.h"
#include "server/device/native_synthesizer.h"

namespace seaway::bench {

namespace {

constexpr double reach_m = 4000.0;
/// The best of so many by height or by squeeze: one in a hundred.
constexpr std::size_t candidates_each = 100;

struct Candidate {
    double x_m, y_m, height_m, jacobian;
};

/// The sea at one moment, from maps of that moment: near enough to choose places.
sea::Surface surface_now(server::NativeSynthesizer& device, const sea::Realization& sea,
                         sea::TimeUs time_us) {
    std::vector<server::KeyframeRequest> requests;
    for (int c = 0; c < static_cast<int>(sea.cascades.size()); ++c)
        requests.push_back({c, time_us, sea::surface_fields});
    const auto keyframes = device.synthesize(requests);
    SEAWAY_CHECK(keyframes.has_value(), "native synthesis");
    std::vector<sea::SplinePair> pairs;
    for (const server::NewKeyframePtr& keyframe : *keyframes) {
        auto map = std::make_shared<const sea::SplineMap>(*keyframe);
        pairs.push_back({map, map});
    }
    return {std::move(pairs), sea.choppiness, {}, {}};
}

/// The first `count` by `before`, as points.
template <class Before>
void take(std::vector<Candidate>& candidates, std::size_t count, Before before, PointKind kind,
          int time, sea::TimeUs time_us, std::vector<SamplePoint>& points) {
    std::partial_sort(candidates.begin(), candidates.begin() + static_cast<std::ptrdiff_t>(count),
                      candidates.end(), before);
    for (std::size_t i = 0; i < count; ++i)
        points.push_back({{candidates[i].x_m, candidates[i].y_m, time_us}, kind, time});
}

} // namespace

sea::TimeUs sample_time_us(int index) {
    // A step that spreads 32 times evenly over each interval that keyframes may have: what Hermite misses there, as
    // (s (1 - s))^4, has a mean within 7 % of the true one; of 8 times within 27 %.
    constexpr sea::TimeUs step_us = 1'778'000;
    const double base_s = time_bases_s[static_cast<std::size_t>(index) % std::size(time_bases_s)];
    return sea::us_from_seconds(base_s) + index * step_us;
}

std::vector<SamplePoint> sample_points(const sea::RealizationPtr& sea, const Sampling& sampling,
                                       std::uint64_t seed) {
    server::NativeSynthesizer device;
    SEAWAY_CHECK(device.set_sea(sea, 1).has_value(), "native synthesis takes any sea");
    std::mt19937_64 engine(seed);
    const auto uniform = [&] {
        return reach_m * (2.0 * static_cast<double>(engine() >> 11) * 0x1p-53 - 1.0);
    };
    const auto a_time = static_cast<std::size_t>(sampling.points);
    std::vector<SamplePoint> points;
    for (int t = sampling.first_time; t < sampling.times; t += sampling.time_step) {
        const sea::TimeUs time_us = sample_time_us(t);
        for (std::size_t i = 0; i < a_time / 2; ++i) {
            const double x_m = uniform();
            points.push_back({{x_m, uniform(), time_us}, PointKind::anywhere, t});
        }
        const sea::Surface surface = surface_now(device, *sea, time_us);
        std::vector<Candidate> candidates;
        for (std::size_t i = 0; i < candidates_each * (a_time / 4); ++i) {
            const double x_m = uniform(), y_m = uniform();
            const sea::LagrangianPoint p = surface.at(x_m, y_m, time_us);
            candidates.push_back({x_m + sea->choppiness.x * p.displacement_x,
                                  y_m + sea->choppiness.y * p.displacement_y, p.height,
                                  sea::jacobian(p, sea->choppiness)});
        }
        take(
            candidates, a_time / 4,
            [](const Candidate& a, const Candidate& b) { return a.height_m > b.height_m; },
            PointKind::crest, t, time_us, points);
        take(
            candidates, a_time / 4,
            [](const Candidate& a, const Candidate& b) { return a.jacobian < b.jacobian; },
            PointKind::steep, t, time_us, points);
    }
    return points;
}

} // namespace seaway::bench
