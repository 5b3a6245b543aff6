// SPDX-License-Identifier: Apache-2.0
// The tuner on small spaces, with prices that are a formula, so that they are the same every time; what
// it finds is measured again, and against everything that it did not take.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

#include <fmt/format.h>

#include "tests/support/program.h"
#include "tools/bench/accuracy/measure/laws.h"
#include "tools/bench/accuracy/seas/sea_states.h"
#include "tools/bench/tune/total_error.h"
#include "tools/bench/tune/tuner.h"

namespace seaway::bench {
namespace {

/// Points by keyframes a second, bytes, and tiles that an answer looks at.
class FormulaPrices final : public Prices {
  public:
    Result<Price> at_least(const std::vector<sea::CascadeSpec>& cascades, const sea::Scene&,
                           const sea::ErrorBudget* budget) override {
        Price price;
        for (std::size_t c = 0; c < cascades.size(); ++c) {
            // Keyframes are 2 s apart at most.
            const double a_second =
                budget ? 1.0 / sea::seconds_from_us(budget->cascades[c].interval_us) : 0.5;
            price.keyframes_ms += a_second * keyframe_ms(cascades[c].size);
        }
        price.answers_ms = 3.0 * static_cast<double>(cascades.size());
        return price;
    }
    Result<Price> of(const ConfiguredSea& sea) override {
        Price price;
        for (std::size_t c = 0; c < sea.waves().used->cascades.size(); ++c) {
            const double a_second =
                1.0 / sea::seconds_from_us(sea.waves().budget.cascades[c].interval_us);
            price.keyframes_ms += a_second * keyframe_ms(sea.waves().used->cascades[c].spec.size);
            const CodingCost coding = sea.coding(c);
            price.bytes_per_s += a_second * static_cast<double>(coding.bytes) /
                                 static_cast<double>(std::max<std::uint64_t>(coding.keyframes, 1));
            price.answers_ms += 3.0;
        }
        price.encoding_ms = 1e-5 * price.bytes_per_s;
        return price;
    }

  private:
    static double keyframe_ms(int size) { return 1e-4 * size * size; }
};

sea::Scene scene_of(const char* state) {
    const Result<sea::Scene> scene = sea_state(state, 5);
    EXPECT_TRUE(scene) << scene.error().message;
    return *scene;
}

class Tune : public ::testing::Test {
  protected:
    Tune() {
        options.folder = tests::folder().file("tune"); // a truth is summed once for all of them
        options.sampling = {64, 8, false};
        space.sizes = {64, 128};
        space.k_ends_radpm = {0.7, 1.4, 2.8, 4.0, 5.6};
        space.more_tiles = {0, 1};
        space.finest_divisors = {1};
        space.height_errors_m = {0.01, 0.03, 0.1, 0.3};
    }

    Outcome tuned(const sea::Scene& scene, const Target& target) {
        const Result<Outcome> outcome = tune(scene, target, space, options, prices, devices);
        EXPECT_TRUE(outcome) << outcome.error().message;
        return outcome ? *outcome : Outcome{};
    }
    /// The same, in the space as it is above: several tests look at what one search has found.
    const Outcome& found(const char* state, double height_error_m) {
        static std::map<std::pair<std::string, double>, Outcome> all;
        const std::pair<std::string, double> key(state, height_error_m);
        if (!all.contains(key))
            all[key] = tuned(scene_of(state), {.height_error_m = height_error_m});
        return all.at(key);
    }
    double total_m(const sea::Scene& scene, const Candidate& candidate, std::uint64_t seed) {
        sea::Scene one = with_candidate(scene, candidate);
        one.sea.seed = seed;
        const auto error = measure_error(one, "fresh", 99, options, devices);
        EXPECT_TRUE(error) << error.error().message;
        return error ? error->total_m : 1e9;
    }
    /// Of what is known to cost `enough_ms` or more before anything is computed or coded only that it does.
    double price_ms(const sea::Scene& scene, const Candidate& candidate,
                    double enough_ms = std::numeric_limits<double>::infinity()) {
        const Configuration configuration =
            configuration_of(with_candidate(scene, candidate), "native");
        const Result<Waves> waves = configured_waves(scene, configuration);
        EXPECT_TRUE(waves);
        const double least_ms =
            prices.at_least(configuration.cascades, scene, &waves->budget)->work_ms();
        if (least_ms >= enough_ms)
            return least_ms;
        const auto sea = ConfiguredSea::create(*waves, configuration, devices);
        EXPECT_TRUE(sea);
        EXPECT_TRUE((*sea)->go_to(sample_time_us(1)));
        const double ms = prices.of(**sea)->work_ms();
        EXPECT_GE(ms, least_ms * (1.0 - 1e-12)) << "or nothing would be known before";
        return ms;
    }

    TuneOptions options;
    TuneSpace space;
    FormulaPrices prices;
    Devices devices;
};

TEST(TotalError, of_no_errors_is_that_of_a_normal_distribution) {
    // 1.959964 and 2.575829 standard deviations hold 95 % and 99 %.
    EXPECT_NEAR(normal_percentile(95), 1.959964, 1e-6);
    EXPECT_NEAR(percentile_with_normal({}, 2.0, 99), 2.0 * 2.575829, 1e-5);
    const std::vector<double> zeros(10, 0.0);
    EXPECT_NEAR(percentile_with_normal(zeros, 2.0, 99), 2.0 * 2.575829, 1e-5);
}

TEST(TotalError, of_nothing_left_out_is_the_order_statistic) {
    std::vector<double> errors;
    for (int i = 1; i <= 1000; ++i)
        errors.push_back(i % 2 == 0 ? 1e-3 * i : -1e-3 * i);
    EXPECT_NEAR(percentile_with_normal(errors, 0.0, 99), 0.99, 2e-3);
    EXPECT_NEAR(percentile_with_normal(errors, 1e-12, 99), 0.99, 2e-3);
}

TEST(TotalError, of_what_is_no_number_is_infinite) {
    for (const double nothing : {std::nan(""), HUGE_VAL}) {
        const std::vector<double> errors{0.01, nothing, 0.02};
        for (const double sigma : {0.005, 0.0})
            EXPECT_EQ(percentile_with_normal(errors, sigma, 99), HUGE_VAL);
        EXPECT_EQ(percentile_with_normal(std::vector{0.01}, nothing, 99), HUGE_VAL);
    }
}

TEST(TotalError, adds_independent_parts_in_the_square) {
    std::mt19937_64 engine(1);
    std::normal_distribution<double> normal(0.0, 3.0);
    std::vector<double> errors(20'000);
    for (double& e : errors)
        e = normal(engine);
    // 3 and 4 make 5; the 99th percentile of 20 000 draws scatters by 1 %.
    EXPECT_NEAR(percentile_with_normal(errors, 4.0, 99), 5.0 * 2.575829, 0.02 * 5.0 * 2.576);
}

TEST_F(Tune, layouts_leave_no_gap_and_none_comes_twice) {
    const std::vector<Layout> all = layouts(whole_space(), 2111.0);
    EXPECT_GT(all.size(), 300u);
    for (std::size_t i = 0; i < all.size(); ++i) {
        EXPECT_EQ(all[i].cascades.front().length_m, 2111.0);
        const auto bands = sea::assign_bands(all[i].cascades);
        ASSERT_TRUE(bands) << bands.error().message;
        EXPECT_EQ(bands->back().k_hi_radpm, all[i].k_end_radpm);
        for (std::size_t j = 0; j < i; ++j)
            EXPECT_FALSE(std::equal(all[i].cascades.begin(), all[i].cascades.end(),
                                    all[j].cascades.begin(), all[j].cascades.end(),
                                    [](const sea::CascadeSpec& a, const sea::CascadeSpec& b) {
                                        return a.length_m == b.length_m && a.size == b.size;
                                    }));
    }
}

// By hand through the whole of the small space: nothing that costs 15 % less keeps the target. What costs
// more is not measured.
TEST_F(Tune, finds_a_configuration_within_15_percent_of_the_cheapest_there_is) {
    const sea::Scene scene = scene_of("gale_shallow");
    const Target target{.height_error_m = 0.06};
    const Outcome& outcome = found("gale_shallow", target.height_error_m);
    ASSERT_TRUE(outcome.reached);
    const double found_ms = outcome.best.price.work_ms();
    EXPECT_NEAR(found_ms, price_ms(scene, outcome.best), 1e-9 * found_ms);
    int looked_at = 0, cheaper = 0;
    for (const Layout& layout : layouts(space, scene.cascades.front().length_m))
        for (const double height_error_m : space.height_errors_m) {
            const Candidate candidate{layout, height_error_m, {}, 0, 0};
            ++looked_at;
            if (price_ms(scene, candidate, found_ms / 1.15) >= found_ms / 1.15)
                continue;
            ++cheaper;
            EXPECT_GT(margin * total_m(scene, candidate, scene.sea.seed), target.height_error_m)
                << layout.cascades.size() << " tiles of " << layout.cascades[0].size << " to "
                << layout.k_end_radpm << " with " << height_error_m;
        }
    EXPECT_GT(looked_at, 50);
    EXPECT_GT(cheaper, 3);
}

TEST_F(Tune, a_looser_target_never_costs_more) {
    double dearer_ms = 1e9;
    for (const double height_error_m : {0.045, 0.06, 0.1, 0.2, 0.4}) {
        const Outcome& outcome = found("gale_shallow", height_error_m);
        ASSERT_TRUE(outcome.reached) << height_error_m;
        EXPECT_LE(outcome.best.price.work_ms(), dearer_ms) << height_error_m;
        dearer_ms = outcome.best.price.work_ms();
    }
}

// A price is of what our clients take. 5 %: `line` looks at other keyframes of the same sea.
TEST_F(Tune, the_stream_that_is_priced_is_the_one_that_line_counts_for_a_client_of_ours) {
    const std::string path = SEAWAY_SOURCE_DIR "/scenes/north_sea_gale.toml";
    const Result<sea::Scene> scene = sea::read_scene(path);
    ASSERT_TRUE(scene) << scene.error().message;
    const std::string folder = tests::folder().fresh("prices");
    std::filesystem::create_directories(folder);
    const auto stages = stage_prices("native", folder + "/prices.json", devices);
    ASSERT_TRUE(stages) << stages.error().message;
    const auto sea = ConfiguredSea::create(*scene, configuration_of(*scene, "native"), devices);
    ASSERT_TRUE(sea) << sea.error().message;
    ASSERT_TRUE((*sea)->go_to(sample_time_us(1)));
    const auto price = (*stages)->of(**sea);
    ASSERT_TRUE(price) << price.error().message;
    const tests::Output line =
        tests::run_program("seaway-bench", "line --keyframes 4 --scene " + path);
    ASSERT_EQ(line.status, 0) << line.err;
    const std::size_t unit = line.out.find(" Mbit/s, one whole");
    ASSERT_NE(unit, std::string::npos) << line.out;
    const double mbit_per_s = std::stod(line.out.substr(line.out.rfind('\n', unit) + 1));
    EXPECT_NEAR(8e-6 * price->bytes_per_s / mbit_per_s, 1.0, 0.05);
    EXPECT_GT(price->encoding_ms, 0.0);
}

// The whole of it, ten seeds in six sea states, is in docs/accuracy.md; here one calm and one steep sea.
TEST_F(Tune, fresh_seeds_are_never_further_off_than_the_target) {
    for (const char* state : {"calm_deep", "gale_shallow"}) {
        const sea::Scene scene = scene_of(state);
        const Outcome& outcome = found(state, 0.06);
        ASSERT_TRUE(outcome.reached) << state;
        for (const sea::MeasuredError& measured : outcome.measured)
            EXPECT_LE(margin * measured.total_m, 0.06) << measured.sea;
        for (const std::uint64_t seed : {111u, 222u})
            EXPECT_LE(total_m(scene, outcome.best, seed), 0.06) << state << ' ' << seed;
    }
}

TEST_F(Tune, what_is_measured_covers_a_rougher_and_a_calmer_sea_and_fresh_seeds) {
    const Outcome& outcome = found("calm_deep", 0.06);
    ASSERT_TRUE(outcome.reached);
    ASSERT_EQ(outcome.measured.size(), 5u);
    EXPECT_EQ(outcome.measured[0].seed, 5u);
    EXPECT_NE(outcome.measured[1].seed, outcome.measured[2].seed);
    EXPECT_EQ(outcome.measured[3].sea, "rougher");
    EXPECT_EQ(outcome.measured[4].sea, "calmer");
    EXPECT_GT(outcome.measured[3].hs_m, outcome.measured[4].hs_m);
}

// The law of what is left out against the sum of waves four times shorter: two ways to one figure. Of 256
// places a percentile scatters by a tenth.
TEST_F(Tune, waves_left_out_are_what_a_finer_tile_adds) {
    sea::Scene scene = scene_of("gale_shallow");
    scene.cascades = {{2111.0, 128}, {500.0, 128}, {120.0, 128}};
    scene.accuracy.height_error_m = 0.02;
    options.sampling = {128, 8, false};
    const auto by_law = measure_error(scene, "as given", 99, options, devices);
    const auto by_sum = measure_beside_finer(scene, 99, options, devices);
    ASSERT_TRUE(by_law && by_sum);
    EXPECT_GT(by_law->waves_left_out_m, 3.0 * by_law->rms_m); // or the law is not what is tried
    EXPECT_NEAR(*by_sum, by_law->total_m, 0.15 * by_law->total_m);
}

TEST_F(Tune, an_unreachable_target_is_answered_with_the_best_there_is) {
    const sea::Scene scene = scene_of("gale_shallow");
    const Outcome outcome = tuned(scene, {.height_error_m = 0.001});
    EXPECT_FALSE(outcome.reached);
    ASSERT_EQ(outcome.measured.size(), 1u);
    EXPECT_GT(outcome.measured[0].total_m, 0.001);
    // Waves down to 1.1 m: 0.045 m / 5.6 of what is shorter, in shallow water as in deep.
    EXPECT_NEAR(outcome.best.layout.k_end_radpm, 5.6, 0.01);
    EXPECT_GT(outcome.limits.waves_left_out_m, outcome.limits.maps_m);
    EXPECT_FALSE(outcome.without_limits);
}

// Slopes have their law: where it forbids a target no layout is measured but the best there is.
TEST_F(Tune, slopes_that_no_layout_has_are_known_before_anything_is_measured) {
    const Outcome outcome =
        tuned(scene_of("gale_shallow"), {.height_error_m = 0.1, .slope_error = 1e-5});
    EXPECT_FALSE(outcome.reached);
    EXPECT_EQ(outcome.tried, 0);
    EXPECT_EQ(outcome.priced, 1);
    ASSERT_EQ(outcome.measured.size(), 1u);
    EXPECT_LT(margin * outcome.measured[0].total_m, 0.1); // heights are not in the way
    EXPECT_EQ(outcome.best.height_error_m, space.height_errors_m.front());
    // 32 points anywhere: a factor of 2 is far beyond the scatter, and far below what was asked for.
    EXPECT_GT(outcome.measured[0].slope_rms, 0.5 * outcome.best.expected_slope);
    EXPECT_LT(outcome.measured[0].slope_rms, 2.0 * outcome.best.expected_slope);
}

TEST_F(Tune, slopes_cost_more_the_finer_they_are_asked_for_and_are_kept) {
    const sea::Scene scene = scene_of("gale_shallow");
    double cheaper_ms = 0;
    space.height_errors_m = {0.003, 0.01, 0.03, 0.1, 0.3};
    for (const double slope : {0.05, 0.02, 0.008}) {
        const Outcome outcome = tuned(scene, {.height_error_m = 0.1, .slope_error = slope});
        ASSERT_TRUE(outcome.reached) << slope;
        for (const sea::MeasuredError& measured : outcome.measured)
            EXPECT_LE(margin * measured.slope_rms, slope) << measured.sea;
        EXPECT_GE(outcome.best.price.work_ms(), cheaper_ms) << slope;
        cheaper_ms = outcome.best.price.work_ms();
    }
}

TEST_F(Tune, a_limit_that_is_too_low_is_answered_with_what_it_would_take) {
    const sea::Scene scene = scene_of("gale_shallow");
    const Outcome& free = found("gale_shallow", 0.06);
    ASSERT_TRUE(free.reached);
    Target limited{.height_error_m = 0.06};
    limited.budget_ms = 0.8 * free.best.price.work_ms();
    const Outcome outcome = tuned(scene, limited);
    EXPECT_FALSE(outcome.reached);
    EXPECT_LE(outcome.best.price.work_ms(), *limited.budget_ms);
    ASSERT_EQ(outcome.measured.size(), 1u);
    ASSERT_TRUE(outcome.without_limits);
    EXPECT_EQ(outcome.without_limits->price.work_ms(), free.best.price.work_ms());
    Target narrow{.height_error_m = 0.06};
    narrow.bytes_per_s = 0.5 * free.best.price.bytes_per_s;
    const Outcome thin = tuned(scene, narrow);
    EXPECT_LE(thin.best.price.bytes_per_s, *narrow.bytes_per_s);
}

TEST_F(Tune, a_scene_that_streams_nothing_pays_for_no_stream) {
    sea::Scene scene = scene_of("calm_deep");
    scene.accuracy.preset = sea::AccuracyPreset::query_only;
    const Outcome outcome = tuned(scene, {.height_error_m = 0.06});
    ASSERT_TRUE(outcome.reached);
    EXPECT_EQ(outcome.best.price.bytes_per_s, 0.0);
}

// A preset's budget is a bound, six standard deviations wide: the 99th percentile lies well within.
TEST_F(Tune, presets_keep_their_budget_in_a_gale) {
    sea::Scene scene = scene_of("gale_deep");
    for (const sea::AccuracyPreset preset : sea::accuracy_presets()) {
        const sea::PresetAccuracy accuracy = accuracy_of(preset);
        scene.accuracy.preset = preset;
        scene.accuracy.height_error_m = accuracy.height_error_m;
        scene.cascades = accuracy.cascades;
        const auto waves = configured_waves(scene, configuration_of(scene, "native"));
        ASSERT_TRUE(waves);
        const double rms_m = predict(*waves, configuration_of(scene, "native"), 0).rms_m();
        EXPECT_LT(normal_percentile(99) * rms_m, accuracy.height_error_m) << name_of(preset);
    }
    options.sampling = {32, 8, false};
    scene.cascades = accuracy_of(sea::AccuracyPreset::fast).cascades;
    const auto fast = measure_error(scene, "as given", 99, options, devices);
    ASSERT_TRUE(fast);
    EXPECT_LT(fast->p99_m, accuracy_of(sea::AccuracyPreset::fast).height_error_m);
}

} // namespace
} // namespace seaway::bench
