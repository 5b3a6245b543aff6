// SPDX-License-Identifier: Apache-2.0
#include "sea/foam/foam.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include <gtest/gtest.h>

#include "sea/surface/inverse.h"
#include "tests/sea/foam/foam_seas.h"
#include "tests/support/draw.h"

namespace seaway::sea {
namespace {

double mean_of(std::span<const float> values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// Mean of the clamped coverage of one cascade's history alone.
double mean_coverage(const FoamLaw& law, const FoamHistory& history) {
    double sum = 0;
    for (const float ratio : history.ratios())
        sum += foam_coverage(law.mean_coverage, {&ratio, 1});
    return sum / static_cast<double>(history.ratios().size());
}

// ---- hard cases ------------------------------------------------------------------------------

TEST(Foam, E1_mean_coverage_is_the_same_at_15_30_60_144_and_1000_hz) {
    // Naive: foam *= 0.98 a frame, a sea that clears sooner on a faster machine.
    const sea::RealizationPtr sea = storm();
    const FoamLawPtr law = make_foam_law(*sea, foam_model);
    Strains strains(sea, 0);
    double reference = 0;
    for (const int rate_hz : {60, 15, 30, 144, 1000}) {
        FoamHistory history(law, 0, 64, interval_us);
        TimeUs before_us = 0;
        for (int tick = 1; tick <= 20 * rate_hz; ++tick) {
            const TimeUs time_us = TimeUs{tick} * 1'000'000 / rate_hz;
            history.advance(*strains.at(time_us), sea::seconds_from_us(time_us - before_us));
            before_us = time_us;
        }
        const double mean = mean_coverage(*law, history);
        if (rate_hz == 60)
            reference = mean;
        ASSERT_GT(mean, 0.01);
        EXPECT_NEAR(mean, reference, 0.02 * reference) << rate_hz << " Hz";
    }
}

TEST(Foam, E2_an_hour_of_storm_stays_between_0_and_1_and_finite) {
    // Naive: an unbounded sum that reaches infinity in half precision after minutes.
    const sea::RealizationPtr sea = storm(0.05);
    const FoamLawPtr law = make_foam_law(*sea, {0.9, 4.0, 50.0});
    Strains strains(sea, 0);
    FoamHistory history(law, 0, 64, interval_us);
    double largest = 0;
    for (int second = 1; second <= 3600; ++second) {
        history.advance(*strains.at(second * TimeUs{1'000'000}), 1.0);
        for (const float ratio : history.ratios()) {
            ASSERT_TRUE(std::isfinite(ratio) && ratio >= 0) << second;
            const double coverage = foam_coverage(law->mean_coverage, {&ratio, 1});
            ASSERT_TRUE(coverage >= 0 && coverage <= 1);
            largest = std::max(largest, coverage);
        }
    }
    EXPECT_EQ(largest, 1.0); // it was a storm
}

// Naive: what was shown between two ticks stays for ever.
TEST(Foam, a_step_is_shown_that_follows_a_time_between_ticks) {
    Strains strains(storm(), 0);
    FoamHistory history(make_foam_law(*storm(), foam_model), 0, 64, interval_us);
    ASSERT_TRUE(history.advance_to(1'270'000, strains.source()));
    EXPECT_GT(*std::max_element(history.ratios().begin(), history.ratios().end()), 1.0f);
    history.advance(uniform_strains(64, 0.6f), 1e4); // nothing breaks, all is forgotten
    for (const float ratio : history.ratios())
        ASSERT_LT(ratio, 0.01f);
}

TEST(Foam, E4_a_calm_sea_clears_to_exactly_zero_in_ten_decays) {
    // Naive: decays to 1e-40, denormal and never zero.
    const FoamLawPtr rough = make_foam_law(*storm(), foam_model);
    const FoamLawPtr calm =
        make_foam_law(*tests::make_sea({tests::calm_cascade(100.0, 64)}), foam_model);
    EXPECT_TRUE(calm->calm());
    EXPECT_FALSE(rough->calm());
    FoamHistory history(rough, 0, 64, interval_us);
    constexpr TimeUs calms_us = 60'000'000;
    history.follow([&](TimeUs t_us) { return t_us < calms_us ? rough : calm; });
    Strains strains(storm(), 0);
    ASSERT_TRUE(history.advance_to(calms_us - 200'000, strains.source()));
    const auto largest = [&] {
        return *std::max_element(history.ratios().begin(), history.ratios().end());
    };
    EXPECT_GT(foam_coverage(rough->mean_coverage, {history.ratios().data(), 1}), 0.0);
    EXPECT_GT(largest(), 2.0f);
    const int asked = strains.asked;
    ASSERT_TRUE(history.advance_to(calms_us + static_cast<TimeUs>(10e6 * foam_model.decay_s),
                                   strains.source()));
    EXPECT_EQ(strains.asked, asked) << "strains of a calm sea are not even looked at";
    EXPECT_NEAR(largest(), 1.0f, 2e-3f) << "and its map is the average: e^-10 of some 20";
    for (const float& ratio : history.ratios())
        EXPECT_EQ(foam_coverage(calm->mean_coverage, {&ratio, 1}), 0.0);
}

TEST(Foam, E4_what_no_longer_breaks_becomes_zero_and_not_denormal) {
    const sea::RealizationPtr one = tests::make_sea({storm()->cascades[0]}); // no others
    FoamHistory history(make_foam_law(*one, foam_model), 0, 2, interval_us);
    for (int tick = 0; tick < 200; ++tick)
        history.advance(uniform_strains(2, 0.5f), 0.5);
    for (const float ratio : history.ratios())
        EXPECT_EQ(ratio, 0.0f);
}

TEST(Foam, E5_a_pause_of_a_day_gives_the_history_that_was_never_interrupted) {
    // Naive: one huge injection, or a clamped dt and a wrong history.
    const sea::RealizationPtr sea = storm();
    const FoamLawPtr law = make_foam_law(*sea, foam_model);
    const TimeUs later_us = TimeUs{86'400} * 1'000'000;
    Strains strains(sea, 0);
    FoamHistory paused(law, 0, 64, interval_us);
    ASSERT_TRUE(paused.advance_to(10'000'000, strains.source()));
    strains.asked = 0;
    ASSERT_TRUE(paused.advance_to(later_us, strains.source()));
    EXPECT_LE(strains.asked, foam_ticks_max);

    FoamHistory steady(law, 0, 64, interval_us);
    TimeUs before_us = later_us - 60'000'000;
    for (TimeUs t = before_us; t <= later_us; before_us = t, t += 1'000'000 / 60)
        steady.advance(*strains.at(t), sea::seconds_from_us(t - before_us));
    EXPECT_NEAR(mean_coverage(*law, paused), mean_coverage(*law, steady),
                0.05 * mean_coverage(*law, steady));
    for (std::size_t i = 0; i < paused.ratios().size(); ++i)
        ASSERT_LE(foam_coverage(law->mean_coverage, paused.ratios().subspan(i, 1)), 1.0);
}

TEST(Foam, E6_breaking_is_that_of_summed_strains_not_of_each_cascade) {
    // Naive: J per cascade, maximum or product; two cascades that fold only together are missed.
    const sea::RealizationPtr sea = storm();
    StrainMoments total;
    for (const sea::CascadeModes& modes : sea->cascades)
        total += strain_moments(modes, sea->choppiness);
    // Joint Jacobian at random places and times, by direct sum.
    const sea::DirectSum truth(sea);
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> place(-1e5, 1e5);
    double breaking = 0, shortfall = 0, squares = 0;
    const int times = 60, places = 100;
    for (int t = 0; t < times; ++t) {
        const sea::DirectSum::Moment moment = truth.at_time(t * TimeUs{37'000'000});
        for (int i = 0; i < places; ++i) {
            const sea::LagrangianPoint p = moment.at(place(random), place(random));
            const double j = sea::jacobian(p, sea->choppiness);
            const double x = std::max(0.0, 0.75 - j);
            breaking += x > 0;
            shortfall += x;
            squares += x * x;
        }
    }
    const double n = times * places;
    const double share = breaking_share(0.75, total);
    EXPECT_NEAR(breaking / n, share, 3 * std::sqrt(share * (1 - share) / n));
    const double mean = shortfall / n;
    EXPECT_NEAR(mean_shortfall(0.75, total), mean, 3 * std::sqrt((squares / n - mean * mean) / n));
    // What each cascade alone would show is far less.
    EXPECT_LT(mean_shortfall(0.75, strain_moments(sea->cascades[0], sea->choppiness)), 0.5 * mean);
}

TEST(Foam, E7_columns_at_the_seam_of_a_tile_are_like_those_inside) {
    // Naive: grid lines where the tile repeats. A shift of the waves by half a tile must shift the
    // foam and nothing else.
    const sea::RealizationPtr sea = storm();
    sea::CascadeModes shifted = sea->cascades[0];
    for (int iy = 0; iy < 64; ++iy)
        for (int ix = 0; ix < 64; ++ix)
            if ((sea::signed_index(ix, 64) & 1) != 0) // exp(i pi nx)
                shifted.h0[static_cast<std::size_t>(iy * 64 + ix)] *= -1.0;
    const sea::RealizationPtr moved = tests::make_sea({shifted, sea->cascades[1]});
    Strains strains(sea, 0), strains_moved(moved, 0);
    FoamHistory history(make_foam_law(*sea, foam_model), 0, 64, interval_us);
    FoamHistory history_moved(make_foam_law(*moved, foam_model), 0, 64, interval_us);
    ASSERT_TRUE(history.advance_to(30'000'000, strains.source()));
    ASSERT_TRUE(history_moved.advance_to(30'000'000, strains_moved.source()));
    for (std::size_t y = 0; y < 64; ++y)
        for (std::size_t x = 0; x < 64; ++x) // single-precision strains, steep response
            ASSERT_NEAR(history.ratios()[y * 64 + x],
                        history_moved.ratios()[y * 64 + (x + 32) % 64], 2e-3f);
}

// ---- the history -----------------------------------------------------------------------------

TEST(Foam, the_ratio_is_one_on_average) {
    // 24 independent moments of a tile with some dozens of crests each.
    const sea::RealizationPtr sea = storm();
    const FoamLawPtr law = make_foam_law(*sea, foam_model);
    for (int c = 0; c < 2; ++c) {
        Strains strains(sea, c);
        double sum = 0, squares = 0;
        const int moments = 24;
        for (int i = 1; i <= moments; ++i) {
            FoamHistory history(law, c, 64, interval_us);
            ASSERT_TRUE(history.advance_to(i * TimeUs{100'000'000}, strains.source()));
            const double mean = mean_of(history.ratios());
            sum += mean;
            squares += mean * mean;
        }
        const double mean = sum / moments;
        const double standard_error = std::sqrt((squares / moments - mean * mean) / (moments - 1));
        EXPECT_NEAR(mean, 1.0, 3 * standard_error + 0.02) << "cascade " << c;
    }
}

/// Two cascades over the same points: a history each, and one of the Jacobian of both together.
struct JointFoam {
    FoamLawPtr law;
    std::vector<double> exact; ///< coverage; brute force, in double precision
    std::vector<FoamHistory> histories;
};

/// 24 s over 500 m.
JointFoam joint_foam(const sea::Realization& sea) {
    const FoamLawPtr law = make_foam_law(sea, foam_model);
    const sea::DirectSum sums[2] = {sea::DirectSum(tests::make_sea({sea.cascades[0]})),
                                    sea::DirectSum(tests::make_sea({sea.cascades[1]}))};
    constexpr int side = 64;
    constexpr double spacing_m = 7.31, tick_s = 0.2;
    JointFoam foam{law, std::vector<double>(side * side, law->mean_coverage), {}};
    for (int cascade = 0; cascade < 2; ++cascade)
        foam.histories.emplace_back(law, cascade, side, interval_us);
    const double remains = foam_remains(tick_s, foam_model.decay_s);
    for (int tick = 1; tick <= 120; ++tick) {
        const TimeUs time_us = tick * TimeUs{200'000};
        std::vector<sea::Keyframe> strains(2, uniform_strains(side, 0));
        const sea::DirectSum::Moment moments[2] = {sums[0].at_time(time_us),
                                                   sums[1].at_time(time_us)};
        for (std::size_t i = 0; i < foam.exact.size(); ++i) {
            const double x = spacing_m * static_cast<double>(i % side);
            const std::size_t row = i / side;
            const double y = spacing_m * static_cast<double>(row);
            sea::LagrangianPoint sum;
            for (std::size_t c = 0; c < 2; ++c) {
                const sea::LagrangianPoint p = moments[c].at(x, y);
                sum.strain_xx += p.strain_xx;
                sum.strain_yy += p.strain_yy;
                sum.strain_xy += p.strain_xy;
                strains[c].plane(Field::strain_xx)[i] = static_cast<float>(p.strain_xx);
                strains[c].plane(Field::strain_yy)[i] = static_cast<float>(p.strain_yy);
                strains[c].plane(Field::strain_xy)[i] = static_cast<float>(p.strain_xy);
            }
            const double short_of =
                std::max(0.0, *foam_model.threshold - sea::jacobian(sum, sea.choppiness));
            foam.exact[i] = foam.exact[i] * remains +
                            foam_model.gain_per_s * foam_model.decay_s * (1 - remains) * short_of;
        }
        for (std::size_t c = 0; c < 2; ++c) {
            strains[c].cascade = static_cast<int>(c);
            foam.histories[c].advance(strains[c], tick_s);
        }
    }
    return foam;
}

/// A guess of the coverage held against the exact one, point by point.
class Fit {
  public:
    void add(double value, double truth) {
        ++n_;
        sum_ += value;
        truth_ += truth;
        squares_ += value * value;
        truth_squares_ += truth * truth;
        cross_ += value * truth;
        difference_ += (value - truth) * (value - truth);
    }
    double ratio_of_means() const { return sum_ / truth_; }
    double correlation() const {
        return (cross_ / n_ - sum_ / n_ * truth_ / n_) /
               std::sqrt((squares_ / n_ - sum_ / n_ * sum_ / n_) *
                         (truth_squares_ / n_ - truth_ / n_ * truth_ / n_));
    }
    double difference() const { return difference_; } ///< summed squares

  private:
    double n_ = 0, sum_ = 0, truth_ = 0, squares_ = 0, truth_squares_ = 0, cross_ = 0;
    double difference_ = 0;
};

TEST(Foam, combined_histories_follow_one_history_of_the_joint_jacobian) {
    // Measured here: correlation 0.835; over more seas docs/foam.md.
    const JointFoam foam = joint_foam(*storm(0.03, 11));
    const double mean_coverage = foam.law->mean_coverage;
    Fit combined, sum_of_parts, product;
    for (std::size_t i = 0; i < foam.exact.size(); ++i) {
        const float ratios[2] = {foam.histories[0].ratios()[i], foam.histories[1].ratios()[i]};
        const double truth = std::clamp(foam.exact[i], 0.0, 1.0);
        combined.add(foam_coverage(mean_coverage, ratios), truth);
        product.add(std::min(1.0, mean_coverage * static_cast<double>(ratios[0] * ratios[1])),
                    truth);
        const double parts = mean_coverage * static_cast<double>(ratios[0] + ratios[1] - 1);
        sum_of_parts.add(std::clamp(parts, 0.0, 1.0), truth);
    }
    // 500 m of sea hold some dozens of breaking crests: 10 % for the mean over one moment.
    EXPECT_NEAR(combined.ratio_of_means(), 1.0, 0.1);
    EXPECT_GT(combined.correlation(), 0.8);
    EXPECT_GT(combined.correlation(), sum_of_parts.correlation());
    EXPECT_GT(combined.correlation(), product.correlation());
    EXPECT_LT(combined.difference(), sum_of_parts.difference());
    EXPECT_LT(combined.difference(), product.difference());
}

TEST(Foam, a_failing_device_is_reported_and_the_next_call_starts_anew) {
    const sea::RealizationPtr sea = storm();
    Strains strains(sea, 0);
    FoamHistory history(make_foam_law(*sea, foam_model), 0, 64, interval_us);
    int calls = 0;
    const Result<void> failed =
        history.advance_to(50'000'000, [&](TimeUs t) -> Result<sea::KeyframePtr> {
            if (++calls == 3)
                return Error{"device lost"};
            return strains.at(t);
        });
    ASSERT_FALSE(failed);
    EXPECT_EQ(failed.error().message, "device lost");
    ASSERT_TRUE(history.advance_to(50'000'000, strains.source()));
    EXPECT_EQ(strains.asked, 200); // ten decays of 4 s in ticks of 0.2 s
}

// A fused multiply-add rounds once where two operations round twice: 6e-8, in some ten operations.
TEST(Foam, every_instruction_set_gives_the_same_history) {
    const sea::RealizationPtr sea = storm();
    const FoamLawPtr law = make_foam_law(*sea, foam_model);
    Strains strains(sea, 0);
    FoamHistory portable(law, 0, 64, interval_us, Instructions::portable);
    ASSERT_TRUE(portable.advance_to(50'000'000, strains.source()));
    for (const Instructions instructions : supported_instructions()) {
        FoamHistory history(law, 0, 64, interval_us, instructions);
        ASSERT_TRUE(history.advance_to(50'000'000, strains.source()));
        for (std::size_t i = 0; i < history.ratios().size(); ++i)
            ASSERT_NEAR(history.ratios()[i], portable.ratios()[i],
                        1e-6 * (1 + static_cast<double>(portable.ratios()[i])))
                << name(instructions) << " at " << i;
    }
}

// Naive: strains of the first part for all of them.
TEST(Foam, parts_in_any_order_have_the_bits_of_the_whole) {
    const sea::RealizationPtr sea = storm();
    const FoamLawPtr law = make_foam_law(*sea, foam_model);
    constexpr int size = 128;
    Keyframe strains;
    strains.size = size;
    strains.fields = foam_inputs;
    tests::Draw draw(5);
    strains.values.resize(3 * strains.plane_size());
    for (float& value : strains.values)
        value = static_cast<float>(draw.uniform(-0.5, 0.5));
    const FoamTick tick = foam_tick(*law, 0, 0.7);
    const FoamView view{foam_tick(*law, 0, 0.9), 0.8f};
    for (const Instructions instructions : supported_instructions()) {
        FoamRatios whole(size, instructions), parts(size, instructions);
        std::vector<float> of_whole(strains.plane_size()), of_parts(strains.plane_size());
        for (int step = 0; step < 2; ++step) {
            whole.take(tick, &strains);
            whole.show(view, &strains, of_whole);
            for (int n = parts.parts(); n-- > 0;) {
                parts.take(tick, &strains, parts.part(n));
                parts.show(view, &strains, of_parts, parts.part(n));
            }
            EXPECT_TRUE(std::ranges::equal(whole.values(), parts.values())) << name(instructions);
            EXPECT_EQ(of_whole, of_parts) << name(instructions);
            EXPECT_NE(of_whole.front(), of_whole.back()) << "they differ from place to place";
        }
    }
}

TEST(Foam, one_interval_costs_one_keyframe) {
    const sea::RealizationPtr sea = storm();
    Strains strains(sea, 0);
    FoamHistory history(make_foam_law(*sea, foam_model), 0, 64, 500'000);
    ASSERT_TRUE(history.advance_to(50'000'000, strains.source()));
    strains.asked = 0;
    ASSERT_TRUE(history.advance_to(50'500'000, strains.source()));
    EXPECT_EQ(strains.asked, 1);
    ASSERT_TRUE(history.advance_to(50'500'000, strains.source()));
    EXPECT_EQ(strains.asked, 1) << "the same time again";
}

} // namespace
} // namespace seaway::sea
