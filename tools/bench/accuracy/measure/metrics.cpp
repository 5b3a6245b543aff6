// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/accuracy/measure/metrics.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <random>

#include "base/worse.h"

namespace seaway::bench {

namespace {

constexpr int resamples = 200;

/// Sums over the samples of one time.
struct Sums {
    double first = 0;
    double second = 0;
    double count = 0;
};

struct Interval {
    double value, low, high;
};

/// What `statistic` says of so many times, given how often each counts, and its interval by drawing times with replacement.
template <class Statistic>
Interval by_times(std::size_t times, Statistic statistic) {
    if (times == 0)
        return {0, 0, 0};
    std::vector<int> counts(times, 1);
    const double value = statistic(counts);
    std::mt19937_64 engine(1);
    std::vector<double> drawn;
    for (int r = 0; r < resamples; ++r) {
        std::fill(counts.begin(), counts.end(), 0);
        for (std::size_t i = 0; i < times; ++i)
            ++counts[engine() % times];
        drawn.push_back(statistic(counts));
    }
    std::sort(drawn.begin(), drawn.end());
    return {value, drawn[resamples / 40], drawn[resamples - 1 - resamples / 40]};
}

/// Of a function of sums over times.
template <class Statistic>
Interval by_times(const std::map<int, Sums>& times, Statistic statistic) {
    return by_times(times.size(), [&](std::span<const int> counts) {
        Sums sums;
        auto count = counts.begin();
        for (const auto& [time, part] : times) {
            sums.first += *count * part.first;
            sums.second += *count * part.second;
            sums.count += *count++ * part.count;
        }
        return statistic(sums);
    });
}

double root_mean_square(const Sums& sums) {
    return sums.count > 0 ? std::sqrt(sums.second / sums.count) : 0.0;
}

double mean(const Sums& sums) {
    return sums.count > 0 ? sums.first / sums.count : 0.0;
}

/// Values by time, of the samples that `which` takes.
template <class Which, class Value>
std::map<int, Sums> sums_of(std::span<const Sample> samples, Which which, Value value) {
    std::map<int, Sums> times;
    for (const Sample& sample : samples) {
        if (!which(sample))
            continue;
        const double v = value(sample);
        Sums& sums = times[sample.time];
        sums.first += v;
        sums.second += v * v;
        sums.count += 1;
    }
    return times;
}

/// The 99th percentile of a value, of the samples that `which` takes.
template <class Which, class Value>
Interval percentile_99(std::span<const Sample> samples, Which which, Value value) {
    struct Ranked {
        double value;
        std::size_t time; ///< a place in `sizes`
    };
    std::map<int, std::size_t> times;
    std::vector<std::ptrdiff_t> sizes;
    std::vector<Ranked> ranked;
    for (const Sample& sample : samples) {
        if (!which(sample))
            continue;
        const std::size_t time = times.emplace(sample.time, times.size()).first->second;
        sizes.resize(times.size());
        ++sizes[time];
        ranked.push_back({value(sample), time});
    }
    std::sort(ranked.begin(), ranked.end(),
              [](const Ranked& a, const Ranked& b) { return a.value > b.value; });
    return by_times(times.size(), [&](std::span<const int> counts) {
        const auto all =
            std::inner_product(counts.begin(), counts.end(), sizes.begin(), std::ptrdiff_t{0});
        // From the largest down: so many are as large as it.
        auto left = all - static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(all));
        const auto found = std::ranges::find_if(
            ranked, [&](const Ranked& one) { return (left -= counts[one.time]) <= 0; });
        return found->value;
    });
}

double height_error(const Sample& s) {
    return s.answer.height_m - s.truth.height_m;
}

double slope_error(const Sample& s) {
    const auto slope = [](const sea::Answer& a, int axis) {
        constexpr double upright_min = 0.1; // a steeper answer counts as this steep
        return -a.normal[axis] / std::max(a.normal[2], upright_min);
    };
    return std::hypot(slope(s.answer, 0) - slope(s.truth, 0),
                      slope(s.answer, 1) - slope(s.truth, 1));
}

double normal_angle_deg(const Sample& s) {
    // By the chord: the cosine of a small angle has lost it.
    double chord = 0;
    for (int i = 0; i < 3; ++i)
        chord += std::pow(s.answer.normal[i] - s.truth.normal[i], 2);
    return 2.0 * std::asin(std::min(1.0, 0.5 * std::sqrt(chord))) * 180.0 / std::numbers::pi;
}

double velocity_error(const Sample& s) {
    return std::hypot(s.answer.velocity_mps[0] - s.truth.velocity_mps[0],
                      s.answer.velocity_mps[1] - s.truth.velocity_mps[1],
                      s.answer.velocity_mps[2] - s.truth.velocity_mps[2]);
}

/// What the answers say of themselves.
void add_stated_bounds(std::span<const Sample> samples, double p99_m, std::vector<Figure>& all) {
    std::vector<double> bounds;
    double beyond = 0;
    for (const Sample& sample : samples) {
        if (sample.answer.flags & sea::answer_folded)
            continue; // states no bound
        if (!(sample.answer.error_m > 1e-6))
            return;
        bounds.push_back(sample.answer.error_m);
        beyond += std::abs(height_error(sample)) > sample.answer.error_m + sample.truth.error_m;
    }
    if (bounds.empty() || !(p99_m > 0))
        return;
    std::nth_element(bounds.begin(),
                     bounds.begin() + static_cast<std::ptrdiff_t>(bounds.size() / 2), bounds.end());
    all.push_back(exact("beyond_bound_pct", 100.0 * beyond / static_cast<double>(bounds.size())));
    all.push_back(exact("bound_over_p99", bounds[bounds.size() / 2] / p99_m));
}

} // namespace

std::vector<Figure> figures(std::span<const Sample> all_samples, double hs_m) {
    std::vector<Sample> samples;
    for (const Sample& sample : all_samples)
        if (!(sample.truth.flags & sea::answer_folded))
            samples.push_back(sample);
    double flagged = 0;
    for (const Sample& sample : samples)
        flagged += (sample.answer.flags & sea::answer_folded) != 0;
    const auto of_kind = [](PointKind kind) {
        return [kind](const Sample& s) { return s.kind == kind; };
    };
    const auto anywhere = of_kind(PointKind::anywhere);
    std::vector<Figure> all;
    const auto put = [&](const char* metric, const Interval& figure, double scale = 1.0) {
        all.push_back({metric, scale * figure.value, scale * figure.low, scale * figure.high});
    };
    const double percent_of_hs = hs_m > 0 ? 100.0 / hs_m : 0.0;
    const auto heights = sums_of(samples, anywhere, height_error);
    const Interval rms = by_times(heights, root_mean_square);
    double worst = 0;
    for (const Sample& sample : samples)
        worst = worse(worst, std::abs(height_error(sample)));
    const Interval p99 =
        percentile_99(samples, anywhere, [](const Sample& s) { return std::abs(height_error(s)); });
    put("rms_m", rms);
    put("rms_pct_hs", rms, percent_of_hs);
    put("p99_m", p99);
    put("p99_pct_hs", p99, percent_of_hs);
    put("mean_m", by_times(heights, mean));
    all.push_back(exact("max_m", worst));
    all.push_back(exact("max_pct_hs", percent_of_hs * worst));
    const auto crests = sums_of(samples, of_kind(PointKind::crest), height_error);
    const Interval crest = by_times(crests, mean);
    put("crest_m", crest);
    put("crest_pct_hs", crest, percent_of_hs);
    put("crest_rms_m", by_times(crests, root_mean_square));
    put("steep_rms_m",
        by_times(sums_of(samples, of_kind(PointKind::steep), height_error), root_mean_square));
    put("slope_rms", by_times(sums_of(samples, anywhere, slope_error), root_mean_square));
    put("normal_p99_deg", percentile_99(samples, anywhere, normal_angle_deg));
    put("velocity_rms_mps", by_times(sums_of(samples, anywhere, velocity_error), root_mean_square));
    all.push_back(
        exact("folded_pct", 100.0 * static_cast<double>(all_samples.size() - samples.size()) /
                                static_cast<double>(std::max<std::size_t>(all_samples.size(), 1))));
    all.push_back(
        exact("flagged_pct",
              100.0 * flagged / static_cast<double>(std::max<std::size_t>(samples.size(), 1))));
    add_stated_bounds(samples, p99.value, all);
    return all;
}

double flicker_m(std::span<const double> truth, std::span<const double> answers, int frames) {
    const auto count = static_cast<std::size_t>(frames);
    double squares = 0, terms = 0;
    for (std::size_t first = 0; first + count <= truth.size(); first += count)
        for (std::size_t i = first + 1; i + 1 < first + count; ++i) {
            const auto off = [&](std::size_t n) { return answers[n] - truth[n]; };
            const double second = off(i - 1) - 2.0 * off(i) + off(i + 1);
            squares += second * second;
            terms += 1;
        }
    return terms > 0 ? std::sqrt(squares / terms) : 0.0;
}

} // namespace seaway::bench
