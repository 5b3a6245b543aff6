// SPDX-License-Identifier: Apache-2.0
// Which sea runs when, and that one becomes the other without a jump.
#include <atomic>
#include <cmath>
#include <new>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "sea/scene/weather.h"
#include "sea/surface/steepest_sea.h"
#include "server/simulation/fetched_seas.h"
#include "server/simulation/sea_course.h"
#include "tests/server/simulation/simulation_bench.h"
#include "tests/support/allocations.h"

namespace seaway::server {
namespace {

sea::Scene windy(const sea::Scene& scene, const std::string& wind_mps) {
    const TomlAssignment wind{"systems.0.wind_speed_10m_mps", wind_mps};
    Result<sea::Scene> next = sea::changed(scene, {&wind, 1});
    EXPECT_TRUE(next) << (next ? "" : next.error().message);
    return *std::move(next);
}

double height_m(const SeaCourse& course, std::uint32_t epoch, TimeUs time_us) {
    return course.sea(epoch)->truth_at(time_us)->at(3.0, 4.0, time_us).height;
}

double hs_m(const SeaCourse& course, TimeUs time_us) {
    const sea::RealizationPtr waves = course.at(time_us)->waves_at(time_us);
    double m0 = 0;
    for (const sea::CascadeModes& modes : waves->cascades)
        for (const std::complex<double>& h0 : modes.h0)
            m0 += 2 * std::norm(h0);
    return 4 * std::sqrt(m0);
}

// Of a scene with a timetable: the last of what it asks for is what holds each row.
TEST(SeaCourse, a_change_for_which_there_is_no_memory_has_not_changed_anything) {
    std::string rows;
    for (int i = 0; i < 6; ++i)
        rows += "[[weather]]\nat_s = " + std::to_string(300 + 40 * i) +
                "\nover_s = 20\nset.systems.0.from_deg = " + std::to_string(250 + i) + "\n";
    const sea::Scene scene = small_scene(rows);
    const auto add = [&](SeaCourse& course) {
        return course.add(scene, 100 * second_us, 160 * second_us);
    };
    const auto whole = *SeaCourse::begin(small_scene());
    const tests::Allocations counted;
    ASSERT_TRUE(add(*whole));
    const std::size_t asked = counted.count();
    int failed = 0;
    for (std::size_t last = 1; last <= 12; ++last) {
        const auto course = *SeaCourse::begin(small_scene());
        try {
            const tests::NoMemoryOnce none(asked - last);
            (void)add(*course);
        } catch (const std::bad_alloc&) {
            ++failed;
            EXPECT_EQ(course->epochs(), 1u) << last;
            EXPECT_EQ(course->window(1).end_us, SeaCourse(course->first()).window(1).end_us);
            ASSERT_TRUE(add(*course));
        }
        ASSERT_EQ(course->epochs(), whole->epochs()) << last;
        for (std::uint32_t epoch = 1; epoch <= whole->epochs(); ++epoch) {
            EXPECT_EQ(course->window(epoch).start_us, whole->window(epoch).start_us);
            EXPECT_EQ(course->window(epoch).end_us, whole->window(epoch).end_us);
        }
        // From which sea a glide comes follows from how many changes there were.
        const TimeUs glides_us = whole->window(4).start_us + 10 * second_us;
        if (last == 1) { // all rows but one were held
            EXPECT_EQ(height_m(*course, 4, glides_us), height_m(*whole, 4, glides_us));
        }
        EXPECT_EQ(course->glides_in_row(110 * second_us), 1) << last;
    }
    EXPECT_EQ(failed, 12);
}

TEST(SeaCourse, a_change_is_a_glide_and_the_sea_that_it_leads_to) {
    const auto course = *SeaCourse::begin(small_scene());
    ASSERT_TRUE(course->add(windy(small_scene(), "14.0"), 100 * second_us, 160 * second_us));
    EXPECT_EQ(course->epochs(), 3u);
    EXPECT_EQ(course->at(99 * second_us)->epoch, 1u);
    EXPECT_EQ(course->at(100 * second_us)->epoch, 2u);
    EXPECT_EQ(course->at(160 * second_us - 1)->epoch, 2u);
    EXPECT_EQ(course->at(160 * second_us)->epoch, 3u);
    EXPECT_EQ(course->window(2).end_us, 160 * second_us);
    // Half of the amplitudes in the middle: all waves of both seas have the same numbers.
    const double first = hs_m(*course, 0), last = hs_m(*course, 200 * second_us);
    EXPECT_GT(last, 1.5 * first);
    EXPECT_GT(hs_m(*course, 130 * second_us), first);
    EXPECT_LT(hs_m(*course, 130 * second_us), last);
    // The sea that it leads to is that of its scene alone, bit for bit.
    EXPECT_EQ(course->sea(3)->realization->cascades[0].h0,
              (*make_running_sea(windy(small_scene(), "14.0"), 1))->realization->cascades[0].h0);
}

// What every epoch is beyond its window joins the next one: both keyframes of an interval are of one sea.
TEST(SeaCourse, seas_of_neighbouring_epochs_are_one_where_they_meet) {
    const auto course = *SeaCourse::begin(small_scene());
    sea::Scene shallow = windy(small_scene(), "13.0");
    shallow.sea.depth_m = 15.0; // other frequencies
    ASSERT_TRUE(course->add(shallow, 100 * second_us, 130 * second_us));
    ASSERT_TRUE(course->add(windy(shallow, "5.0"), 115 * second_us, 140 * second_us)); // takes over
    ASSERT_TRUE(course->add(small_scene(), 200 * second_us, 230 * second_us));
    EXPECT_TRUE(course->window(3).empty()) << "another took over before it began";
    const auto windows = course->windows(0, 1000 * second_us);
    ASSERT_EQ(windows.size(), 6u);
    for (std::size_t i = 1; i < windows.size(); ++i) {
        const TimeUs at_us = windows[i].start_us;
        EXPECT_EQ(windows[i - 1].end_us, at_us);
        // A centimetre a second at most, from the glide's slope, in a microsecond.
        EXPECT_NEAR(height_m(*course, windows[i - 1].epoch, at_us),
                    height_m(*course, windows[i].epoch, at_us), 1e-9)
            << windows[i].epoch;
    }
}

TEST(SeaCourse, the_same_log_is_the_same_sea_whatever_was_asked_before) {
    const auto replayed = [](bool asked_along) {
        const auto course = *SeaCourse::begin(small_scene());
        sea::Scene scene = small_scene();
        for (int i = 0; i < 8; ++i) {
            scene.sea.depth_m = i % 2 ? 20.0 : 40.0; // phases hang on each other
            scene = windy(scene, std::to_string(6 + i) + ".5");
            EXPECT_TRUE(course->add(scene, (100 + 40 * i) * second_us, (150 + 40 * i) * second_us));
            if (asked_along)
                (void)course->at((120 + 40 * i) * second_us);
        }
        return course;
    };
    const auto one = replayed(true), other = replayed(false);
    for (const TimeUs time_us :
         {420 * second_us, 110 * second_us, 1000 * second_us, 250 * second_us})
        EXPECT_EQ(one->at(time_us)->truth_at(time_us)->at(1, 2, time_us).height,
                  other->at(time_us)->truth_at(time_us)->at(1, 2, time_us).height)
            << time_us;
}

TEST(SeaCourse, a_timetable_brings_its_storm_by_itself) {
    const auto course = *SeaCourse::begin(small_scene(R"(
[[weather]]
at_s = 60
over_s = 20
set = { sea.system.0.wind_speed_10m_mps = 16 }
[[weather]]
at_s = 100
over_s = 30
set.systems.0.wind_speed_10m_mps = 5
)"));
    EXPECT_EQ(course->epochs(), 5u);
    const double calm = hs_m(*course, 0), storm = hs_m(*course, 90 * second_us);
    EXPECT_GT(storm, 1.8 * calm);
    EXPECT_LT(hs_m(*course, 200 * second_us), calm);
    // A change by hand ends the timetable from its start on.
    ASSERT_TRUE(course->add(windy(small_scene(), "16"), 90 * second_us, 110 * second_us));
    EXPECT_GT(hs_m(*course, 200 * second_us), 1.8 * calm);
    EXPECT_TRUE(course->window(4).empty());
}

TEST(SeaCourse, what_cannot_change_while_a_sea_runs_is_refused_by_name_and_changes_nothing) {
    const auto course = *SeaCourse::begin(small_scene());
    const auto refused = [&](const sea::Scene& scene) {
        const Result<void> added = course->add(scene, 100 * second_us, 130 * second_us);
        return added ? std::string("taken") : added.error().message;
    };
    sea::Scene other = small_scene();
    other.cascades[0].size = 128;
    EXPECT_EQ(refused(other).substr(0, 7), "cascade");
    other = small_scene();
    other.effects.foam = false;
    EXPECT_EQ(refused(other).substr(0, 7), "effects");
    other = small_scene();
    other.accuracy.height_error_m = 0.5;
    EXPECT_EQ(refused(other).substr(0, 8), "accuracy");
    other = small_scene();
    other.accuracy.certificate.name = "c.json";
    EXPECT_EQ(refused(other).substr(0, 20), "accuracy.certificate") << refused(other);
    other = small_scene();
    other.foam.decay_s = 1;
    EXPECT_EQ(refused(other).substr(0, 12), "foam.decay_s");
    other = small_scene();
    other.sea.loop_period_s = 60;
    EXPECT_NE(refused(other).find("loop_period_s"), std::string::npos);
    other = small_scene();
    sea::ExplicitModes modes;
    modes.length_m = 77;
    modes.modes = {{1, 0, 0.5, 0.0}};
    other.sea.systems.emplace_back(modes);
    EXPECT_NE(refused(other).find("tiles"), std::string::npos) << refused(other);
    EXPECT_EQ(course->epochs(), 1u);
}

/// Slopes of 1.3e6 at 100 m.
sea::Scene steep_scene(double amplitude_m) {
    sea::Scene steep = small_scene();
    steep.sea.systems.clear();
    sea::ExplicitModes modes;
    modes.length_m = 0.1;
    modes.modes = {{300, 0, amplitude_m, 0.0}};
    steep.sea.systems.emplace_back(modes);
    steep.cascades = {{0.1, 1024}};
    return steep;
}

// Naive: it is run, told and journalled, and no client takes what it is told.
TEST(SeaCourse, a_sea_that_no_client_takes_is_refused_by_name) {
    const auto refused = make_running_sea(steep_scene(100), 1);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("rms slope = "), std::string::npos)
        << refused.error().message;
}

// Naive: the scene is fine, and the server ends when it comes to the row, or, with a journal, each time that it is started.
TEST(SeaCourse, a_row_of_the_weather_that_no_client_takes_is_refused_by_name) {
    sea::Scene scene = steep_scene(10);
    scene.weather = {{.at_s = 100, .over_s = 30, .set = {{"sea.height_scale", "10.0"}}}};
    const auto refused = SeaCourse::begin(scene);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("weather[1]: its waves are too steep for tiles"),
              std::string::npos)
        << refused.error().message;
}

// Naive: between two seas that are as steep as can be waves are as steep as both together, and the glide cannot be told.
TEST(SeaCourse, every_glide_between_two_seas_that_run_can_be_told) {
    const auto run = [](double amplitude_m) {
        return make_running_sea(steep_scene(amplitude_m), 1).has_value();
    };
    double most_m = 1, refused_m = 100;
    while (refused_m > 1.001 * most_m) {
        const double middle_m = std::sqrt(most_m * refused_m);
        (run(middle_m) ? most_m : refused_m) = middle_m;
    }
    const auto course = *SeaCourse::begin(steep_scene(most_m));
    sea::Scene across = steep_scene(most_m);
    std::get<sea::ExplicitModes>(across.sea.systems[0]).modes = {{0, 300, most_m, 0.0}};
    ASSERT_TRUE(course->add(across, 100 * second_us, 110 * second_us));
    const sea::ErrorBudget& glide = course->sea(2)->budget;
    EXPECT_GT(glide.rms_slope, 1.4 * course->sea(1)->budget.rms_slope);
    EXPECT_LT(glide.rms_slope, sea::told_slope_max);
    EXPECT_LT(glide.curvature_per_m, sea::told_curvature_per_m_max);
    EXPECT_LT(glide.interpolation_m, sea::told_error_m_max);
    EXPECT_LT(glide.rms_strain, sea::told_sideways_max);
}

// Naive: a log that another version wrote ends the server each time that it is started.
TEST(SeaCourse, what_a_log_holds_runs_however_steep_it_is) {
    const auto course = *SeaCourse::begin(steep_scene(1));
    ASSERT_TRUE(course->add(steep_scene(100), 100 * second_us, 110 * second_us));
    for (const std::uint32_t epoch : {2u, 3u})
        EXPECT_EQ(course->sea(epoch)->budget.rms_slope, sea::told_slope_max);
}

// Of a change between two equally high seas of other directions the envelope is as high as both together.
TEST(SeaCourse, the_bounds_of_a_glide_hold_the_waves_of_both_seas) {
    const auto course = *SeaCourse::begin(small_scene());
    sea::Scene low = windy(small_scene(), "3.0");
    ASSERT_TRUE(course->add(low, 100 * second_us, 130 * second_us));
    const sea::ErrorBudget &high_b = course->sea(1)->budget, &glide = course->sea(2)->budget,
                           &low_b = course->sea(3)->budget;
    EXPECT_GT(high_b.displacement_reach_m, 1.5 * low_b.displacement_reach_m);
    EXPECT_EQ(course->sea(2)->glide->realised.significant_height_m,
              course->sea(1)->summary.realised.significant_height_m);
    EXPECT_GE(glide.displacement_reach_m, 0.999 * high_b.displacement_reach_m);
    for (std::size_t c = 0; c < 2; ++c) {
        EXPECT_LE(glide.cascades[c].interval_us, high_b.cascades[c].interval_us);
        EXPECT_GE(glide.cascades[c].loss.height.east_m,
                  0.999 * high_b.cascades[c].loss.height.east_m);
    }
}

// Naive: each sea reads the file that its scene names, days later, when it may have gone.
TEST(SeaCourse, seas_to_come_have_the_certificate_that_was_read_at_the_start) {
    RunningSea first = **make_running_sea(small_scene(), 1);
    first.scene.accuracy.certificate = {"c.json", "no_such_folder/c.json"};
    first.certificate = std::make_shared<const sea::Certificate>();
    SeaCourse course(std::make_shared<const RunningSea>(first));
    sea::Scene next = windy(small_scene(), "11");
    ASSERT_TRUE(course.add(next, 100 * second_us, 130 * second_us));
    next.accuracy.certificate = first.scene.accuracy.certificate;
    ASSERT_TRUE(course.add(next, 200 * second_us, 230 * second_us));
    EXPECT_EQ(course.at(150 * second_us)->certificate, nullptr) << "its scene names none";
    EXPECT_EQ(course.at(250 * second_us)->certificate, first.certificate);
}

// Naive: each of the threads that answer makes the sea that its question is of, and none is left for those whose sea is there.
TEST(SeaCourse, while_one_thread_makes_a_sea_no_other_waits_for_it_that_does_not_want_to) {
    const auto course = *SeaCourse::begin(small_scene());
    for (int i = 1; i <= 60; ++i)
        ASSERT_TRUE(course->add(windy(small_scene(), std::to_string(5 + i % 9)),
                                100 * i * second_us, (100 * i + 20) * second_us));
    std::atomic<int> told = 0;
    course->when_made([&told] { ++told; });
    bool refused = false;
    for (std::uint32_t epoch = 2; epoch < 120 && !refused; epoch += 2) {
        std::thread maker([&] { (void)course->sea(epoch); });
        while (!course->is_making() && !course->sea_if_held(epoch)) {
        }
        refused = course->sea_unless_making(121) == nullptr;
        maker.join();
        if (!refused) { // too late: it was there already, and this thread made the other
            EXPECT_NE(course->sea_if_held(121), nullptr);
            for (std::uint32_t other = 100; other < 110; ++other)
                (void)course->sea(other);
        }
    }
    EXPECT_TRUE(refused);
    EXPECT_GT(told, 0) << "so that who was refused comes back";
    EXPECT_FALSE(course->is_making());
    EXPECT_NE(course->sea_unless_making(121), nullptr);
    course->when_made(nullptr);
}

// Naive: a log of a month is a month of seas in memory.
TEST(SeaCourse, seas_are_let_go_and_made_again) {
    const auto course = *SeaCourse::begin(small_scene());
    std::weak_ptr<const RunningSea> early;
    for (int i = 1; i <= 10; ++i) {
        ASSERT_TRUE(course->add(windy(small_scene(), std::to_string(5 + i)), 100 * i * second_us,
                                (100 * i + 20) * second_us));
        if (i == 1)
            early = course->at(130 * second_us);
    }
    const auto was = early.lock() ? early.lock()->realization->cascades[1].h0
                                  : std::vector<std::complex<double>>{};
    for (int i = 1; i <= 10; ++i)
        (void)course->at((100 * i + 50) * second_us);
    EXPECT_TRUE(early.expired());
    EXPECT_EQ(course->at(130 * second_us)->realization->cascades[1].h0, was);
}

// Naive: ten decay times back, the seas of a whole log, which cost as little as those of the time itself.
TEST(FetchedSeas, of_foam_are_those_that_it_remembers_and_are_paid_for) {
    const sea::Scene scene = small_scene("[foam]\nthreshold = 0.8\ndecay_s = 1e5\n");
    const auto course = *SeaCourse::begin(scene);
    for (int i = 0; i < 60; ++i)
        ASSERT_TRUE(course->add(scene, (100 * i + 50) * second_us, (100 * i + 70) * second_us));
    const std::vector<TimeUs> end_us{6000 * second_us};
    TimeUs tick_us = 0;
    for (const sea::CascadeBudget& cascade : course->first()->budget.cascades)
        tick_us = std::max(tick_us, sea::foam_tick_min_us + cascade.interval_us);
    // A change each 100 s, of two seas; at either end the walk is in the middle of one.
    const std::int64_t remembered = 2 * (sea::foam_ticks_max * tick_us / (100 * second_us) + 2);
    ASSERT_LT(remembered, 40) << "of 121";
    const double price_us = Prices(course).fetch_us(
        end_us, {3u, {Field::foam}}, [](const KeyframeRequest&) { return Holding::spline; });
    FetchedSeas seas(*course, end_us, {Field::foam});
    int made = 0;
    for (; !seas.are_there(); ++made)
        seas.make_some();
    EXPECT_LE(made, remembered);
    EXPECT_GT(made, 2);
    EXPECT_GE(price_us, made * 2 * 64.0 * 64.0 * price_sea_wave_us);
    const std::vector<std::uint32_t> epochs = fetched_epochs(*course, end_us, {Field::foam});
    EXPECT_LT(epochs.size(), seas_kept);
    for (const std::uint32_t epoch : epochs)
        EXPECT_NE(course->sea_if_held(epoch), nullptr) << epoch << " is used next";
    FetchedSeas heights(*course, end_us, {Field::height});
    EXPECT_TRUE(heights.are_there());
}

} // namespace
} // namespace seaway::server
