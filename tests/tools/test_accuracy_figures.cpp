// SPDX-License-Identifier: Apache-2.0
// What the figures of the accuracy page mean, without a run of the program.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "sea/surface/budget/spending.h"
#include "tests/support/folder.h"
#include "tools/bench/accuracy/measure/batches.h"
#include "tools/bench/accuracy/measure/measure.h"
#include "tools/bench/accuracy/measure/metrics.h"
#include "tools/bench/accuracy/measure/octaves.h"
#include "tools/bench/accuracy/seas/half.h"
#include "tools/bench/accuracy/seas/naive.h"
#include "tools/bench/accuracy/seas/sea_states.h"
#include "tools/bench/accuracy/seas/waves.h"
#include "tools/bench/accuracy/truth/truth.h"

namespace seaway::bench {
namespace {

/// In place of the sea of a state, one that differs in this alone.
Waves waves_with(const std::function<void(sea::Realization&)>& change) {
    const sea::Scene scene = sea_state("calm_shallow", 5).value();
    Waves waves = configured_waves(scene, balanced(scene)).value();
    auto all = std::make_shared<sea::Realization>(*waves.all);
    change(*all);
    waves.all = all;
    return waves;
}

TEST(KeptTruth, of_a_sea_that_differs_in_anything_is_not_taken_for_that_of_another) {
    const std::string folder = tests::folder().file("truths");
    const Sampling few{.points = 4, .times = 2, .film = false};
    const auto answer = [&](const std::function<void(sea::Realization&)>& change) {
        return reference_truth(waves_with(change), few, 5, folder).value().answers.back().height_m;
    };
    const auto kept = [&] {
        return std::distance(std::filesystem::directory_iterator(folder), {});
    };
    const double given_m = answer([](sea::Realization&) {});
    EXPECT_EQ(answer([](sea::Realization&) {}), given_m);
    ASSERT_EQ(kept(), 1);
    sea::SineField sine{.kind = sea::SineKind::sine, .length_m = 100};
    sine.waves.push_back({0.5, 0.1, 0.2, 0.3, sea::rate_from_omega(2.0), 2.0});
    const std::vector<std::function<void(sea::Realization&)>> changes{
        [](sea::Realization& sea) { sea.choppiness.y -= 0.7; },
        [](sea::Realization& sea) { sea.choppiness.x += 0.004; },
        [](sea::Realization& sea) { sea.cascades[0].spec.length_m *= 1.01; },
        [](sea::Realization& sea) { sea.cascades[0].depth_m /= 2; },
        [](sea::Realization& sea) { sea.loop_period_us = 1; },
        [&](sea::Realization& sea) { sea.cascades[0].sines = {sine}; }};
    for (std::size_t i = 0; i < changes.size(); ++i) {
        EXPECT_NE(answer(changes[i]), given_m) << "change " << i;
        EXPECT_EQ(kept(), static_cast<std::ptrdiff_t>(2 + i)) << "change " << i;
    }
}

/// Every finite half above zero, by its definition (IEEE 754): 10 bits of mantissa, 5 of exponent.
std::vector<double> halves() {
    std::vector<double> all;
    for (int bits = 0; bits < 0x7C00; ++bits) {
        const int exponent = bits >> 10, mantissa = bits & 0x3FF;
        all.push_back(exponent == 0 ? std::ldexp(mantissa, -24)
                                    : std::ldexp(1024 + mantissa, exponent - 25));
    }
    return all;
}

TEST(AccuracyFigures, a_float_as_half_is_the_nearest_of_all_halves) {
    const std::vector<double> all = halves();
    for (std::size_t i = 0; i + 1 < all.size(); ++i)
        for (const double share : {0.0, 0.2, 0.49, 0.51, 0.8}) {
            const double between = all[i] + share * (all[i + 1] - all[i]);
            const auto value = static_cast<float>(between);
            const auto nearest = static_cast<float>(share < 0.5 ? all[i] : all[i + 1]);
            ASSERT_EQ(rounded_to_half(value), nearest) << between;
            ASSERT_EQ(rounded_to_half(-value), -nearest) << between;
        }
}

double figure(const std::vector<Figure>& all, std::string_view metric) {
    const auto found =
        std::find_if(all.begin(), all.end(), [&](const Figure& f) { return f.metric == metric; });
    return found == all.end() ? std::nan("") : found->value;
}

// A velocity or a slope that is off along one axis alone is off by that much, whichever it is.
TEST(AccuracyFigures, every_axis_of_an_answer_counts_alike) {
    const auto of = [](const sea::Answer& truth, const sea::Answer& answer) {
        const Sample sample{PointKind::anywhere, 0, truth, answer};
        return figures({&sample, 1}, 1.0);
    };
    for (int axis = 0; axis < 3; ++axis) {
        sea::Answer truth, answer;
        for (int other = 0; other < 3; ++other)
            truth.velocity_mps[other] = answer.velocity_mps[other] = 1.0 + other;
        EXPECT_EQ(figure(of(truth, answer), "velocity_rms_mps"), 0.0);
        answer.velocity_mps[axis] += 0.25;
        EXPECT_NEAR(figure(of(truth, answer), "velocity_rms_mps"), 0.25, 1e-12) << axis;
    }
    for (int axis = 0; axis < 2; ++axis) {
        sea::Answer truth, answer; // level, and a slope of 0.3
        answer.normal[2] = 1.0 / std::hypot(1.0, 0.3);
        answer.normal[axis] = -0.3 * answer.normal[2];
        const std::vector<Figure> all = of(truth, answer);
        EXPECT_NEAR(figure(all, "slope_rms"), 0.3, 1e-12) << axis;
        EXPECT_NEAR(figure(all, "normal_p99_deg"), std::atan(0.3) * 180.0 / 3.14159265358979, 1e-9);
    }
}

/// A sample whose height is off by this, below a bound that it states; the truth is good to `truth_m`.
Sample off_by(double error_m, double stated_m, PointKind kind = PointKind::anywhere, int time = 0,
              double truth_m = 0.0) {
    Sample sample{kind, time, {}, {}};
    sample.truth.height_m = 2.0;
    sample.truth.error_m = truth_m;
    sample.answer.height_m = 2.0 + error_m;
    sample.answer.error_m = stated_m;
    return sample;
}

// Ten answers state 0.1 m each. Whoever is off by more is beyond, upwards and downwards, on crests and
// elsewhere; what the truth itself is not sure of is not held against an answer.
TEST(AccuracyFigures, an_answer_is_beyond_its_bound_upwards_and_downwards) {
    std::vector<Sample> samples(7, off_by(0.05, 0.1));
    samples.push_back(off_by(-0.15, 0.1));
    samples.push_back(off_by(-0.15, 0.1, PointKind::anywhere, 0, 0.06));
    samples.push_back(off_by(0.05, 0.1));
    EXPECT_NEAR(figure(figures(samples, 1.0), "beyond_bound_pct"), 10.0, 1e-12) << "one downwards";
    samples.back() = off_by(0.15, 0.1, PointKind::crest);
    EXPECT_NEAR(figure(figures(samples, 1.0), "beyond_bound_pct"), 20.0, 1e-12) << "and one up";
    samples.back() = off_by(-0.15, 0.1, PointKind::crest, 0, 0.06);
    EXPECT_NEAR(figure(figures(samples, 1.0), "beyond_bound_pct"), 10.0, 1e-12);
}

// Flagged answers state no bound, and points where the truth folds are left out altogether: neither is
// beyond anything, and each has a share of its own.
TEST(AccuracyFigures, folded_points_and_flagged_answers_have_shares_of_their_own) {
    std::vector<Sample> samples(8, off_by(0.01, 0.1));
    samples.push_back(off_by(-0.15, 0.1));
    samples.push_back(off_by(5.0, 0.1));
    samples.back().answer.flags = sea::answer_folded;
    for (int i = 0; i < 10; ++i) {
        samples.push_back(off_by(-9.0, 0.1));
        samples.back().truth.flags = sea::answer_folded;
    }
    const std::vector<Figure> all = figures(samples, 1.0);
    EXPECT_NEAR(figure(all, "folded_pct"), 50.0, 1e-12) << "of all";
    EXPECT_NEAR(figure(all, "flagged_pct"), 10.0, 1e-12) << "of the others";
    EXPECT_NEAR(figure(all, "beyond_bound_pct"), 100.0 / 9, 1e-12) << "of those that state a bound";
    EXPECT_NEAR(figure(all, "max_m"), 5.0, 1e-12);
}

// The middle one of what is stated over what 99 of 100 keep, however they are off; who states no bound at
// all has neither figure.
TEST(AccuracyFigures, what_is_stated_is_compared_with_the_size_of_errors_whatever_their_sign) {
    std::vector<Sample> samples;
    for (int i = 1; i <= 201; ++i)
        samples.push_back(off_by(i % 2 ? -0.001 * i : 0.001 * i, 0.01 * i));
    const double p99_m = 0.2; // order statistic 199 of 201, counted from 0: 0.99 * 201 = 198.99
    EXPECT_NEAR(figure(figures(samples, 1.0), "p99_m"), p99_m, 0.0011);
    EXPECT_NEAR(figure(figures(samples, 1.0), "bound_over_p99"),
                1.01 / figure(figures(samples, 1.0), "p99_m"), 1e-9);
    samples.back().answer.error_m = 0.0;
    EXPECT_TRUE(std::isnan(figure(figures(samples, 1.0), "bound_over_p99")));
    EXPECT_TRUE(std::isnan(figure(figures(samples, 1.0), "beyond_bound_pct")));
}

// Averages have signs, sizes have none, and each is of the points that its name says.
TEST(AccuracyFigures, every_figure_is_of_its_own_points_in_metres_and_in_percent_of_hs) {
    const std::vector<Sample> samples = {
        off_by(0.3, 0.1), off_by(-0.1, 0.1), off_by(-0.5, 0.1, PointKind::crest),
        off_by(0.1, 0.1, PointKind::crest), off_by(-0.7, 0.1, PointKind::steep)};
    const std::vector<Figure> all = figures(samples, 4.0);
    EXPECT_NEAR(figure(all, "mean_m"), 0.1, 1e-12);
    EXPECT_NEAR(figure(all, "rms_m"), std::sqrt((0.09 + 0.01) / 2), 1e-12);
    EXPECT_NEAR(figure(all, "p99_m"), 0.3, 1e-12) << "the largest of few";
    EXPECT_NEAR(figure(all, "max_m"), 0.7, 1e-12) << "of all kinds";
    EXPECT_NEAR(figure(all, "crest_m"), -0.2, 1e-12) << "crests too low";
    EXPECT_NEAR(figure(all, "crest_rms_m"), std::sqrt((0.25 + 0.01) / 2), 1e-12);
    EXPECT_NEAR(figure(all, "steep_rms_m"), 0.7, 1e-12);
    for (const auto& [percent, metres] :
         {std::pair{"rms_pct_hs", "rms_m"}, std::pair{"p99_pct_hs", "p99_m"},
          std::pair{"max_pct_hs", "max_m"}, std::pair{"crest_pct_hs", "crest_m"}})
        EXPECT_NEAR(figure(all, percent), 25.0 * figure(all, metres), 1e-12) << percent;
}

// Points of one time belong together: where every time has the same errors a mean is sure, however many
// there are; where each time has an error of its own it is as unsure as so few numbers are.
TEST(AccuracyFigures, intervals_are_by_whole_times) {
    std::vector<Sample> alike, apart;
    for (int time = 0; time < 16; ++time)
        for (int i = 0; i < 50; ++i) {
            alike.push_back(off_by(i % 2 ? 0.1 : -0.1, 1.0, PointKind::anywhere, time));
            apart.push_back(off_by(time % 2 ? 0.1 : -0.1, 1.0, PointKind::anywhere, time));
        }
    const auto mean = [](const std::vector<Sample>& samples) {
        const std::vector<Figure> all = figures(samples, 1.0);
        return *std::find_if(all.begin(), all.end(),
                             [](const Figure& f) { return f.metric == "mean_m"; });
    };
    EXPECT_NEAR(mean(alike).low, 0.0, 1e-12);
    EXPECT_NEAR(mean(alike).high, 0.0, 1e-12);
    EXPECT_NEAR(mean(apart).value, 0.0, 1e-12);
    // Of 16 numbers +-0.1 the mean scatters by 0.1 / 4; 1.96 of it either way, drawn 200 times.
    EXPECT_NEAR(mean(apart).low, -0.049, 0.02);
    EXPECT_NEAR(mean(apart).high, 0.049, 0.02);
}

// Naive: 800 points, of which 8 lie above the 99th percentile, as if they were independent. Where one time in sixteen is bad
// at all of its points, so unsure is what 99 of 100 keep: it is drawn not at all in 36 % of all resamples.
TEST(AccuracyFigures, the_99th_percentile_is_as_unsure_as_its_times_are_few) {
    std::vector<Sample> one_bad, all_alike;
    for (int time = 0; time < 16; ++time)
        for (int i = 0; i < 50; ++i) {
            one_bad.push_back(off_by(time == 7 ? 0.5 : 0.001 * i, 1.0, PointKind::anywhere, time));
            all_alike.push_back(off_by(0.001 * i, 1.0, PointKind::anywhere, time));
        }
    const auto p99 = [](const std::vector<Sample>& samples) {
        const std::vector<Figure> all = figures(samples, 1.0);
        return *std::find_if(all.begin(), all.end(),
                             [](const Figure& f) { return f.metric == "p99_m"; });
    };
    EXPECT_EQ(p99(one_bad).value, 0.5);
    EXPECT_EQ(p99(one_bad).high, 0.5);
    EXPECT_NEAR(p99(one_bad).low, 0.049, 1e-12) << "of the times that are alike";
    for (const double same : {p99(all_alike).low, p99(all_alike).value, p99(all_alike).high})
        EXPECT_NEAR(same, 0.049, 1e-12) << "they tell the same, however often each is drawn";
}

// What Hermite misses at a share s of an interval goes as (s (1 - s))^2, so that the mean of its square over times is what an
// rms is made of: 1/630 over all of an interval. 15 % of it are 7 % of an rms. Naive: times within 2 s, which are some five
// quarters of an interval of 1.6 s: half of it.
TEST(SampleTimes, are_spread_evenly_over_each_interval_between_keyframes) {
    constexpr int times = 32;
    for (const sea::TimeUs interval_us : sea::keyframe_intervals_us) {
        double sum = 0;
        for (int i = 0; i < times; ++i) {
            const double s = static_cast<double>(sample_time_us(i) % interval_us) /
                             static_cast<double>(interval_us);
            sum += std::pow(s * (1 - s), 4);
        }
        EXPECT_NEAR(630 * sum / times, 1.0, 0.07) << interval_us; // 1/630 is the mean over all s
    }
}

// Second differences: a shift, or a drift that is even, is no flicker; what comes and goes from frame to
// frame by a is one of 4 a, and no point is told from the next one's frames.
TEST(AccuracyFigures, flicker_is_what_comes_and_goes_between_frames) {
    constexpr int frames = 5;
    const std::vector<double> truth = {1, 2, 4, 8, 16, -1, -2, -3, -4, -5};
    std::vector<double> answers = truth;
    for (std::size_t i = 0; i < answers.size(); ++i)
        answers[i] += i < frames ? 0.7 : 0.1 * static_cast<double>(i);
    EXPECT_NEAR(flicker_m(truth, answers, frames), 0.0, 1e-12);
    for (std::size_t i = 0; i < answers.size(); ++i)
        answers[i] = truth[i] + (i % 2 ? 0.1 : -0.1);
    EXPECT_NEAR(flicker_m(truth, answers, frames), 0.4, 1e-12);
}

/// A small sea, drawn anew for each seed, with a few points of it.
std::vector<DrawnSea> drawn(const Configuration& configuration, int seeds) {
    std::vector<DrawnSea> seas;
    for (int i = 0; i < seeds; ++i) {
        const std::uint64_t seed = 5 + static_cast<std::uint64_t>(i);
        const auto scene = sea_state("calm_shallow", seed);
        const auto waves = configured_waves(*scene, configuration);
        seas.push_back({*waves, summed_truth(*waves, {32, 8, false, i, seeds}, seed)});
    }
    return seas;
}

Configuration small_tile() {
    Configuration configuration = clean(*sea_state("calm_shallow", 5));
    configuration.cascades = {{200.0, 64}};
    configuration.height_error_m = 0.05;
    configuration.interval_us.reset();
    return configuration;
}

TEST(AccuracyFigures, figures_of_several_seeds_are_of_all_their_points_and_the_worst_is_named) {
    const Configuration configuration = small_tile();
    std::vector<DrawnSea> seas = drawn(configuration, 3);
    Devices devices;
    StageCosts costs(1);
    for (int first = 0; first < 3; ++first) { // the worst comes first, last and between
        const auto all = measure(seas, configuration, {}, devices, costs);
        ASSERT_TRUE(all) << all.error().message;
        double squares = 0, samples = 0, worst = 0, hs_before = 0;
        for (int i = 0; i < 3; ++i) {
            const std::string seed = std::to_string(5 + i);
            const double points = 16.0 * (i < 2 ? 3 : 2); // anywhere; of 8 times, shared by three
            squares += points * std::pow(figure(*all, "rms_m@seed=" + seed), 2);
            samples += points;
            worst = std::max(worst, figure(*all, "p99_m@seed=" + seed));
            EXPECT_NE(figure(*all, "hs_m@seed=" + seed), hs_before); // another sea
            hs_before = figure(*all, "hs_m@seed=" + seed);
        }
        EXPECT_NEAR(figure(*all, "rms_m"), std::sqrt(squares / samples), 1e-12);
        EXPECT_EQ(figure(*all, "p99_worst_m"), worst);
        EXPECT_EQ(figure(*all, "samples"), 32.0 * 8);
        EXPECT_GT(figure(*all, "rms_m"), 0.0);
        std::rotate(seas.begin(), seas.begin() + 1, seas.end());
    }
}

TEST(AccuracyFigures, seeds_that_share_times_take_each_time_once) {
    std::vector<int> times;
    for (int i = 0; i < 3; ++i) {
        const Configuration configuration = small_tile();
        const auto waves = configured_waves(*sea_state("calm_shallow", 5), configuration);
        for (const SamplePoint& point : sample_points(waves->all, {4, 8, false, i, 3}, 5))
            times.push_back(point.time);
    }
    std::sort(times.begin(), times.end());
    ASSERT_EQ(times.size(), 4u * 8);
    for (std::size_t i = 0; i < times.size(); ++i)
        EXPECT_EQ(times[i], static_cast<int>(i / 4));
}

/// A wave and the one that runs against it, as they are and as Hermite's weights have them between keyframes 1 s apart.
struct TrueAndShown {
    double truth = 0, shown = 0;
};
TrueAndShown energy(const sea::CascadeModes& modes, std::size_t index, double omega,
                    sea::TimeUs start_us, double share) {
    using Complex = std::complex<double>;
    constexpr sea::TimeUs second = 1'000'000;
    const auto size = static_cast<std::size_t>(modes.spec.size);
    const std::size_t opposite = (size - index / size) % size * size + (size - index % size) % size;
    const auto at = [&](sea::TimeUs time_us) {
        const Complex turn = std::polar(1.0, -sea::phase_rad(modes.rate[index], time_us));
        const Complex there = modes.h0[index] * turn, back = std::conj(modes.h0[opposite] * turn);
        return std::pair(there + back, Complex(0, omega) * (back - there)); // and its rate
    };
    const sea::TimeUs now_us = start_us + sea::us_from_seconds(share);
    const auto [before, rate_before] = at(start_us);
    const auto [after, rate_after] = at(start_us + second);
    const auto [v, rates] = time_weights(TimeRule::hermite, start_us, start_us + second, now_us);
    return {std::norm(at(now_us).first),
            std::norm(v[0] * before + v[1] * rate_before + v[2] * after + v[3] * rate_after)};
}

// Naive: energy at one moment, which may be a keyframe, where nothing is missed in time. Over an interval a wave is shown with
// what Hermite's weights leave of it, and with least of it half way.
TEST(Octaves, energy_is_of_the_whole_interval_and_at_worst_that_of_its_middle) {
    Configuration configuration = small_tile();
    configuration.interval_us = 1'000'000;
    configuration.oversampling = 4; // so that a spline loses nothing
    Devices devices;
    const auto sea = ConfiguredSea::create(*sea_state("calm_shallow", 5), configuration, devices);
    ASSERT_TRUE(sea) << sea.error().message;
    const sea::TimeUs start_us = sample_time_us(1) - sample_time_us(1) % 1'000'000;
    std::map<double, std::pair<TrueAndShown, TrueAndShown>>
        expected; // by octave: of all, of the middle
    const sea::CascadeModes& modes = (*sea)->waves().used->cascades[0];
    const auto add = [](TrueAndShown& to, const TrueAndShown& more) {
        to.truth += more.truth;
        to.shown += more.shown;
    };
    for_each_wave(modes, [&](std::size_t i, double kx, double ky, double, double omega) {
        auto& [all, middle] = expected[std::exp2(std::floor(std::log2(std::hypot(kx, ky))))];
        for (int n = 0; n < 100; ++n)
            add(all, energy(modes, i, omega, start_us, (n + 0.5) / 100));
        add(middle, energy(modes, i, omega, start_us, 0.5));
    });
    const auto measured = octaves(**sea, start_us);
    ASSERT_TRUE(measured) << measured.error().message;
    int seen = 0;
    for (const Octave& octave : *measured) {
        const auto& [all, middle] = expected.at(octave.k_radpm);
        const double all_pct = 100 * (all.shown / all.truth - 1);
        const double middle_pct = 100 * (middle.shown / middle.truth - 1);
        if (all_pct > -1)
            continue;
        ++seen;
        // A few moments instead of a hundred, and single precision.
        EXPECT_NEAR(octave.energy_error_pct, all_pct, -0.01 * all_pct) << octave.k_radpm;
        EXPECT_NEAR(octave.energy_error_worst_pct, middle_pct, -0.01 * middle_pct)
            << octave.k_radpm;
        EXPECT_LT(octave.energy_error_worst_pct, 1.4 * octave.energy_error_pct) << octave.k_radpm;
    }
    EXPECT_GE(seen, 2);
}

// K12 has no error of its own: whoever asks for many at once, in however many threads, gets the bits of
// who asks for one.
TEST(AccuracyFigures, an_answer_has_the_same_height_alone_and_in_a_batch_of_any_size) {
    const auto scene = sea_state("calm_shallow", 5);
    Devices devices;
    for (const Evaluator evaluator : {Evaluator::maps, Evaluator::direct_sum})
        for (const Asked asked : {Asked::one_thread, Asked::all_threads})
            for (const int points : {1, 7, 64}) {
                Configuration configuration = small_tile();
                configuration.evaluator = evaluator;
                const auto all = measure_batch(*scene, configuration, {points, asked}, "", devices);
                ASSERT_TRUE(all) << all.error().message;
                EXPECT_EQ(figure(*all, "batch_difference_m"), 0.0) << points;
                EXPECT_GT(figure(*all, "batch_ns"), 0.0) << points;
                EXPECT_NEAR(figure(*all, "batch_ms"), 1e-6 * points * figure(*all, "batch_ns"),
                            1e-9 * figure(*all, "batch_ms"));
            }
}

} // namespace
} // namespace seaway::bench
